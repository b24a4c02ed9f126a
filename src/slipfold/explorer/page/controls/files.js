/** Handing things out: downloads and the clipboard. */

/**
 * Save something as a file.
 * @param {Blob} blob
 * @param {string} name
 */
export function download(blob, name) {
  const address = URL.createObjectURL(blob);
  const link = document.createElement("a");
  link.href = address;
  link.download = name;
  link.click();
  setTimeout(() => URL.revokeObjectURL(address), 10_000);
}

/**
 * Put text on the clipboard.
 * @param {string} text
 * @returns {Promise<boolean>} whether it is there
 */
export async function copy(text) {
  try {
    await navigator.clipboard.writeText(text);
    return true;
  } catch {
    return false;
  }
}

/**
 * Ask the server for a view in another form.
 * @param {object} view the request that made it
 * @param {"python"|"toml"|"csv"|"nc"} format
 * @param {string|null} [readings] name of the file whose readings are drawn on it
 * @returns {Promise<Response>}
 * @throws {Error} with the server's sentence
 */
export async function exported(view, format, readings = null) {
  return posted("/api/export", JSON.stringify({ view: { id: 0, ...view }, format, readings }));
}

/**
 * Send JSON to the server.
 * @param {string} address
 * @param {string} body
 * @returns {Promise<Response>}
 * @throws {Error} with the server's sentence
 */
export async function posted(address, body) {
  const response = await fetch(address, { method: "POST", headers: { "Content-Type": "application/json" }, body });
  if (!response.ok) throw new Error(await sentenceOf(response));
  return response;
}

async function sentenceOf(response) {
  const text = await response.text();
  try {
    const { error, detail } = JSON.parse(text);
    return [error, detail].find((part) => typeof part === "string") ?? text;
  } catch {
    return text;
  }
}
