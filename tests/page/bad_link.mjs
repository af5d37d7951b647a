// A bad radio link, as TCP sees it: what tests/integration/support/slow_link.hpp is, both ways. A lost packet costs the time
// until it has been sent again, in which all behind it waits. A kernel that can shape traffic is not needed.
import { connect, createServer } from "node:net";

const packet = 1448; // bytes
const held = 32 * 1024; // bytes that wait for the link: a modem's buffer

/** A number from 0 to 1, the same ones each time (mulberry32). */
function drawing(seed) {
  return () => {
    seed = (seed + 0x6d2b79f5) | 0;
    let t = Math.imul(seed ^ (seed >>> 15), 1 | seed);
    t = (t + Math.imul(t ^ (t >>> 7), 61 | t)) ^ t;
    return ((t ^ (t >>> 14)) >>> 0) / 2 ** 32;
  };
}

/**
 * Listens, and forwards connections, which share the rate.
 * @param {{host?: string, port: number, megabits?: number, delay?: number, loss?: number}} quality `delay`: ms there and
 *   back; `loss`: share of the packets
 * @returns {Promise<{port: number, lost: number, close: () => void}>}
 */
export async function badLink({ host = "127.0.0.1", port, megabits = 2, delay = 200, loss = 0 }) {
  const bytesPerMs = (megabits * 1e6) / 8 / 1000;
  const draw = drawing(1);
  const link = { lost: 0 };
  const free = { there: 0, back: 0 }; // when the link can take more
  const sockets = new Set();

  /** Carries bytes at the link's rate, after its delay and after what was lost. */
  function carry(from, to, way) {
    let due = 0;
    let waiting = 0;
    const queue = []; // in order: timers of their own could pass each other
    const send = () => {
      while (queue.length > 0 && queue[0].due <= performance.now()) {
        const { bytes } = queue.shift();
        waiting -= bytes.length;
        if (!to.destroyed) to.write(bytes);
      }
      if (waiting <= held) from.resume();
      if (queue.length > 0) setTimeout(send, queue[0].due - performance.now());
    };
    from.on("data", (bytes) => {
      const now = performance.now();
      free[way] = Math.max(free[way], now) + bytes.length / bytesPerMs;
      due = Math.max(due, free[way] + delay / 2);
      for (let at = 0; at < bytes.length; at += packet)
        if (draw() < loss) {
          due = Math.max(due, free[way] + delay / 2 + delay);
          link.lost += 1;
        }
      waiting += bytes.length;
      if (waiting > held) from.pause();
      queue.push({ bytes, due });
      if (queue.length === 1) setTimeout(send, due - now);
    });
    from.on("close", () => to.destroy());
    from.on("error", () => to.destroy());
    sockets.add(from);
  }

  const server = createServer((near) => {
    const far = connect(port, host);
    carry(far, near, "back");
    carry(near, far, "there");
  });
  await new Promise((done) => server.listen(0, "127.0.0.1", done));
  link.port = server.address().port;
  link.close = () => {
    server.close();
    for (const socket of sockets) socket.destroy();
  };
  return link;
}
