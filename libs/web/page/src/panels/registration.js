// How ICP's residual fell in the newest registration; the ones before stand faintly behind.
import { el, setText } from "../dom.js";
import { angle, count, length } from "../format.js";
import { Plot } from "./plot.js";

const stops = ["converged", "stopped at the most iterations", "too few points", "degenerate", "diverged"];
const behind = 8;

export function registrationPanel(column, board) {
  const { card, body, setNote, show } = column.card("registration", "poses", "Registration (ICP)", true);
  const empty = el("p", { class: "empty", text: "Waiting for the first registration." });
  const plot = new Plot("RMS of the residual at each iteration", length);
  const words = el("p", { class: "fine" });
  const all = el("div", { hidden: true }, el("h3", { text: "RMS at each iteration" }), plot.element, words);
  body.append(empty, all);
  let last = [];
  const draw = () => {
    if (!body.offsetParent || last.length === 0) return;
    const lines = last.map((rms, i) => ({ name: i === last.length - 1 ? "icp" : "before", points: rms.map((y, x) => [x + 1, y]) }));
    plot.draw(lines, ["1", `iteration ${Math.max(...last.map((rms) => rms.length))}`]);
  };
  card.addEventListener("unfold", draw);
  board.on("about", (item) => show(item?.header.source !== "file"));
  board.on("report", (item) => {
    const header = item?.header;
    empty.hidden = Boolean(header);
    all.hidden = !header;
    if (!header) return (last = []);
    const rms = header.rms ?? [];
    if (rms.length > 0) last = [...last.slice(-behind), rms];
    setNote(rms.length > 0 ? length(rms.at(-1)) : "");
    const stop = typeof header.stop === "number" ? stops[header.stop] : header.stop;
    const [shift, turn] = header.correction ?? [];
    const moved = Number.isFinite(shift) ? `; moved by ${length(shift)}, ${angle(turn)} from the prediction` : "";
    setText(words, `${stop}; ${count(header.inliers)} points, ${Math.round(header.overlap * 100)} % overlap${moved}`);
    draw();
  });
}
