/** An element with attributes and children; texts are never parsed as HTML. */
export function element(name, attributes = {}, ...children) {
  const made = document.createElement(name);
  for (const [key, value] of Object.entries(attributes)) if (value !== undefined && value !== false) made.setAttribute(key, value);
  made.append(...children.filter((child) => child !== null && child !== undefined));
  return made;
}

export const withUnit = ({ label, unit }) => (unit ? `${label} (${unit})` : label);

/** A number as people write it: "0.012", "1.3e-7"; null was not measured. */
export function shown(value) {
  if (value === null || value === undefined) return "–";
  if (typeof value !== "number") return typeof value === "object" ? JSON.stringify(value) : String(value);
  const size = Math.abs(value);
  if (size !== 0 && (size < 1e-4 || size >= 1e7)) return value.toExponential(2);
  return String(Number.isInteger(value) ? value : Number(value.toPrecision(4)));
}

/** Draws into `frame` now and whenever its width changes. */
export function drawToWidth(frame, draw) {
  let width = 0;
  new ResizeObserver(([entry]) => {
    const now = Math.floor(entry.contentRect.width);
    if (now === width || now < 50) return;
    width = now;
    frame.replaceChildren(draw(width));
  }).observe(frame);
}
