// Where each mapper says the robot is, how sure it is, and how far from the truth where that is known.
import { el, setText } from "../dom.js";
import { angle, fixed, length } from "../format.js";
import { styles } from "../views/paths.js";
import { mapperOf, yawOf } from "../views/robot.js";
import { line } from "./layers.js";
import { Plot } from "./plot.js";

const levels = { INITIALISING: "warn", TRACKING: "good", DEGRADED: "warn", LOST: "bad", RELOCALISED: "good", SILENT: "bad" };
const span = 120; // s of errors that are shown

export function posesPanel(column, board) {
  const { body, setNote, show: showCard } = column.card("poses", "poses", "Positions");
  const empty = el("p", { class: "empty", text: "Waiting for the first position." });
  const rows = Object.fromEntries(Object.keys(styles).map((name) => [name, row(name)]));
  const plot = new Plot("errors against the truth over the last two minutes", length);
  const errors = el("div", { hidden: true }, el("h3", { text: "Error against the truth" }), plot.element);
  body.append(empty, ...Object.values(rows).map(({ element }) => element), errors);
  let history = [];

  board.on("about", (item) => showCard(item?.header.source !== "file"));
  board.on("poses", (item) => {
    const header = item?.header ?? {};
    empty.hidden = Object.keys(styles).some((name) => header[name]);
    for (const [name, { show }] of Object.entries(rows)) show(header[name], header.errors?.[name]);
    setNote(stateOf(header[mapperOf(header)]?.status));
    if (!item) history = [];
    else history = keep(history, header.utime / 1e6, header.errors ?? {});
    errors.hidden = history.filter(({ errors }) => Object.keys(errors).length > 0).length < 2;
    if (!errors.hidden && body.offsetParent) draw(plot, history);
  });
}

function stateOf(status) {
  return String(status ?? "").toLowerCase();
}

function row(name) {
  const level = el("span", { class: "state" });
  const error = el("span", { class: "value" });
  const where = el("div", { class: "fine" });
  const detail = el("div", { class: "fine words" });
  const element = el("div", { class: "pose", hidden: true }, el("div", { class: "first" }, line(name), el("span", { class: "name", text: styles[name].label }), level, error), where, detail);
  const show = (pose, off) => {
    element.hidden = !pose?.T;
    if (element.hidden) return;
    const [x, y, z, qw, qx, qy, qz] = pose.T;
    setText(level, stateOf(pose.status));
    level.className = `state ${levels[pose.status] ?? ""}`;
    setText(error, off === null || off === undefined ? "" : `off by ${length(off)}`);
    const sure = pose.sigma ? ` ± ${length(Math.hypot(pose.sigma[0], pose.sigma[1]))}` : "";
    setText(where, `x ${fixed(x)}  y ${fixed(y)}  z ${fixed(z)} m${sure}  yaw ${angle(yawOf({ w: qw, x: qx, y: qy, z: qz }))}`);
    const share = pose.quality > 0 ? `${Math.round(pose.quality * 100)} % explained` : "";
    const used = pose.inliers > 0 ? `${pose.inliers} measurements` : "";
    setText(detail, [used, share, pose.detail].filter(Boolean).join(", "));
  };
  return { element, show };
}

function keep(history, time, errors) {
  const kept = history.filter((each) => each.time > time - span && each.time < time);
  return [...kept, { time, errors }];
}

function draw(plot, history) {
  const lines = Object.keys(styles).map((name) => ({
    name,
    points: history.filter(({ errors }) => Number.isFinite(errors[name])).map(({ time, errors }) => [time, errors[name]]),
  }));
  const [begin, end] = [history[0].time, history.at(-1).time];
  plot.draw(lines, [`${Math.round(end - begin)} s ago`, "now"], [begin, end]);
}
