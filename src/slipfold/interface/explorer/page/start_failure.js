/**
 * Shows why the page did not start: whatever was thrown, or could not be loaded, before it stood.
 * No module, and loaded before all others, so that it hears of a module that cannot be read.
 */

(() => {
  const reasonOf = ({ target, error, reason, message }) => {
    const address = target?.src ?? target?.href;
    if (address) return `${new URL(address).pathname} could not be loaded`;
    return String(reason ?? error ?? message);
  };

  const show = (event) => {
    const page = document.getElementById("page");
    if (!page || "started" in page.dataset) return;
    const text = document.createElement("p");
    text.className = "notice failure";
    text.setAttribute("role", "alert");
    text.textContent = `The page could not start: ${reasonOf(event)}. Reload it; if that does not help, this is a defect of slipfold.`;
    page.replaceChildren(text);
  };

  // The error of a script or a style sheet that cannot load does not bubble: the window hears it only as it captures.
  window.addEventListener("error", show, true);
  window.addEventListener("unhandledrejection", show);
})();
