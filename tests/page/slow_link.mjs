// node tests/page/slow_link.mjs ADDRESS [MBIT_PER_S] [DELAY_MS]: watches a running page over a link as slow as that (2 Mbit/s,
// 200 ms there and back), which this program makes itself, and tells how live it stays: poses a second, and how much later
// one comes than to a browser beside the server.
import { badLink } from "./bad_link.mjs";
import { watchBoard } from "./board_watch.mjs";

const [address, megabits = "2", delay = "200"] = process.argv.slice(2);
const target = new URL(address);
const link = await badLink({ host: target.hostname, port: Number(target.port), megabits: Number(megabits), delay: Number(delay) });

// A second browser without the link tells when each pose was there.
const there = new Map();
watchBoard(address, target.port, ({ channel, utime }) => channel === "poses" && there.set(utime, performance.now()))
  .on("open", function () { this.send(JSON.stringify({ want: [] })); });
const begin = performance.now();
const count = {};
let bytes = 0, poses = 0, longest = 0, last = null, pause = 0;
watchBoard(address, link.port, ({ channel, utime }, size) => {
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
    `longest on the way ${(longest / 1000).toFixed(2)} s; ${(bytes / seconds / 1000).toFixed(0)} kB/s of ${(Number(megabits) * 125).toFixed(0)}`);
  console.log(Object.entries(count).map(([channel, size]) => `${channel} ${(size / 1000).toFixed(0)} kB`).join(", "));
  process.exit(0);
}, 30_000);
