// The panels: a column of cards that fold beside the map; on a phone a sheet below it with a tab for each group.
import { el, icon } from "../dom.js";
import { recall, remember } from "../memory.js";

const tabs = [
  { id: "view", label: "View", icon: "layers" },
  { id: "camera", label: "Camera", icon: "camera" },
  { id: "poses", label: "Robot", icon: "poses" },
  { id: "map", label: "Map", icon: "map" },
  { id: "health", label: "Health", icon: "health" },
];

export class Column {
  #cards = [];
  #tab = null;

  /** @param {() => void} resized called when the column covers more or less of the page */
  constructor(host, resized) {
    Object.assign(this, { host, resized });
    this.cards = el("div", { class: "cards" });
    this.bar = el("div", { class: "tabs", role: "group", "aria-label": "Panels" });
    for (const tab of tabs) {
      const button = el("button", { type: "button", "aria-expanded": "false", on: { click: () => this.open(this.#tab === tab.id ? null : tab.id) } },
        icon(tab.icon), el("span", { text: tab.label }));
      button.dataset.tab = tab.id;
      this.bar.append(button);
    }
    host.append(this.cards, this.bar);
  }

  /**
   * @param {string} tab one of `tabs`
   * @param {boolean} folded at the beginning, where the reader has not chosen otherwise
   * @returns {{body: HTMLElement, setTitle: Function, setNote: Function, show: Function}}
   */
  card(id, tab, title, folded = false) {
    const open = (recall(`fold-${id}`) ?? String(folded)) !== "true";
    const note = el("span", { class: "note" });
    const body = el("div", { class: "body", id: `card-${id}` });
    const head = el("button", { type: "button", class: "head", "aria-expanded": String(open), "aria-controls": `card-${id}` },
      el("span", { class: "title", text: title }), note, icon("fold"));
    const card = el("section", { class: "card", "aria-label": title }, head, body);
    card.dataset.tab = tab;
    const fold = (isOpen) => {
      head.setAttribute("aria-expanded", String(isOpen));
      card.classList.toggle("folded", !isOpen);
    };
    head.addEventListener("click", () => {
      const isOpen = head.getAttribute("aria-expanded") !== "true";
      fold(isOpen);
      remember(`fold-${id}`, String(!isOpen));
      card.dispatchEvent(new Event("unfold"));
    });
    fold(open);
    this.cards.append(card);
    this.#cards.push(card);
    return {
      card,
      body,
      setNote: (text) => (note.textContent = text),
      show: (shown) => this.#show(card, shown),
      isSeen: () => body.offsetParent !== null,
    };
  }

  /** Opens a tab's sheet on a phone; null closes it. */
  open(tab) {
    this.#tab = tab;
    this.host.classList.toggle("open", tab !== null);
    for (const button of this.bar.children) button.setAttribute("aria-expanded", String(button.dataset.tab === tab));
    for (const card of this.#cards) card.classList.toggle("active", card.dataset.tab === tab);
    this.cards.scrollTop = 0;
    this.resized();
  }

  /** @returns the pixels that it covers */
  get covers() {
    const { width, height } = this.host.getBoundingClientRect();
    const isSheet = getComputedStyle(this.bar).display !== "none";
    return isSheet ? { bottom: height } : { right: width + 10 };
  }

  #show(card, shown) {
    card.hidden = !shown;
    for (const button of this.bar.children)
      button.hidden = !this.#cards.some((each) => each.dataset.tab === button.dataset.tab && !each.hidden);
  }
}
