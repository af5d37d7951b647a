// /live: what is seen. Tells the server what was received, where the viewer stands and which channels are shown.
import { decode, Parts } from "./messages.js";

const firstDelay = 250; // ms until the next attempt; doubles
const longestDelay = 4000;
const patience = 6000; // ms until an attempt to connect has failed; where packets vanish the browser waits for minutes

/** The address of a socket beside this page. */
export function socketAddress(name) {
  const address = new URL(name, location.href);
  address.protocol = location.protocol === "https:" ? "wss:" : "ws:";
  address.hash = "";
  address.search = "";
  return address.href;
}

export class Stream extends EventTarget {
  #socket = null;
  #delay = firstDelay;
  #timer = 0;
  #received = 0;
  #eye = null;
  #eyeSent = null;
  #want = "";
  #everOpen = false;
  #fresh = true; // nothing has come through this socket

  /** @param {(item: object, again: boolean) => void} take gets each message; `again`: the first one after a reconnection */
  constructor(take) {
    super();
    this.take = take;
    this.open = false;
    this.bytes = 0;
    this.heard = 0; // ms, when something came last (performance.now())
    setInterval(() => this.#tellEye(), 500);
    for (const event of ["online", "focus"]) addEventListener(event, () => this.#hurry());
    document.addEventListener("visibilitychange", () => document.hidden || this.#hurry());
  }

  connect() {
    this.#discard();
    const socket = new WebSocket(`${socketAddress("live")}?parts=1`);
    const parts = new Parts();
    socket.binaryType = "arraybuffer";
    this.#socket = socket;
    this.#fresh = true;
    this.#received = 0;
    this.#timer = setTimeout(() => this.drop(), patience);
    socket.onopen = () => {
      clearTimeout(this.#timer);
      this.#timer = 0;
      this.open = true;
      this.heard = performance.now();
      this.#eyeSent = null;
      if (this.#want) socket.send(this.#want);
      this.#tellEye();
      this.#say("open");
    };
    socket.onmessage = ({ data }) => {
      this.#delay = firstDelay;
      this.heard = performance.now();
      this.#received += data.byteLength;
      this.bytes += data.byteLength;
      try {
        const item = parts.join(decode(data));
        if (item) {
          this.take(item, this.#fresh && this.#everOpen);
          this.#fresh = false;
        }
      } catch (error) {
        console.error(`live: ${error.message}`);
      }
      if (socket.readyState === WebSocket.OPEN) socket.send(JSON.stringify({ got: this.#received }));
    };
    socket.onclose = () => this.drop();
  }

  /** The socket is at its end, or the way is cut and it does not know yet: another one is tried. */
  drop() {
    this.#discard();
    this.#everOpen ||= !this.#fresh;
    this.open = false;
    this.#say("lost", { delay: this.#delay / 1000 });
    this.#timer = setTimeout(() => this.connect(), this.#delay);
    this.#delay = Math.min(2 * this.#delay, longestDelay);
  }

  /** Nothing is heard of the socket any more: it may take minutes to close. */
  #discard() {
    clearTimeout(this.#timer);
    this.#timer = 0;
    const socket = this.#socket;
    this.#socket = null;
    if (!socket) return;
    socket.onopen = socket.onmessage = socket.onclose = null;
    socket.close();
  }

  /** Which bulk channels are shown. */
  want(channels) {
    const text = JSON.stringify({ want: channels });
    if (text === this.#want) return;
    this.#want = text;
    if (this.open) this.#socket.send(text);
  }

  /** Where the viewer stands, m in the map. */
  eye(position) {
    this.#eye = position.toArray().map((value) => Math.round(value * 100) / 100);
  }

  #tellEye() {
    const text = JSON.stringify({ eye: this.#eye });
    if (!this.open || !this.#eye || text === this.#eyeSent) return;
    this.#eyeSent = text;
    this.#socket.send(text);
  }

  #hurry() {
    if (!this.#timer) return;
    this.#delay = firstDelay;
    this.connect();
  }

  #say(type, detail = {}) {
    this.dispatchEvent(new CustomEvent(type, { detail }));
  }
}
