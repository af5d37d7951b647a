// What has happened, the newest first.
import { el, levelMark } from "../dom.js";
import { clock } from "../format.js";

export function noticesPanel(column, board) {
  const { body, setNote, show } = column.card("notices", "health", "Notices", true);
  board.on("about", (item) => show(item?.header.source !== "file"));
  const draw = (item) => {
    const notices = item?.header.notices ?? [];
    setNote(notices.length > 0 ? String(notices.length) : "");
    const rows = [...notices].sort((a, b) => b.utime - a.utime).map(({ utime, level, words }) =>
      el("div", { class: "notice" }, levelMark(level ?? "good"), el("time", { text: clock(utime) }), el("span", { text: words })));
    body.replaceChildren(...(rows.length > 0 ? rows : [el("p", { class: "empty", text: "Nothing to tell." })]));
  };
  board.on("notices", draw);
  draw(null);
}
