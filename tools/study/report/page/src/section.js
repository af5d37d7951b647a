// One experiment: what was found first, how it was done last.
import { chartFigure } from "./chart.js";
import { element, shown } from "./dom.js";
import { heatMapFigure } from "./heat_map.js";

const openRows = 14; // longer tables are folded away

export const verdict = (experiment) => (experiment.status === "failed" ? "failed" : experiment.agreement);
export const badge = (experiment) => element("span", { class: `badge ${verdict(experiment).replaceAll(" ", "-")}` }, verdict(experiment));

function table({ title, columns, rows }) {
  const cell = (value, i) => element("td", { "data-column": columns[i], class: typeof value === "number" && "number" }, shown(value));
  const body = element("table", {},
    element("thead", {}, element("tr", {}, ...columns.map((name) => element("th", { scope: "col" }, name)))),
    element("tbody", {}, ...rows.map((row) => element("tr", {}, ...row.map(cell)))));
  const fold = element("details", { class: "table" }, element("summary", {}, `${title} (${rows.length} rows)`), body);
  fold.open = rows.length <= openRows;
  return fold;
}

function picture({ title, text, data }) {
  return element("figure", { class: "picture" }, element("figcaption", {}, title), element("img", { src: data, alt: text }),
    element("p", { class: "axis" }, text));
}

/** How it was measured, and what it cost: the only figures that another run may change. */
function method({ settings, seeds, timing, memory }) {
  const row = ([key, value]) => element("tr", {}, element("th", { scope: "row" }, key), element("td", {}, shown(value)));
  const { seconds, ...times } = timing;
  const rows = Object.entries({ seeds: seeds.join(", "), ...settings, ...times, ...memory });
  return element("details", { class: "method" },
    element("summary", {}, `Settings, seeds and costs (it took ${shown(Number(seconds.toPrecision(2)))} s)`),
    element("table", {}, element("tbody", {}, ...rows.map(row))));
}

export function section(experiment) {
  const head = [
    element("p", { class: "kicker" }, experiment.thesis, " ", badge(experiment)),
    element("h2", {}, experiment.title),
  ];
  const body = experiment.status === "failed"
    ? [element("p", { class: "finding error" }, `It failed: ${experiment.error}`)]
    : [
      element("p", { class: "finding" }, experiment.finding),
      element("div", { class: "figures" }, ...experiment.charts.map(chartFigure), ...experiment.heat_maps.map(heatMapFigure),
        ...experiment.pictures.map(picture)),
      ...experiment.tables.map(table),
      method(experiment),
    ];
  return element("section", { id: experiment.name }, ...head, ...body);
}
