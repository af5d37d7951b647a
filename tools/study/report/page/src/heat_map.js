// A heat map of report.json: cells with their numbers where there is room, a scale that colour-blind readers see (cividis).
import * as Plot from "@observablehq/plot";
import { drawToWidth, element, shown, withUnit } from "./dom.js";

const margins = { marginLeft: 64, marginRight: 8, marginTop: 4, marginBottom: 30 };
const roomForNumber = 44; // px

function short(value) {
  if (Math.abs(value) >= 1000 || (value !== 0 && Math.abs(value) < 0.01)) return value.toExponential(0);
  return String(Number(value.toPrecision(2)));
}

const isMeasured = (map) => (value) => value !== null && (!map.value.logarithmic || value > 0);

/** `others`: heat maps of the same experiment. Those of the same quantity have one scale, so that colours compare. */
export function heatMapFigure(map, _, others) {
  const logarithmic = map.value.logarithmic;
  const alike = others.filter(({ value }) => withUnit(value) === withUnit(map.value) && value.logarithmic === logarithmic);
  const values = alike.flatMap((other) => other.values.flat()).filter(isMeasured(map));
  const cells = map.values.flatMap((row, r) => row.map((value, c) => ({ x: map.columns[c], y: map.rows[r], value })));
  const measured = cells.filter(({ value }) => isMeasured(map)(value));
  const missing = cells.filter((cell) => !measured.includes(cell));
  const title = element("figcaption", {}, map.title);
  if (measured.length === 0) return element("figure", { class: "chart missing" }, title, element("p", {}, "Nothing was measured."));
  const low = Math.min(...values), high = Math.max(...values);
  const flat = low === high;
  const share = ({ value }) => (flat ? 0.5 : logarithmic ? Math.log(value / low) / Math.log(high / low) : (value - low) / (high - low));
  const color = { type: flat || !logarithmic ? "linear" : "log", scheme: "cividis", domain: flat ? [low - 1, high + 1] : [low, high] };
  const frame = element("div", { class: "frame" });
  drawToWidth(frame, (width) => {
    const cell = (width - margins.marginLeft - margins.marginRight) / map.columns.length;
    const room = Math.max(1, Math.ceil(roomForNumber / cell));
    return Plot.plot({
      width, height: margins.marginTop + margins.marginBottom + map.rows.length * 34, ...margins,
      style: { fontSize: "12px", overflow: "hidden", background: "transparent" }, ariaLabel: map.title, color,
      x: { type: "band", domain: map.columns, label: null, ticks: map.columns.filter((_, i) => i % room === 0), tickFormat: shown },
      y: { type: "band", domain: [...map.rows].reverse(), label: null, tickFormat: shown },
      marks: [
        Plot.cell(measured, { x: "x", y: "y", fill: "value", inset: 0.5, tip: true,
          title: (d) => `${withUnit(map.x)}: ${shown(d.x)}\n${withUnit(map.y)}: ${shown(d.y)}\n${withUnit(map.value)}: ${shown(d.value)}` }),
        Plot.cell(missing, { x: "x", y: "y", fill: "none", stroke: "currentColor", strokeOpacity: 0.4, strokeDasharray: "2 3", inset: 2 }),
        cell < roomForNumber ? null
          : Plot.text(measured, { x: "x", y: "y", text: (d) => short(d.value), fill: (d) => (share(d) > 0.5 ? "black" : "white"), fontSize: 12 }),
      ],
    });
  });
  const middle = logarithmic ? Math.sqrt(low * high) : (low + high) / 2;
  const legend = Plot.legend({ color: { ...color, label: null }, width: 240, height: 40, marginLeft: 16, marginRight: 24, marginTop: 2,
    ticks: flat ? [low] : [low, middle, high], tickFormat: short, style: { fontSize: "12px" } });
  return element("figure", { class: "chart" }, title,
    element("div", { class: "legend scale" }, element("span", {}, withUnit(map.value)), legend,
      missing.length ? element("span", {}, "dashed: not measured") : null),
    element("p", { class: "axis" }, `↑ ${withUnit(map.y)}`), frame, element("p", { class: "axis x" }, `${withUnit(map.x)} →`));
}
