// What stands in the middle while there is nothing to see.
import { el } from "./dom.js";

export function emptyState(host, board) {
  const words = el("p");
  const element = el("div", { class: "nothing", role: "status" }, words);
  host.append(element);
  const something = { points: 0, mesh: 0, landmarks: 0, path: 0 };
  const draw = () => {
    const about = board.get("about")?.header;
    element.hidden = Object.values(something).some((n) => n > 0);
    words.textContent = !about
      ? "Connecting to the map server…"
      : about.source === "file"
        ? "This map is empty."
        : "Waiting for the mapper's first keyframe.";
  };
  for (const channel of Object.keys(something)) {
    const keys = new Set();
    board.on(channel, (item, key) => {
      if (item) keys.add(key);
      else keys.delete(key);
      something[channel] = keys.size;
      draw();
    });
  }
  board.on("about", draw);
  draw();
}
