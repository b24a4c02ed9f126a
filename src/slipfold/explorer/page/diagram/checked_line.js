/** What was computed again by other means, in a sentence; in red where it does not agree. */

import { element } from "../controls/dom.js";

export class CheckedLine {
  /** The element to put on the page. */
  node = element("p", { class: "checked" });

  /** @param {{sentence: string, agree: boolean}|null} [checked] the server's */
  show(checked = null) {
    const sentence = checked?.sentence ?? "";
    this.node.textContent = sentence && `${sentence[0].toUpperCase()}${sentence.slice(1)}.`;
    this.node.title = this.node.textContent;
    this.node.classList.toggle("disagrees", checked?.agree === false);
  }
}
