// What is shown: a chip for each layer, with the colour and dash of its path.
import { el, svg } from "../dom.js";
import { layers } from "../switches.js";
import { styles } from "../views/paths.js";

export function layersPanel(column, switches) {
  const { body } = column.card("layers", "view", "View");
  for (const group of [...new Set(layers.map((layer) => layer.group))]) {
    const chips = layers.filter((layer) => layer.group === group).map((layer) => chip(layer, switches));
    body.append(el("div", { class: "chips", role: "group", "aria-label": group }, el("span", { class: "group", text: group }), ...chips));
  }
}

function chip({ name, label, aloud, group, swatch, key, about }, switches) {
  const full = aloud ?? (label === "Path" ? `${group}'s path` : label);
  const button = el("button", { type: "button", class: "chip", "aria-label": full, title: `${about}${key ? ` (${key})` : ""}`, on: { click: () => switches.toggle(name) } },
    swatch ? line(name) : null, el("span", { text: label }));
  switches.on([name], () => button.setAttribute("aria-pressed", String(switches.is(name))));
  return button;
}

/** A piece of a path as the map draws it. */
export function line(name) {
  const dash = { fastslam: "6 3", odometry: "1.5 2.5" }[name] ?? "none";
  return svg("svg", { viewBox: "0 0 18 6", class: `swatch ${name}`, "aria-hidden": "true" },
    svg("path", { d: "M1 3H17", "stroke-dasharray": dash, "stroke-width": styles[name].width * 0.8 }));
}
