// The keyboard: one table of keys, which the help shows.
import { el, iconButton } from "./dom.js";
import { views } from "./camera.js";
import { layers } from "./switches.js";
import { toggleTheme } from "./theme.js";
import { snapshot } from "./tools/snapshot.js";

/** Layers with a key, 1 to 9 and 0 as on the keyboard. */
function byKey(list) {
  const place = ({ key }) => (Number(key) + 9) % 10;
  return list.filter(({ key }) => key).sort((a, b) => place(a) - place(b));
}

export class Keys {
  #actions = new Map();

  constructor({ stage, view, switches, hand, share }) {
    Object.assign(this, { hand, view });
    const turn = 0.12;
    const rows = [
      ["Arrows", "turn the view", { ArrowLeft: () => view.orbit(-turn, 0), ArrowRight: () => view.orbit(turn, 0), ArrowUp: () => view.orbit(0, turn / 2), ArrowDown: () => view.orbit(0, -turn / 2) }],
      ["+ −", "nearer, farther", { "+": () => view.zoom(0.85), "=": () => view.zoom(0.85), "-": () => view.zoom(1.18) }],
      ["W A S D", "move the view; drive, while driving", { w: () => view.pan(0, 0.05), s: () => view.pan(0, -0.05), a: () => view.pan(0.05, 0), d: () => view.pan(-0.05, 0) }],
      ...Object.entries(views).map(([name, { label, key }]) => [key.toUpperCase(), name === "free" ? "the whole map" : label.toLowerCase(), { [key]: () => (name === "free" ? view.fitAll() : view.show(name)) }]),
      ["O", "follow the robot", { o: () => view.setFollow(!view.follow) }],
      ["M", "measure", { m: () => hand.take("measure") }],
      ["G", "send the robot somewhere", { g: () => this.#take("goto") }],
      ["X", "drive", { x: () => this.#take("drive") }],
      ["P", "save a picture", { p: () => snapshot(stage) }],
      ["L", "copy the address of this view", { l: share }],
      ["B", "dark or light", { b: toggleTheme }],
      ...byKey(layers).map(({ name, label, aloud, key }) => [key, (aloud ?? label).toLowerCase(), { [key]: () => switches.toggle(name) }]),
      ["Enter", "press the middle of the view with the tool in hand", { Enter: () => this.#pressMiddle() }],
      ["?", "these keys", { "?": () => this.help() }],
      ["Esc", "lay the tool down", { Escape: () => hand.take(null) }],
    ];
    for (const [, , actions] of rows) for (const [key, act] of Object.entries(actions)) this.#actions.set(key, act);
    this.sheet = this.#sheet(rows);
    addEventListener("keydown", (event) => this.#down(event));
    addEventListener("keyup", (event) => hand.tools.drive.keyUp(event));
  }

  help() {
    if (this.sheet.open) this.sheet.close();
    else this.sheet.showModal();
  }

  #take(name) {
    const button = document.querySelector(`[data-tool="${name}"]`);
    if (!button.hidden) this.hand.take(name); // only what the server can
  }

  /** What a pointer does, without one. */
  #pressMiddle() {
    const { camera, canvas } = this.view.stage;
    const box = canvas.getBoundingClientRect();
    const middle = this.view.target.clone().project(camera);
    const event = { clientX: box.left + ((middle.x + 1) / 2) * box.width, clientY: box.top + ((1 - middle.y) / 2) * box.height };
    if (this.hand.press(event)) this.hand.release(event, false);
    else this.hand.click(event);
  }

  #down(event) {
    if (!event.key || event.ctrlKey || event.metaKey || event.altKey || event.target.matches("input, textarea, dialog[open] *")) return;
    const { drive } = this.hand.tools;
    if (drive.isOn && drive.key(event)) return event.preventDefault();
    const onButton = event.target.matches("button") && (event.key === " " || event.key === "Enter");
    const act = this.#actions.get(event.key) ?? this.#actions.get(event.key.toLowerCase());
    if (!act || onButton) return;
    event.preventDefault();
    act();
  }

  #sheet(rows) {
    const list = el("dl", {}, ...rows.flatMap(([key, what]) => [el("dt", {}, el("kbd", { text: key })), el("dd", { text: what })]));
    const sheet = el("dialog", { class: "sheet", "aria-label": "Keys" },
      el("div", { class: "first" }, el("h2", { text: "Keys" }), iconButton("close", "Close", () => sheet.close(), { class: "tool small" })), list,
      el("p", { class: "fine", text: "Pointer: drag to turn, with the right button or Shift to move, wheel to zoom, click for what is there. Touch: one finger turns, two move, zoom and turn." }));
    sheet.addEventListener("click", (event) => event.target === sheet && sheet.close());
    document.body.append(sheet);
    return sheet;
  }
}
