// A chart of report.json (experiment.hpp: Chart) drawn with Observable Plot.
import * as Plot from "@observablehq/plot";
import { drawToWidth, element, shown, withUnit } from "./dom.js";
import { lookOf } from "./looks.js";

const fewPoints = 40; // a line of more points needs no symbols
const margins = { marginLeft: 56, marginRight: 24, marginTop: 12, marginBottom: 32 };
const style = { fontSize: "12px", overflow: "hidden", background: "transparent" };

/** Points that the axes can show: nothing that was not measured, and on a logarithmic axis nothing at or below zero. */
function points(series, chart) {
  const good = (value, axis) => value !== null && (!axis.logarithmic || value > 0);
  const all = series.x.map((x, i) => ({ x, y: series.y[i], low: series.low[i] ?? null, high: series.high[i] ?? null }));
  return all.map((point) => {
    const seen = good(point.x, chart.x) && good(point.y, chart.y);
    const spread = seen && good(point.high, chart.y) && point.low !== null;
    const low = spread && !good(point.low, chart.y) ? point.y : point.low; // a range down to zero begins at the value
    return { ...point, x: good(point.x, chart.x) ? point.x : NaN, y: seen ? point.y : NaN, low: spread ? low : NaN, high: spread ? point.high : NaN };
  });
}

/** Paths from above have none: they would hide each other. */
const hasSymbols = (data, chart) => drawn(data).length <= fewPoints && !chart.equal_scales;

const drawn = (data) => data.filter(({ x, y }) => Number.isFinite(x) && Number.isFinite(y));
const spreads = (data) => data.filter(({ low, high }) => Number.isFinite(low) && high > low);

function tip(name, chart) {
  return ({ x, y, low, high }) => `${name}\n${withUnit(chart.x)}: ${chart.x.names[x - 1] ?? shown(x)}\n${withUnit(chart.y)}: ${shown(y)}` +
    (Number.isFinite(low) && high > low ? ` (${shown(low)} to ${shown(high)})` : "");
}

function dots(data, look, chart, name, size) {
  return Plot.dot(drawn(data), { x: "x", y: "y", symbol: look.symbol, stroke: look.colour, fill: look.colour,
    fillOpacity: 0.55, r: size, title: tip(name, chart), tip: { fontSize: 12 } });
}

function whiskers(data, look, width = 1.5) {
  return Plot.ruleX(spreads(data), { x: "x", y1: "low", y2: "high", stroke: look.colour, strokeWidth: width, strokeOpacity: 0.7 });
}

const drawings = {
  line(data, look, chart, name) {
    const marks = [Plot.line(data, { x: "x", y: "y", stroke: look.colour, strokeWidth: 2, strokeDasharray: look.dash })];
    if (spreads(data).length > 1)
      marks.unshift(Plot.areaY(spreads(data), { x: "x", y1: "low", y2: "high", fill: look.colour, fillOpacity: 0.16 }));
    else marks.unshift(whiskers(data, look));
    if (hasSymbols(data, chart)) marks.push(dots(data, look, chart, name, 3.5));
    return marks;
  },
  dots: (data, look, chart, name) => [whiskers(data, look), dots(data, look, chart, name, drawn(data).length > 300 ? 2 : 3.5)],
  ellipse_outline: (data, look) => [Plot.line(data, { x: "x", y: "y", stroke: look.colour, strokeWidth: 2, strokeDasharray: look.dash })],
};

