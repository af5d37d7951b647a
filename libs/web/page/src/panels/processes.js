// What the processes say of themselves, in words and figures.
import { el, levelMark } from "../dom.js";
import { memory, seconds } from "../format.js";

export function processesPanel(column, board) {
  const { body, setNote, show } = column.card("processes", "health", "Processes", true);
  board.on("about", (item) => show(item?.header.source !== "file"));
  const draw = (item) => {
    const processes = item?.header.processes ?? [];
    const poor = processes.filter(({ level }) => level !== "good").length;
    setNote(processes.length === 0 ? "" : poor === 0 ? `${processes.length} well` : `${poor} of ${processes.length} not well`);
    body.replaceChildren(...(processes.length > 0 ? processes.map(row) : [el("p", { class: "empty", text: "No process has said how it is." })]));
  };
  board.on("health", draw);
  draw(null);
}

function row({ name, level, state, words, mend, cpu, memory: held, latency, rate }) {
  const figures = [
    Number.isFinite(cpu) ? `${cpu.toFixed(2)} cores` : "",
    Number.isFinite(held) ? memory(held) : "",
    Number.isFinite(rate) ? `${rate.toFixed(0)} Hz` : "",
    latency && Number.isFinite(latency[1]) ? `p95 ${seconds(latency[1])}` : "",
  ];
  return el("div", { class: "process" },
    el("div", { class: "first" }, levelMark(level), el("span", { class: "name", text: name }), el("span", { class: "state", text: state ?? "" })),
    el("div", { class: "fine figures" }, ...figures.map((text) => el("span", { text }))),
    words ? el("div", { class: "fine words", text: mend ? `${words}: ${mend}` : words }) : null);
}
