// The report from the JSON that stands in the page (study_run.hpp: run_experiments).
import { element } from "./dom.js";
import { badge, section, verdict } from "./section.js";

const report = JSON.parse(document.getElementById("lcmslam-report").textContent);

function summary({ experiments, versions, seeds, quick }) {
  const counts = new Map();
  for (const experiment of experiments) counts.set(verdict(experiment), (counts.get(verdict(experiment)) ?? 0) + 1);
  const found = [...counts].map(([words, count]) => `${words} ${count}`).join(", ");
  return element("header", {},
    element("h1", {}, "The thesis's experiments, run again"),
    element("p", {}, `FastSLAM with SURF landmarks and 6-D SLAM by ICP, on simulated drives with exact truth and on recordings. ${experiments.length} experiments: ${found}.`),
    element("p", { class: "axis" }, `lcmslam ${versions.lcmslam}, seeds ${seeds.join(", ")}${quick ? "; a quick run: few seeds and short drives, so spreads are wide" : ""}. ` +
      "Bands and bars span the seeds, lowest to highest; curves are medians. All numbers stand in report.json."));
}

const contents = ({ experiments }) => element("nav", { "aria-label": "Contents" }, element("ol", {}, ...experiments.map((experiment) =>
  element("li", {}, element("a", { href: `#${experiment.name}` }, experiment.title), " ",
    element("span", { class: "axis" }, experiment.thesis), " ", badge(experiment)))));

document.getElementById("report").append(summary(report), contents(report), ...report.experiments.map(section));
if (location.hash) document.getElementById(location.hash.slice(1))?.scrollIntoView();