/** Bars of all series that have them stand side by side about their x. */
function barMarks(list, chart) {
  const places = [...new Set(list.flatMap(({ data }) => drawn(data).map(({ x }) => x)))].sort((a, b) => a - b);
  const gaps = places.slice(1).map((x, i) => x - places[i]);
  const group = 0.8 * (gaps.length ? Math.min(...gaps) : 1), slot = group / list.length;
  const floor = chart.y.logarithmic ? Math.min(...list.flatMap(({ data }) => drawn(data).map(({ y }) => y))) / 2 : 0;
  return list.flatMap(({ data, look, name }, i) => {
    const begin = -group / 2 + i * slot;
    const middle = (d) => d.x + begin + slot / 2;
    return [
      Plot.rectY(drawn(data), { x1: (d) => d.x + begin + 0.04 * slot, x2: (d) => d.x + begin + 0.96 * slot, y1: floor, y2: "y",
        fill: look.colour, fillOpacity: look.strong ? 0.85 : 0.4, stroke: look.colour, title: tip(name, chart), tip: true }),
      Plot.ruleX(spreads(data), { x: middle, y1: "low", y2: "high", stroke: "currentColor", strokeWidth: 1.5 }),
    ];
  });
}

/** A metre is as long in x as in y: the smaller scale rules, and the other axis shows more than it needs. */
function equalScales(list, width) {
  const range = (key) => {
    const values = list.flatMap(({ data }) => drawn(data).map((d) => d[key]));
    const low = Math.min(...values), high = Math.max(...values), pad = 0.05 * (high - low || 1);
    return [low - pad, high + pad];
  };
  const x = range("x"), y = range("y");
  const inner = width - margins.marginLeft - margins.marginRight;
  const height = Math.round(Math.min(Math.max((inner * (y[1] - y[0])) / (x[1] - x[0]), 180), 440));
  const scale = Math.min(inner / (x[1] - x[0]), height / (y[1] - y[0]));
  const widened = ([low, high], pixels) => [(low + high - pixels / scale) / 2, (low + high + pixels / scale) / 2];
  return { x: widened(x, inner), y: widened(y, height), height: height + margins.marginTop + margins.marginBottom };
}

/** 1, 2, 5, 10, ... within the values, and no more than there is room for. */
function logarithmicTicks(values, most) {
  const low = Math.min(...values), high = Math.max(...values);
  const ticks = (steps) => {
    const list = [];
    for (let power = Math.floor(Math.log10(low)); power <= Math.ceil(Math.log10(high)); power += 1)
      list.push(...steps.map((step) => Number(`${step}e${power}`)).filter((tick) => tick >= low && tick <= high));
    return list;
  };
  const candidates = [[1, 2, 3, 4, 5, 6, 7, 8, 9], [1, 2, 5], [1, 3], [1]].map(ticks).filter((list) => list.length >= 2);
  const fine = candidates.find((list) => list.length <= most) ?? candidates.at(-1) ?? [low];
  return fine.filter((_, i) => i % Math.ceil(fine.length / most) === 0);
}

/** `rest` says more of a linear axis. One value alone would have no scale: it gets one on both sides. */
function axis({ logarithmic }, values, room, rest) {
  const finite = values.filter(Number.isFinite), low = Math.min(...finite), high = Math.max(...finite);
  const alone = low === high && !rest.zero && { domain: [low - 1, high + 1] };
  return { label: null, grid: true, ...(logarithmic
    ? { type: "log", ticks: logarithmicTicks(finite, room), tickFormat: shown }
    : { type: "linear", ticks: room, ...alone, ...rest }) };
}

/** Bars of many things that have names lie beside them, one below the other. */
const liesInRows = (chart) => chart.x.names.length > 4 && chart.series.every(({ mark }) => mark === "bars");

function drawRows(chart, list, width) {
  const { names } = chart.x, slot = 0.8 / list.length;
  return Plot.plot({
    width, height: 40 + names.length * Math.max(20, 12 * list.length), ...margins, marginLeft: 12 + 6.2 * Math.max(...names.map(({ length }) => length)), style,
    x: axis(chart.y, list.flatMap(({ data }) => data.map(({ y }) => y)), Math.max(3, Math.floor(width / 120)), { nice: true, zero: true }),
    y: { domain: [names.length + 0.5, 0.5], ticks: names.map((_, i) => i + 1), tickFormat: (place) => names[place - 1], label: null },
    ariaLabel: chart.title,
    marks: list.map(({ data, look, name }, i) => Plot.rectX(drawn(data), { x1: 0, x2: "y", y1: (d) => d.x - 0.4 + i * slot, y2: (d) => d.x - 0.4 + (i + 0.94) * slot,
      fill: look.colour, fillOpacity: look.strong ? 0.85 : 0.4, stroke: look.colour, title: tip(name, chart), tip: true })),
  });
}

