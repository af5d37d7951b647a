// A picture of what is seen, as a PNG.
import { el } from "../dom.js";

export function snapshot(stage) {
  stage.draw(); // the picture lasts only until the browser has shown it
  stage.canvas.toBlob((blob) => {
    const address = URL.createObjectURL(blob);
    const name = `lcmslam-${new Date().toISOString().slice(0, 19).replace(/[:T]/g, "-")}.png`;
    el("a", { href: address, download: name }).click();
    setTimeout(() => URL.revokeObjectURL(address), 10_000);
  }, "image/png");
}
