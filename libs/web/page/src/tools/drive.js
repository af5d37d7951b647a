// Driving by keys that are held and by a pad that is touched. A dead man's switch: the robot is told to go only while
// something is held and this page is in sight and in focus; then it is told to stop.
import { el } from "../dom.js";

const period = 100; // ms between what is sent; the server stops after 300
const mostUnanswered = 10; // a second's: over a link that stands they would all come later, when nobody means them
const keys = { w: [1, 0], ArrowUp: [1, 0], s: [-1, 0], ArrowDown: [-1, 0], a: [0, 1], ArrowLeft: [0, 1], d: [0, -1], ArrowRight: [0, -1] };
const modifiers = ["Control", "Alt", "AltGraph", "Meta"];

/** Whether a key may come with another name when it is let go, or, beside macOS's Cmd, not at all. */
function isModified(event) {
  return modifiers.includes(event.key) || modifiers.some((name) => event.getModifierState?.(name));
}

export class Drive {
  #held = new Map(); // what each key wants; keys by their place, since modifiers change their names
  #stick = null; // [linear, angular] of the pad
  #timer = 0;
  #unanswered = 0;

  constructor({ host, card, command, notify }) {
    Object.assign(this, { card, command, notify });
    this.knob = el("span", { class: "knob" });
    this.pad = el("div", { class: "pad", role: "application", tabindex: 0, "aria-label": "Driving pad: hold and drag, or hold the keys W A S D or the arrows", hidden: true }, this.knob);
    host.append(this.pad);
    this.pad.addEventListener("contextmenu", (event) => event.preventDefault()); // while it is open nothing is let go
    this.pad.addEventListener("pointerdown", (event) => {
      if (event.button !== 0) return;
      this.pad.setPointerCapture(event.pointerId);
      this.#touch(event);
    });
    this.pad.addEventListener("pointermove", (event) => this.#stick && this.#touch(event));
    for (const end of ["pointerup", "pointercancel", "lostpointercapture"]) this.pad.addEventListener(end, () => this.#letGo());
    for (const change of ["keydown", "keyup"]) addEventListener(change, (event) => isModified(event) && this.stop());
    addEventListener("blur", () => this.stop());
    addEventListener("pagehide", () => this.stop());
    document.addEventListener("visibilitychange", () => document.hidden && this.stop());
  }

  get isOn() {
    return !this.pad.hidden;
  }

  enter() {
    this.pad.hidden = false;
    this.card.show("Drive", [["Hold", "W A S D, the arrows or the pad"], ["Let go", "and the robot stops"]], () => this.done());
  }

  leave() {
    this.stop();
    this.pad.hidden = true;
    this.card.hide();
  }

  /** @returns {boolean} whether the key is one that drives */
  key(event) {
    const wanted = keys[event.key.length === 1 ? event.key.toLowerCase() : event.key];
    if (!wanted) return false;
    // After a stop only a new press drives on, not the repetition of one that is still held.
    if (!event.repeat && !isModified(event)) this.#held.set(event.code, wanted);
    this.#go();
    return true;
  }

  keyUp(event) {
    if (this.#held.delete(event.code)) this.#go();
  }

  /** Nothing is held any more. */
  stop() {
    this.#held.clear();
    this.#letGo();
  }

  #touch({ clientX, clientY }) {
    const box = this.pad.getBoundingClientRect();
    const limit = (value) => Math.max(-1, Math.min(1, value));
    const across = limit((clientX - box.left - box.width / 2) / (box.width / 2));
    const up = limit((box.top + box.height / 2 - clientY) / (box.height / 2));
    this.#stick = [up, -across];
    this.#place(across, up);
    this.#go();
  }

  #letGo() {
    this.#stick = null;
    this.#place(0, 0);
    this.#go();
  }

  #place(across, up) {
    this.knob.style.transform = `translate(${across * 40}px, ${-up * 40}px)`;
  }

  /** Sends at once, then again and again while something is held; what stops is sent once. */
  #go(isTurn = false) {
    const wanted = this.#wanted();
    const running = this.#timer !== 0;
    if (wanted && running && !isTurn) return;
    if (wanted && !running) this.#timer = setInterval(() => this.#go(true), period);
    if (!wanted && !running) return;
    if (!wanted) {
      clearInterval(this.#timer);
      this.#timer = 0;
    }
    if (wanted && this.#unanswered >= mostUnanswered) return this.#halt("the map server answers late");
    const [linear, angular] = wanted ?? [0, 0];
    this.#unanswered += 1;
    this.command.do("drive", { linear, angular })
      .catch((error) => wanted && this.#halt(error.message))
      .finally(() => (this.#unanswered -= 1));
  }

  /** Only a new press drives on. */
  #halt(why) {
    this.stop();
    this.notify("bad", `Driving has stopped: ${why}`);
  }

  /** @returns {number[]|null} what is held, null for nothing or where nobody looks */
  #wanted() {
    if (!this.isOn || document.hidden || !document.hasFocus()) return null;
    if (this.#stick) return this.#stick;
    if (this.#held.size === 0) return null;
    const sum = [...this.#held.values()].reduce(([l, a], [linear, angular]) => [l + linear, a + angular], [0, 0]);
    return sum.map((value) => Math.max(-1, Math.min(1, value)));
  }
}
