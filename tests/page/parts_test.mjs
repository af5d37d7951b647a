// Parts of the page that need no browser: bytes, budgets, addresses.
import assert from "node:assert/strict";
import { mock } from "node:test";
import { length, point } from "../../libs/web/page/src/format.js";
import { decode, graphArrays, meshArrays, pointArrays, splitItems } from "../../libs/web/page/src/messages.js";
import { extent } from "../../libs/web/page/src/panels/sessions.js";
import { clearance, columnAbove, headroom } from "../../libs/web/page/src/tools/headroom.js";
import { readAddress, writeAddress } from "../../libs/web/page/src/share.js";
import { chooseLevels, coarsen } from "../../libs/web/page/src/views/mesh_levels.js";
import { choose, surplus } from "../../libs/web/page/src/views/point_budget.js";
import { encode, floats } from "./messages.mjs";

const received = (message) => decode(message.buffer.slice(message.byteOffset, message.byteOffset + message.length));

/** A flat square of n x n vertices in a cube's 1024 units. */
function square(n) {
  const packed = Uint32Array.from({ length: n * n }, (_, i) => Math.round(((i % n) * 1023) / (n - 1)) | (Math.round((Math.floor(i / n) * 1023) / (n - 1)) << 10));
  const triangles = [];
  for (let j = 0; j + 1 < n; ++j)
    for (let i = 0; i + 1 < n; ++i) {
      const a = j * n + i;
      triangles.push(a + n, a, a + 1, a + n + 1, a + n, a + 1);
    }
  return { packed, triangles: new Uint16Array(triangles) };
}

/** Twice the area of triangles in the square's plane, with sign. */
function area(packed, triangles) {
  const at = (i) => [packed[i] & 1023, (packed[i] >>> 10) & 1023];
  let sum = 0;
  for (let t = 0; t < triangles.length; t += 3) {
    const [a, b, c] = [at(triangles[t]), at(triangles[t + 1]), at(triangles[t + 2])];
    sum += (b[0] - a[0]) * (c[1] - a[1]) - (c[0] - a[0]) * (b[1] - a[1]);
  }
  return sum;
}

