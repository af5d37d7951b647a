// What is done with the map: save, export, a log, begin anew. Only what the server can is offered.
import { el, setText } from "../dom.js";
import { count } from "../format.js";

const patience = 3000; // ms in which the second press must come

export function upkeepPanel(column, board, command, notify, figures) {
  const { body, show } = column.card("upkeep", "map", "Map");
  const numbers = el("dl", { class: "numbers" });
  const buttons = el("div", { class: "buttons" });
  body.append(numbers, buttons);
  const run = async (button, what, members, say) => {
    button.disabled = true;
    try {
      notify("good", say(await command.do(what, members)));
    } catch (error) {
      notify("bad", error.message);
    }
    button.disabled = false;
  };
  const button = (text, click) => el("button", { type: "button", class: "action", text, on: { click: (event) => click(event.currentTarget) } });
  const log = logger(board, button, command, notify);
  const make = {
    save: () => button("Save", (self) => run(self, "save", {}, ({ words }) => words || "The map is saved.")),
    export: () => exporter(run, button),
    log: () => log,
    reset: () => twice(button, (self) => run(self, "reset", {}, ({ words }) => words || "A new map begins.")),
  };
  board.on("about", (item) => {
    const can = item?.header.can ?? [];
    buttons.replaceChildren(...Object.keys(make).filter((what) => can.includes(what)).map((what) => make[what]()));
    show(true);
  });
  const rows = ["Keyframes", "Loops", "Points", "Triangles", "Landmarks"].map((name) => ({ name, value: el("dd") }));
  numbers.append(...rows.flatMap(({ name, value }) => [el("dt", { text: name }), value]));
  const draw = () => {
    const now = figures();
    for (const { name, value } of rows) setText(value, count(now[name.toLowerCase()]));
  };
  setInterval(draw, 500);
  draw();
}

function exporter(run, button) {
  const name = el("input", { type: "text", value: "export", "aria-label": "Folder to export to", spellcheck: false, maxlength: 100 });
  const press = button("Export", async (self) => {
    self.textContent = "Exporting …";
    await run(self, "export", { name: name.value.trim() || "export" }, ({ files }) => `Written: ${(files ?? []).join(", ")}`);
    self.textContent = "Export";
  });
  return el("div", { class: "pair" }, name, press);
}

/** Whether a log is written the server says: another browser may have begun it. */
function logger(board, button, command, notify) {
  const isOn = () => board.get("log")?.header.on ?? false;
  const self = button("Start a log", async () => {
    const on = !isOn();
    self.disabled = true;
    try {
      const { file } = await command.do("log", { on });
      notify("good", on ? `Writing ${file}` : `Written: ${file}`);
    } catch (error) {
      notify("bad", error.message);
    }
    self.disabled = false;
  });
  const show = () => {
    self.textContent = isOn() ? "Stop the log" : "Start a log";
    self.setAttribute("aria-pressed", String(isOn()));
  };
  board.on("log", show);
  show();
  return self;
}

/** What cannot be taken back wants a second press. */
function twice(button, act) {
  let timer = 0;
  const calm = () => {
    clearTimeout(timer);
    timer = 0;
    self.textContent = "Begin anew";
    self.classList.remove("danger");
  };
  const self = button("Begin anew", () => {
    if (timer) {
      calm();
      act(self);
      return;
    }
    self.textContent = "Press again: the map is left";
    self.classList.add("danger");
    timer = setTimeout(calm, patience);
  });
  return self;
}
