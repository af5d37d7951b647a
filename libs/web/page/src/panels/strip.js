// The strip on top: what is shown, whether all is well, and what mends it.
import { el, iconButton, levelMark, setText } from "../dom.js";
import { seconds } from "../format.js";
import { toggleTheme } from "../theme.js";

export class Strip {
  #connection = "connecting"; // or "open", "quiet", "lost", "file"
  #poses = []; // when they came, s

  constructor(host, board, { help }) {
    this.board = board;
    this.title = el("span", { class: "title", text: "lcmslam" });
    this.mark = el("span", { class: "level" });
    this.words = el("span", { class: "words" });
    this.state = el("div", { class: "state", role: "status", "aria-live": "polite" }, this.mark, this.words);
    this.figures = el("span", { class: "figures" });
    host.append(this.title, this.state, this.figures,
      iconButton("theme", "Dark or light", toggleTheme), iconButton("keys", "Keys and help (?)", help));
    this.ping = null;
    for (const channel of ["health", "about"]) board.on(channel, () => this.#draw());
    board.on("poses", (item) => item && this.#count());
    setInterval(() => this.#drawFigures(), 1000);
    this.#draw();
  }

  /** @param {"connecting"|"open"|"quiet"|"lost"|"file"} state */
  setConnection(state) {
    if (state === this.#connection) return;
    this.#connection = state;
    this.#draw();
  }

  setPing(time) {
    this.ping = time;
  }

  #draw() {
    const about = this.board.get("about")?.header;
    setText(this.title, about?.title ?? "lcmslam");
    if (about) document.title = `${about.title} – lcmslam`;
    const health = this.board.get("health")?.header;
    if (this.#connection === "lost") return this.#say("bad", "The connection to the map server is lost. Trying again; what is shown is old.");
    if (this.#connection === "quiet") return this.#say("warn", "The map server has not answered for some seconds; what is shown is old.");
    if (this.#connection === "connecting") return this.#say("warn", "Connecting to the map server…");
    if (health) return this.#say(health.level, health.mend ? `${health.words}: ${health.mend}` : health.words);
    if (about?.source === "file") return this.#say("good", "A kept map");
    if (about?.source === "log") return this.#say("good", "A log");
    this.#say("warn", "Waiting for the processes to say how they are.");
  }

  #say(level, words) {
    if (this.mark.dataset.level !== level) this.mark.replaceChildren(levelMark(level));
    this.mark.dataset.level = level;
    document.documentElement.dataset.connection = this.#connection;
    setText(this.words, words);
    this.words.title = words;
  }

  #count() {
    const now = performance.now() / 1000;
    this.#poses = [...this.#poses.filter((time) => time > now - 3), now];
  }

  #drawFigures() {
    const now = performance.now() / 1000;
    const recent = this.#poses.filter((time) => time > now - 3);
    const live = this.#connection === "open" && recent.length > 1;
    const rate = live ? `poses ${(recent.length / 3).toFixed(0)} Hz` : "";
    const link = this.#connection === "open" && this.ping !== null ? `link ${seconds(this.ping)}` : "";
    setText(this.figures, [rate, link].filter(Boolean).join(" · "));
  }
}
