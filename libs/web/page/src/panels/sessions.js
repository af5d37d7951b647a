// When the robot mapped: a bar for each session on one line of time, and what each holds.
import { el } from "../dom.js";
import { count, duration } from "../format.js";

export function sessionsPanel(column, board) {
  const { body, setNote } = column.card("sessions", "map", "Sessions", true);
  const draw = (item) => {
    const sessions = item?.header.sessions ?? [];
    setNote(sessions.length > 0 ? String(sessions.length) : "");
    if (sessions.length === 0) return body.replaceChildren(el("p", { class: "empty", text: "No session yet." }));
    const begin = Math.min(...sessions.map((session) => session.begin));
    const end = Math.max(...sessions.map((session) => session.end), begin + 1);
    body.replaceChildren(...sessions.map((session) => row(session, begin, end)));
  };
  board.on("sessions", draw);
  draw(null);
}

function row({ name, mapper, begin, end, current, joined, keyframes, landmarks }, first, last) {
  const bar = el("span", { class: `bar ${mapper ?? ""} ${joined === null ? "apart" : ""}` });
  bar.style.left = `${(100 * (begin - first)) / (last - first)}%`;
  bar.style.width = `max(4px, ${(100 * (end - begin)) / (last - first)}%)`;
  const holds = [keyframes ? `${count(keyframes)} keyframes` : "", landmarks ? `${count(landmarks)} landmarks` : ""];
  const place = joined === null ? "its place is not known" : "";
  const day = new Date(begin / 1000).toLocaleString([], { dateStyle: "medium", timeStyle: "short" });
  return el("div", { class: `session ${current ? "current" : ""}`, title: day },
    el("div", { class: "first" }, el("span", { class: "name", text: name }), el("span", { class: "state", text: current ? "now" : "" }), el("span", { class: "value", text: duration((end - begin) / 1e6) })),
    el("div", { class: "track" }, bar),
    el("div", { class: "fine", text: [mapper === "icp" ? "6-D SLAM" : mapper === "fastslam" ? "FastSLAM" : mapper, ...holds, place].filter(Boolean).join(" · ") }));
}
