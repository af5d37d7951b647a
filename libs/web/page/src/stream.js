// /live: what is seen. Tells the server what was received, where the viewer stands and which channels are shown.
import { decode, Parts } from "./messages.js";

const firstDelay = 250; // ms until the next attempt; doubles
const longestDelay = 4000;

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

  /** @param {(item: object, again: boolean) => void} take gets each message; `again`: the first one after a reconnection */
  constructor(take) {
    super();
    this.take = take;
    this.open = false;
    this.bytes = 0;
    setInterval(() => this.#tellEye(), 500);
    for (const event of ["online", "focus"]) addEventListener(event, () => this.#hurry());
    document.addEventListener("visibilitychange", () => document.hidden || this.#hurry());
  }

  connect() {
    clearTimeout(this.#timer);
    this.#timer = 0;
    const socket = new WebSocket(`${socketAddress("live")}?parts=1`);
    const parts = new Parts();
    socket.binaryType = "arraybuffer";
    this.#socket = socket;
    let fresh = true;
    this.#received = 0;
    socket.onopen = () => {
      this.open = true;
      this.#eyeSent = null;
      if (this.#want) socket.send(this.#want);
      this.#tellEye();
      this.#say("open");
    };
    socket.onmessage = ({ data }) => {
      this.#delay = firstDelay;
      this.#received += data.byteLength;
      this.bytes += data.byteLength;
      try {
        const item = parts.join(decode(data));
        if (item) {
          this.take(item, fresh && this.#everOpen);
          fresh = false;
        }
      } catch (error) {
        console.error(`live: ${error.message}`);
      }
      if (socket.readyState === WebSocket.OPEN) socket.send(JSON.stringify({ got: this.#received }));
    };
    socket.onclose = () => {
      if (this.#socket !== socket) return;
      this.#everOpen ||= !fresh;
      this.open = false;
      this.#say("lost", { delay: this.#delay / 1000 });
      this.#timer = setTimeout(() => this.connect(), this.#delay);
      this.#delay = Math.min(2 * this.#delay, longestDelay);
    };
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
