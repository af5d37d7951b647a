// Both sockets of a served page: opened, kept up, and what is said when they are not.
import { el } from "./dom.js";
import { CommandLine } from "./command.js";
import { Stream } from "./stream.js";

const quiet = 3000; // ms without an answer or anything else, after which what is shown is old
const silence = 8000; // ms after which the way is taken for cut: the system would try for a quarter of an hour
const bulk = ["points", "mesh", "landmarks", "image", "particles", "grid", "planes", "objects"];
const always = ["image", "planes"]; // a click on the map tells the plane

export class Connection {
  /** @param {{board, strip, stage, view, switches}} parts */
  constructor({ board, strip, stage, view, switches }) {
    this.commands = new CommandLine();
    this.stream = new Stream((item, again) => {
      if (again) board.expectAnew();
      if (item.channel === "whole") return board.expectNoMore();
      const before = board.get("about")?.header.title;
      if (item.channel === "about" && before !== undefined && before !== item.header.title) board.clear();
      board.put(item);
    });
    this.stream.addEventListener("open", () => {
      strip.setConnection("open");
      this.commands.connect();
    });
    this.stream.addEventListener("lost", () => {
      strip.setConnection("lost");
      this.commands.close();
      this.asked = null;
      board.hold();
      this.#lookForToken();
    });
    const want = () => this.stream.want(document.hidden ? [] : bulk.filter((name) => always.includes(name) || switches.is(name)));
    switches.on(bulk, want);
    document.addEventListener("visibilitychange", want);
    const eye = () => this.stream.eye(stage.camera.position);
    view.addEventListener("moved", eye);
    eye();
    this.asked = null; // ms, when the ping was sent that has no answer yet
    setInterval(() => this.#ping(strip), 2000);
    setInterval(() => this.#listen(strip), 500);
    this.stream.connect();
  }

  async #ping(strip) {
    if (!this.commands.open || document.hidden || this.asked !== null) return;
    const begin = (this.asked = performance.now());
    try {
      await this.commands.do("ping");
      strip.setPing((performance.now() - begin) / 1000);
    } catch {
      strip.setPing(null); // the strip says that the connection is lost
    }
    if (this.asked === begin) this.asked = null;
  }

  /** A network that went takes no socket with it: only what does not come tells. */
  #listen(strip) {
    if (!this.stream.open || document.hidden) return;
    const since = this.asked === null ? 0 : performance.now() - Math.max(this.asked, this.stream.heard);
    if (since > silence) this.stream.drop();
    else strip.setConnection(since > quiet ? "quiet" : "open");
  }

  /** A server that was started anew has a new token: it refuses the page as well as its sockets. */
  async #lookForToken() {
    if (this.asking) return;
    const reply = await fetch(location.pathname, { method: "HEAD", cache: "no-store" }).catch(() => null);
    if (reply && (reply.status === 401 || reply.status === 403)) this.#askForToken();
  }

  #askForToken() {
    this.asking = true;
    const input = el("input", { type: "text", "aria-label": "Token", autocomplete: "off", spellcheck: false });
    const form = el("form", { method: "dialog" }, el("h2", { text: "A token is wanted" }),
      el("p", { text: "The map server was started anew. It printed a new token when it began: ask whoever started it." }),
      el("div", { class: "pair" }, input, el("button", { class: "action", text: "Go on" })));
    const dialog = el("dialog", { class: "sheet", "aria-label": "Token" }, form);
    form.addEventListener("submit", () => location.assign(`${location.pathname}?token=${encodeURIComponent(input.value.trim())}`));
    document.body.append(dialog);
    dialog.showModal();
  }
}
