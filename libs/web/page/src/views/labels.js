// Words that stand at places of the map.
import { Vector3 } from "three";
import { el } from "../dom.js";

const most = 24; // of one kind
const always = ["pin", "measure"];

export class Labels {
  #labels = [];

  constructor(stage, host) {
    Object.assign(this, { stage, host });
    stage.beforeFrame(() => this.#place());
  }

  /** @param {string} kind what clear() takes away together */
  add(kind, position, text) {
    if (this.#labels.filter((label) => label.kind === kind).length >= most) return;
    const element = el("div", { class: `label ${kind}`, text });
    this.host.append(element);
    const { offsetWidth: width, offsetHeight: height } = element;
    this.#labels.push({ kind, position, element, width, height });
    this.stage.refresh();
  }

  clear(kind) {
    for (const label of this.#labels) if (label.kind === kind) label.element.remove();
    this.#labels = this.#labels.filter((label) => label.kind !== kind);
    this.stage.refresh();
  }

  /** The nearest first; what would lie over another one is not shown. */
  #place() {
    const { clientWidth, clientHeight } = this.host;
    const at = new Vector3();
    const placed = [];
    for (const label of this.#labels) {
      at.copy(label.position).project(this.stage.camera);
      Object.assign(label, { x: ((at.x + 1) / 2) * clientWidth, y: ((1 - at.y) / 2) * clientHeight, depth: at.z });
    }
    const rank = ({ kind, depth }) => (always.includes(kind) ? depth - 10 : depth);
    for (const label of [...this.#labels].sort((a, b) => rank(a) - rank(b))) {
      const { x, y, width, height, element, kind } = label;
      const inSight = label.depth < 1 && x > 0 && y > 0 && x < clientWidth && y < clientHeight;
      const isCovered = placed.some((other) => Math.abs(other.x - x) < (other.width + width) / 2 && Math.abs(other.y - y) < (other.height + height) / 2);
      element.hidden = !inSight || (isCovered && !always.includes(kind));
      if (element.hidden) continue;
      element.style.transform = `translate(${x}px, ${y}px) translate(-50%, -130%)`;
      placed.push(label);
    }
  }
}
