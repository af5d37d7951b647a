// node tests/page/slow_link.mjs ADDRESS [MBIT_PER_S] [DELAY_MS]: watches a running page over a link as slow as that (2 Mbit/s,
// 200 ms there and back), which this program makes itself, and tells how live it stays: poses a second, and how much later
// one comes than to a browser beside the server. A kernel that can shape traffic is not needed.
import { createServer, connect } from "node:net";
import { require } from "./mock_server.mjs";

const [address, megabits = "2", delay = "200"] = process.argv.slice(2);
const target = new URL(address);
const bytesPerMs = (Number(megabits) * 1e6) / 8 / 1000;
const oneWay = Number(delay) / 2;
const held = 32 * 1024; // bytes that wait for the link: a modem's buffer

/** Carries bytes at the link's rate and after its delay. */
function carry(from, to) {
  let free = 0;
  let waiting = 0;
  from.on("data", (bytes) => {
    const now = performance.now();
    free = Math.max(free, now) + bytes.length / bytesPerMs;
    waiting += bytes.length;
    if (waiting > held) from.pause();
    setTimeout(() => {
      waiting -= bytes.length;
      if (waiting <= held) from.resume();
      setTimeout(() => to.destroyed || to.write(bytes), oneWay);
    }, free - now);
  });
  from.on("close", () => to.destroy());
  from.on("error", () => to.destroy());
}

const link = createServer((near) => {
  const far = connect(Number(target.port), target.hostname);
  carry(far, near);
  carry(near, far);
}).listen(0, "127.0.0.1", watchOverIt);

/** Calls `see(header)` for each message of the board. */
function watch(port, see) {
  const { WebSocket } = require("ws");
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

function watchOverIt() {
  // A second browser without the link tells when each pose was there.
  const there = new Map();
  watch(target.port, ({ channel, utime }) => channel === "poses" && there.set(utime, performance.now()))
    .on("open", function () { this.send(JSON.stringify({ want: [] })); });
  const begin = performance.now();
  const count = {};
  let bytes = 0, poses = 0, longest = 0, last = null, pause = 0;
  watch(link.address().port, ({ channel, utime }, size) => {
    bytes += size;
    count[channel] = (count[channel] ?? 0) + size;
    if (channel !== "poses") return;
    const now = performance.now();
    if (there.has(utime)) longest = Math.max(longest, now - there.get(utime));
    if (last !== null) pause = Math.max(pause, now - last);
    last = now;
    poses += 1;
  });
  setTimeout(() => {
    const seconds = (performance.now() - begin) / 1000;
    console.log(`${megabits} Mbit/s, ${delay} ms: ${(poses / seconds).toFixed(1)} poses/s, longest pause ${(pause / 1000).toFixed(2)} s, ` +
      `longest on the way ${(longest / 1000).toFixed(2)} s; ${(bytes / seconds / 1000).toFixed(0)} kB/s of ${bytesPerMs.toFixed(0)}`);
    console.log(Object.entries(count).map(([channel, size]) => `${channel} ${(size / 1000).toFixed(0)} kB`).join(", "));
    process.exit(0);
  }, 30_000);
}
