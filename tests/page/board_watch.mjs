// Reads a page's server as its page does (docs/LIVE_PAGE.md), without a browser.
import { require } from "./mock_server.mjs";

/**
 * Calls `see(header, bytes)` for each message of the board.
 * @param address of the page, with its token; @param port where that is reached, its own or a link's
 */
export function watchBoard(address, port, see) {
  const { WebSocket } = require("ws");
  const target = new URL(address);
  const socket = new WebSocket(`ws://127.0.0.1:${port}/live?parts=1${target.search.replace("?", "&")}`, { headers: { host: target.host } });
  socket.binaryType = "nodebuffer";
  let got = 0;
  socket.on("message", (message) => {
    got += message.length;
    socket.send(JSON.stringify({ got }));
    see(JSON.parse(message.subarray(4, 4 + message.readUInt32LE(0))), message.length);
  });
  return socket;
}
