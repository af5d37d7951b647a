// The card at the foot of the map: what a tool says. And short words that go by themselves.
import { el, iconButton, levelMark } from "./dom.js";

export class ToolCard {
  constructor(host) {
    this.title = el("h2");
    this.list = el("dl");
    this.close = () => {};
    this.element = el("div", { class: "tool-card", role: "region", "aria-label": "Tool", "aria-live": "polite", hidden: true },
      el("div", { class: "first" }, this.title, iconButton("close", "Close (Esc)", () => this.close(), { class: "tool small" })), this.list);
    host.append(this.element);
  }

  /** @param {string[][]} rows name and value */
  show(title, rows, close) {
    this.title.textContent = title;
    this.list.replaceChildren(...rows.flatMap(([name, value]) => [el("dt", { text: name }), el("dd", { text: value })]));
    this.close = close;
    this.element.hidden = false;
  }

  hide() {
    this.element.hidden = true;
  }
}

const patience = 6000; // ms that words stand

/** @returns {(level: string, words: string) => void} */
export function notifier(host) {
  const list = el("div", { class: "toasts", role: "status", "aria-live": "polite" });
  host.append(list);
  return (level, words) => {
    const toast = el("div", { class: `toast ${level}` }, levelMark(level), el("span", { text: words }));
    list.append(toast);
    while (list.children.length > 3) list.firstChild.remove();
    setTimeout(() => toast.remove(), patience);
  };
}
