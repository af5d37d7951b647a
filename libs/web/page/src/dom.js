// Elements in one line each.
import { paths } from "./icons.js";

/**
 * @param {string} tag
 * @param {object} attributes `text`, `on` {event: listener}, else attributes; false and null leave one out
 * @param {...(Node|string|null)} children
 */
export function el(tag, attributes = {}, ...children) {
  const element = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) {
    if (name === "text") element.textContent = value;
    else if (name === "on") for (const [event, listener] of Object.entries(value)) element.addEventListener(event, listener);
    else if (value !== false && value !== null && value !== undefined) element.setAttribute(name, value === true ? "" : value);
  }
  element.append(...children.filter((child) => child !== null && child !== undefined));
  return element;
}

/** An element of SVG. */
export function svg(tag, attributes = {}, ...children) {
  const element = document.createElementNS("http://www.w3.org/2000/svg", tag);
  for (const [name, value] of Object.entries(attributes)) element.setAttribute(name, value);
  element.append(...children);
  return element;
}

export function icon(name) {
  return svg("svg", { viewBox: "0 0 24 24", class: "icon", "aria-hidden": "true" }, svg("path", { d: paths[name] }));
}

/** A button that is a picture; its name is read out and shown when the pointer rests. */
export function iconButton(name, label, onClick, attributes = {}) {
  return el("button", { type: "button", class: "tool", "aria-label": label, title: label, on: { click: onClick }, ...attributes },
    icon(name));
}

/** Shape and colour for "good", "warn" and "bad": nobody depends on the colour. */
export function levelMark(level) {
  const shape = {
    good: svg("circle", { cx: 6, cy: 6, r: 4 }),
    warn: svg("path", { d: "M6 1.2 11.2 10.6H.8Z" }),
    bad: svg("path", { d: "M3.8 1h4.4L11 3.8v4.4L8.2 11H3.8L1 8.2V3.8Z" }),
  };
  return svg("svg", { viewBox: "0 0 12 12", class: `mark ${level}`, role: "img", "aria-label": level }, shape[level] ?? shape.warn);
}

/** Replaces all children, and touches nothing where the text is the same. */
export function setText(element, text) {
  if (element.textContent !== text) element.textContent = text;
}
