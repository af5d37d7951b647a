// Browsers beside the one that is tested: some take all that comes, some never read.
import { createConnection } from "node:net";
import { require } from "./mock_server.mjs";

const back = 200; // ms until one that was turned away comes back

export class Crowd {
  /** @param {{watchers: number, silent: number}} sizes */
  constructor(port, { watchers, silent }) {
    Object.assign(this, { port, bytes: 0, messages: 0, stared: 0, over: false });
    for (let i = 0; i < watchers; ++i) this.watch();
    for (let i = 0; i < silent; ++i) this.stare();
  }
  /** Says how much it has got, as the page does. */
  watch() {
    const { WebSocket } = require("ws");
    const socket = new WebSocket(`ws://127.0.0.1:${this.port}/live?parts=1`);
    let got = 0;
    socket.on("message", (message) => {
      got += message.length;
      this.bytes += message.length;
      this.messages += 1;
      socket.send(JSON.stringify({ got }));
    });
    this.keep(socket, () => socket.terminate(), () => this.watch());
  }
  /** Shakes hands and never reads. */
  stare() {
    const socket = createConnection(this.port, "127.0.0.1");
    socket.on("connect", () => {
      socket.write(`GET /live?parts=1 HTTP/1.1\r\nHost: 127.0.0.1:${this.port}\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n` +
        "Sec-WebSocket-Version: 13\r\nSec-WebSocket-Key: AAAAAAAAAAAAAAAAAAAAAA==\r\n\r\n");
      socket.pause();
      this.stared += 1;
    });
    this.keep(socket, () => socket.destroy(), () => this.stare());
  }
  keep(socket, end, again) {
    this.ends = [...(this.ends ?? []), end];
    socket.on("error", end);
    socket.on("close", () => {
      this.ends = this.ends.filter((other) => other !== end);
      if (!this.over) setTimeout(() => this.over || again(), back);
    });
  }
  leave() {
    this.over = true;
    for (const end of this.ends) end();
  }
}