export const tests = {
  async "headroom ends where nothing is known"() {
    const column = (free, then) => [...Array(free).fill("free"), ...Array(125 - free).fill(then)];
    assert.equal(headroom(column(125)), "2.5 m or more");
    assert.equal(headroom(column(60, "unknown")), `${length(1.2)}, then not known`);
    assert.equal(headroom(column(60, "occupied")), length(1.2));
    assert.equal(headroom(column(0, "unknown")), "not known");
    assert.equal(headroom(column(0, "occupied")), "nothing");
    assert.equal(headroom(["occupied", ...column(124, "free").slice(1)]), "2.5 m or more");
  },

  async "headroom is never more than is free: under a thin table top, wherever its cells lie"() {
    const cell = 0.04;
    const [floor, top] = [0, 18]; // layers of cells that are occupied; the top from 0.72 m
    for (let place = 0; place < cell; place += 0.0005) {
      const asked = columnAbove({ x: 1, y: 2, z: place });
      const states = asked.map(([, , z]) => ([floor, top].includes(Math.floor(z / cell)) ? "occupied" : "free"));
      const told = parseFloat(headroom(states)) / 100;
      assert.ok(told <= 0.72 - place + 1e-3 && told > 0.69 - place, `${told} m told above ${place}, ${0.72 - place} are free`);
    }
  },

  async "clearance is no more than is known"() {
    assert.deepEqual([clearance(0.42, 2, "free"), clearance(-0.01, 2, "occupied")], [length(0.42), length(0)]);
    assert.equal(clearance(2, 2, "free"), "2.00 m or more");
    assert.equal(clearance(2, 2, "unknown"), "not known");
  },

  async "sessions without times do not begin in 1970"() {
    const sessions = [{ begin: 7e6, end: 9e6 }, { begin: 0, end: 0 }, { begin: 5e6, end: 6e6 }];
    assert.deepEqual(extent(sessions), { begin: 5e6, end: 9e6 });
    assert.deepEqual(extent([{ begin: 0, end: 0 }]), { begin: 0, end: 1 });
  },

  async "payloads begin where their header ends, whatever its length"() {
    for (const title of ["a", "ab", "abc", "abcd"]) {
      const item = received(encode({ channel: "path", key: "icp/0", title }, floats([1, 2, 3])));
      assert.deepEqual([item.channel, item.key, item.at % 4, item.header.title], ["path", "icp/0", 0, title]);
      assert.deepEqual([...new Float32Array(item.buffer, item.at)], [1, 2, 3]);
    }
    assert.throws(() => decode(new ArrayBuffer(3)), /3 bytes/);
    assert.throws(() => decode(Uint8Array.from([99, 0, 0, 0, 1]).buffer), /header of 99 bytes/);
  },

  async "points, edges and triangles of large cubes are where the contract says"() {
    const points = pointArrays(received(encode({ channel: "points", key: "0/0", n: 2 }, Buffer.concat([Buffer.from(Int16Array.of(1, -2, 3, 4, 5, 6).buffer), Buffer.alloc(6)]))));
    assert.deepEqual([[...points.positions], points.colours.byteOffset - points.positions.byteOffset], [[1, -2, 3, 4, 5, 6], 12]);
    for (const [n, size] of [[3, 2], [65537, 4]]) {
      const begin = Math.ceil((9 * n) / size) * size;
      const payload = Buffer.alloc(begin + 3 * size);
      for (const [k, vertex] of [0, 1, n - 1].entries()) size === 2 ? payload.writeUInt16LE(vertex, begin + 2 * k) : payload.writeUInt32LE(vertex, begin + 4 * k);
      const mesh = meshArrays(received(encode({ channel: "mesh", key: "", n_vertices: n, n_triangles: 1 }, payload)));
      assert.deepEqual([...mesh.triangles], [0, 1, n - 1]);
    }
    const bytes = Buffer.concat([Buffer.from(Int32Array.of(7).buffer), floats([1, 2, 3, 1, 0, 0, 0]), Buffer.from(Int32Array.of(7, 9, 2).buffer), floats([0.5])]);
    const { nodes, edges } = graphArrays(received(encode({ channel: "graph", key: "", n_nodes: 1, n_edges: 1 }, bytes)));
    assert.deepEqual([nodes, edges], [[{ keyframe: 7, T: [1, 2, 3, 1, 0, 0, 0] }], [{ from: 7, to: 9, kind: 2, error: 0.5 }]]);
  },

  async "a page that is cut off says where"() {
    const message = encode({ channel: "about", key: "" });
    const size = Buffer.alloc(4);
    size.writeUInt32LE(message.length);
    const all = Buffer.concat([size, message, size, message]);
    assert.equal([...splitItems(all)].length, 2);
    assert.throws(() => [...splitItems(all.subarray(0, all.length - 1))], new RegExp(`byte ${4 + message.length}`));
  },

  async "near keyframes are fine, all are there, and the farthest finest points go first"() {
    const piece = (level, n, distance) => ({ level, n, distance });
    const [near0, near1, near2, far0, far1] = [piece(0, 10, 1), piece(1, 30, 1), piece(2, 100, 1), piece(0, 10, 9), piece(1, 30, 9)];
    const all = [far1, near2, far0, near1, near0];
    assert.deepEqual(choose(all, 55), new Set([near0, far0, near1]));
    assert.deepEqual(choose(all, 1000), new Set(all));
    assert.deepEqual(choose([near2], 1), new Set([near2]), "something is always drawn");
    assert.deepEqual(surplus(all, 60), [near2, far1]);
    assert.deepEqual(surplus(all, 180), []);
  },

  async "a coarser surface has fewer triangles, none turned over, and reaches the cube's border"() {
    const { packed, triangles } = square(129);
    const levels = coarsen(packed, triangles);
    assert.equal(levels.length, 2);
    assert.ok(levels[0].length <= triangles.length / 8 && levels[1].length <= triangles.length / 64);
    for (const level of levels) assert.ok(Math.abs(area(packed, level) / area(packed, triangles) - 1) < 0.05, `area ${area(packed, level) / area(packed, triangles)}`);
    for (const level of levels) for (let t = 0; t < level.length; t += 3) assert.ok(area(packed, level.subarray(t, t + 3)) > 0);
  },

  async "the nearest cubes are fine as far as the budget goes"() {
    const cube = (distance, ...counts) => ({ distance, counts });
    const [near, far, single] = [cube(1, 100, 10, 1), cube(2, 100, 10, 1), cube(3, 5)];
    const levels = (budget) => [near, far, single].map((each) => chooseLevels([far, single, near], budget).get(each));
    assert.deepEqual(levels(0), [2, 2, 0]);
    assert.deepEqual(levels(16), [1, 2, 0]);
    assert.deepEqual(levels(25), [1, 1, 0]);
    assert.deepEqual(levels(115), [0, 1, 0]);
    assert.deepEqual(levels(205), [0, 0, 0]);
  },

  async "an address gives back the view that it was made of, and takes no nonsense"() {
    const target = { toArray: () => [1, -2.5, 0.125] };
    const switches = { differences: () => ({ on: ["grid"], off: ["points", "mesh"] }) };
    const read = readAddress(writeAddress({ target, yaw: 0.5, pitch: 0.25, distance: 3, name: "robot", follow: true }, switches));
    assert.deepEqual(read, { at: [1, -2.5, 0.13], turn: [0.5, 0.25], far: 3, view: "robot", follow: true, on: ["grid"], off: ["points", "mesh"] });
    const empty = { at: null, turn: null, far: null, view: null, follow: null, on: [], off: [] };
    assert.deepEqual(readAddress("#at=1,2&turn=a,b&far="), empty);
    assert.equal(writeAddress({ untouched: true, name: "free" }, { differences: () => ({ on: [], off: [] }) }), "");
  },

  async "an export may take minutes, others are given up after seconds"() {
    const { CommandLine } = await import("../../libs/web/page/src/command.js");
    let socket = null;
    globalThis.location = { href: "http://robot:8642/", protocol: "http:" };
    const real = globalThis.WebSocket;
    globalThis.WebSocket = class {
      static OPEN = 1;
      readyState = 1;
      constructor() {
        socket = this;
      }
      send() {}
      close() {}
    };
    mock.timers.enable({ apis: ["setTimeout"] });
    try {
      const line = new CommandLine();
      line.connect();
      const exported = line.do("export", { name: "a" });
      const saved = line.do("save").then(() => "done", ({ message }) => message);
      mock.timers.tick(5 * 60_000);
      assert.match(await saved, /no answer to save within 10 s/);
      socket.onmessage({ data: JSON.stringify({ id: 1, ok: true, files: ["a.ply"] }) });
      assert.deepEqual((await exported).files, ["a.ply"]);
      line.close();
    } finally {
      mock.timers.reset();
      globalThis.WebSocket = real;
      delete globalThis.location;
    }
  },

  async "lengths have the unit that suits them"() {
    assert.deepEqual([0.0042, 0.42, 1.425, NaN, null].map(length), ["4.2 mm", "42.0 cm", "1.43 m", "–", "–"]);
    assert.equal(point([-0.001, 1, 2]), "0.00, 1.00, 2.00 m");
  },
};
