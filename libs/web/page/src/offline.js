// The page as one file (`export --html`): all messages stand in it.
import { decode, splitItems } from "./messages.js";

/** @returns {object[]|null} the messages that this page carries, null where it is served */
export function carriedItems() {
  const element = document.getElementById("lcmslam-items");
  if (!element) return null;
  const items = [...splitItems(fromBase64(element.textContent))].map(decode);
  element.remove(); // so much text is not kept twice
  return items;
}

function fromBase64(text) {
  const clean = text.replace(/\s+/g, "");
  if (Uint8Array.fromBase64) return Uint8Array.fromBase64(clean);
  const letters = atob(clean);
  const data = new Uint8Array(letters.length);
  for (let i = 0; i < data.length; ++i) data[i] = letters.charCodeAt(i);
  return data;
}