function draw(chart, list, width) {
  const equal = chart.equal_scales ? equalScales(list, width) : null;
  const bars = list.filter(({ series }) => series.mark === "bars");
  const all = list.flatMap(({ data }) => drawn(data));
  const places = [...new Set(all.map(({ x }) => x))].sort((one, other) => one - other);
  const apart = Math.min(...places.slice(1).map((x, i) => x - places[i])) / (places.at(-1) - places[0]);
  const fit = places.length === 1 || apart * (width - margins.marginLeft - margins.marginRight) > 44;
  const { names } = chart.x;
  const ownTicks = names.length ? { ticks: names.map((_, i) => i + 1), tickFormat: (place) => names[place - 1] } : fit && places.length <= 12 && { ticks: places, tickFormat: shown };
  return Plot.plot({
    width, height: equal?.height ?? Math.round(Math.min(360, Math.max(260, width * 0.5))), ...margins, style,
    inset: equal || bars.length ? 0 : 6,
    x: axis(chart.x, all.map(({ x }) => x), Math.max(3, Math.floor(width / 80)), { ...(equal ? { domain: equal.x } : ownTicks) }),
    y: axis(chart.y, all.flatMap(({ y, low, high }) => [y, low, high]), 6, equal ? { domain: equal.y } : { nice: true, zero: bars.length > 0 }),
    ariaLabel: chart.title,
    marks: [
      ...barMarks(bars, chart),
      ...list.filter(({ series }) => series.mark !== "bars")
        .flatMap(({ data, look, name, series }) => drawings[series.mark](data, look, chart, name)),
    ],
  });
}

function key({ look, series, name, data }, chart) {
  const bar = series.mark === "bars", symbol = series.mark === "dots" || (series.mark === "line" && hasSymbols(data, chart));
  const sample = Plot.plot({ width: 34, height: 14, margin: 0, axis: null, style: { ...style, width: "34px" }, x: { domain: [0, 1] }, y: { domain: [0, 1] }, marks: [
    bar ? Plot.rect([0], { x1: 0.1, x2: 0.9, y1: 0.1, y2: 0.9, fill: look.colour, fillOpacity: look.strong ? 0.85 : 0.4, stroke: look.colour }) : null,
    bar || series.mark === "dots" ? null : Plot.line([[0, 0.5], [1, 0.5]], { stroke: look.colour, strokeWidth: 2, strokeDasharray: look.dash }),
    symbol ? Plot.dot([[0.5, 0.5]], { symbol: look.symbol, stroke: look.colour, fill: look.colour, fillOpacity: 0.55, r: 3.5 }) : null,
  ] });
  sample.setAttribute("aria-hidden", "true");
  return element("li", {}, sample, name);
}

export function chartFigure(chart) {
  const list = chart.series.map((series, i) => ({ series, name: series.name || withUnit(chart.y), look: lookOf(i), data: points(series, chart) }))
    .filter(({ data }) => drawn(data).length > 0);
  const title = element("figcaption", {}, chart.title);
  if (list.length === 0) return element("figure", { class: "chart missing" }, title, element("p", {}, "Nothing was measured."));
  const frame = element("div", { class: "frame" });
  const rows = liesInRows(chart);
  drawToWidth(frame, (width) => (rows ? drawRows : draw)(chart, list, width));
  return element("figure", { class: "chart" }, title, element("ul", { class: "legend" }, ...list.map((one) => key(one, chart))),
    element("p", { class: "axis" }, rows ? `${withUnit(chart.x)} ↓` : `↑ ${withUnit(chart.y)}`), frame,
    element("p", { class: "axis x" }, `${withUnit(rows ? chart.y : chart.x)} →`));
}
