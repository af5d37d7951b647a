// When the robot mapped: a bar for each session on one line of time, and what each holds.
import { el } from "../dom.js";
import { count, duration } from "../format.js";

export function sessionsPanel(column, board) {
  const { body, setNote } = column.card("sessions", "map", "Sessions", true);
  const draw = (item) => {
    const sessions = item?.header.sessions ?? [];
    setNote(sessions.length > 0 ? String(sessions.length) : "");
    if (sessions.length === 0) return body.replaceChildren(el("p", { class: "empty", text: "No session yet." }));
    const { begin, end } = extent(sessions);
    body.replaceChildren(...sessions.map((session) => row(session, begin, end)));
  };
  board.on("sessions", draw);
  draw(null);
}

/** When all of them were mapped, us. Landmarks have no times of their own: sessions of them begin at 0. */
export function extent(sessions) {
  const timed = sessions.filter((session) => session.begin > 0);
  if (timed.length === 0) return { begin: 0, end: 1 };
  const begin = Math.min(...timed.map((session) => session.begin));
  return { begin, end: Math.max(...timed.map((session) => session.end), begin + 1) };
}

function row({ name, mapper, begin, end, current, joined, keyframes, landmarks }, first, last) {
  const timed = begin > 0;
  const bar = el("span", { class: `bar ${mapper ?? ""} ${joined === null ? "apart" : ""}` });
  bar.hidden = !timed;
  bar.style.left = `${(100 * (begin - first)) / (last - first)}%`;
  bar.style.width = `max(4px, ${(100 * (end - begin)) / (last - first)}%)`;
  const holds = [keyframes ? `${count(keyframes)} keyframes` : "", landmarks ? `${count(landmarks)} landmarks` : ""];
  const place = joined === null ? "its place is not known" : "";
  const day = timed ? new Date(begin / 1000).toLocaleString([], { dateStyle: "medium", timeStyle: "short" }) : "";
  return el("div", { class: `session ${current ? "current" : ""}`, title: day },
    el("div", { class: "first" }, el("span", { class: "name", text: name }), el("span", { class: "state", text: current ? "now" : "" }), el("span", { class: "value", text: timed ? duration((end - begin) / 1e6) : "" })),
    el("div", { class: "track" }, bar),
    el("div", { class: "fine", text: [mapper === "icp" ? "6-D SLAM" : mapper === "fastslam" ? "FastSLAM" : mapper, ...holds, place].filter(Boolean).join(" · ") }));
}
