// /command: what is asked and done. A socket of its own, so that no map stands before a command.
import { socketAddress } from "./stream.js";

const patience = 10_000; // ms until a command without an answer has failed
const longerFor = { export: 30 * 60_000 }; // the files of a large map take minutes, after what waits to be saved before
const again = 1000; // ms until a socket that broke by itself is opened anew

export class CommandLine {
  #socket = null;
  #waiting = new Map();
  #next = 1;
  #timer = 0;

  connect() {
    this.close();
    const socket = new WebSocket(socketAddress("command"));
    this.#socket = socket;
    socket.onmessage = ({ data }) => {
      const reply = JSON.parse(data);
      const one = this.#waiting.get(reply.id);
      this.#waiting.delete(reply.id);
      if (!one) return;
      clearTimeout(one.timer);
      if (reply.ok) one.resolve(reply);
      else one.reject(new Error(reply.error ?? "refused without a word"));
    };
    socket.onclose = () => {
      this.close();
      this.#timer = setTimeout(() => this.connect(), again);
    };
  }

  get open() {
    return this.#socket?.readyState === WebSocket.OPEN;
  }

  close() {
    clearTimeout(this.#timer);
    const socket = this.#socket;
    this.#socket = null;
    if (socket) {
      socket.onmessage = socket.onclose = null;
      socket.close();
    }
    for (const one of this.#waiting.values()) {
      clearTimeout(one.timer);
      one.reject(new Error("the connection to the map server is lost"));
    }
    this.#waiting.clear();
  }

  /**
   * @param {string} what of docs/LIVE_PAGE.md, e.g. "save"
   * @returns {Promise<object>} the answer; rejected with the server's words
   */
  do(what, members = {}) {
    if (!this.open) return Promise.reject(new Error("not connected to the map server"));
    const id = this.#next++;
    const longest = longerFor[what] ?? patience;
    return new Promise((resolve, reject) => {
      const timer = setTimeout(() => {
        this.#waiting.delete(id);
        reject(new Error(`no answer to ${what} within ${longest / 1000} s`));
      }, longest);
      this.#waiting.set(id, { resolve, reject, timer });
      this.#socket.send(JSON.stringify({ id, do: what, ...members }));
    });
  }

  /** A question of docs/QUERIES.md; resolves to its answer. */
  async ask(question) {
    return (await this.do("query", { question })).answer;
  }
}
