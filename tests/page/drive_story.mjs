// What happens in the mock server's kitchen: the robot drives a round; the map grows, drifts, and bends as the loop closes.
import { readFileSync } from "node:fs";
import { cameraPose, landmarks, layers, onTheRound, pointsOf, surface, T } from "./kitchen.mjs";
import { encode, floats, randomNumbers } from "./messages.mjs";

const keyframes = 30; // of the round
const everyFrame = 0.1; // s
const roundTime = 14; // s

/** JPEGs of a recorded log: from a start-of-image mark to the next end-of-image mark. */
function imagesOf(log, most = 12) {
  const data = readFileSync(log);
  const images = [];
  for (let at = 0; images.length < most && (at = data.indexOf("ffd8ff", at, "hex")) >= 0; ) {
    const end = data.indexOf("ffd9", at, "hex") + 2;
    images.push(data.subarray(at, end));
    at = end;
  }
  return images;
}

export class Story {
  /** @param {(message: Buffer) => void} put sets an item of the server's board */
  constructor(put, log) {
    this.put = put;
    this.images = imagesOf(log);
    this.random = randomNumbers(5);
    this.time = 0;
    this.keyframe = -1;
    this.edges = [];
    this.loops = 0;
    this.path = { icp: [], fastslam: [], truth: [], odometry: [] };
    this.cubes = surface();
    this.landmarks = landmarks();
    put(encode({ channel: "about", key: "", title: "kitchen", version: 1, source: "live", frame: "map",
      robot: { length: 0.6, width: 0.5, height: 0.9 }, camera: { width: 640, height: 480 },
      can: ["go_to", "drive", "save", "reset", "export", "log", "query"] }));
    put(encode({ channel: "health", key: "", level: "good", words: "All is well: both mappers track", mend: "", processes: processes() }));
  }

  /** How far the map's newest part has drifted; nothing once the loop is closed. */
  drift(keyframe) {
    return this.loops > 0 ? 0 : 0.004 * keyframe;
  }

  poseOf(keyframe) {
    const pose = onTheRound(keyframe / keyframes);
    const off = this.drift(keyframe);
    return { x: pose.x + off, y: pose.y - 0.7 * off, yaw: pose.yaw + 0.3 * off };
  }

  /** Goes on by a tenth of a second. */
  step() {
    this.time += everyFrame;
    const share = this.time / roundTime;
    const reached = Math.min(keyframes + 4, Math.floor(share * keyframes));
    while (this.keyframe < reached) this.#newKeyframe();
    this.#poses(share);
    this.#image(Math.round(this.time / everyFrame));
    this.#report();
  }

  #newKeyframe() {
    const k = ++this.keyframe;
    if (k > 0) this.edges.push([k - 1, k, k % 3 ? 1 : 0]);
    if (k >= keyframes && k % 2 === 0) {
      this.edges.push([k - keyframes, k, 2]);
      this.loops += 1;
      if (this.loops === 1) this.put(encode({ channel: "notices", key: "", notices: [{ utime: Date.now() * 1000, level: "good", words: "A loop has closed; the map moved by 12 cm" }] }));
    }
    for (const message of pointsOf(k, this.poseOf(k))) this.put(message);
    const nodes = Array.from({ length: k + 1 }, (_, i) => {
      const node = Buffer.alloc(4);
      node.writeInt32LE(i);
      return Buffer.concat([node, floats(cameraPose(this.poseOf(i)))]);
    });
    const edges = this.edges.map(([from, to, kind]) => {
      const edge = Buffer.alloc(16);
      [from, to, kind].forEach((value, i) => edge.writeInt32LE(value, 4 * i));
      edge.writeFloatLE(1.2, 12);
      return edge;
    });
    this.put(encode({ channel: "graph", key: "", n_nodes: nodes.length, n_edges: edges.length }, Buffer.concat([...nodes, ...edges])));
    for (const cube of this.cubes.splice(0, 3)) this.put(cube.message);
    for (const message of this.landmarks.splice(0, 4)) this.put(message);
    if (k === 6) for (const message of layers()) this.put(message);
    this.#sessions();
  }

  #sessions() {
    const now = Date.now() * 1000;
    const begin = now - this.time * 1e6;
    this.put(encode({ channel: "sessions", key: "", sessions: [
      { name: "map", mapper: "icp", begin, end: now, current: true, joined: "map", keyframes: this.keyframe + 1, landmarks: 0 },
      { name: "map", mapper: "fastslam", begin: 0, end: 0, current: true, joined: "map", keyframes: 0, landmarks: 600 },
      { name: "morning", mapper: "icp", begin: begin - 6e7, end: begin - 2e7, current: false, joined: null, keyframes: 41, landmarks: 0 },
    ] }));
  }

  #poses(share) {
    const truth = onTheRound(share);
    const wobble = (size) => size * (this.random() - 0.5);
    const off = this.loops > 0 ? 0 : 0.004 * this.keyframe;
    const found = {
      truth: [truth.x, truth.y, truth.yaw],
      icp: [truth.x + off + wobble(0.01), truth.y - 0.7 * off + wobble(0.01), truth.yaw],
      fastslam: [truth.x + 0.01 + wobble(0.02), truth.y + 0.015 + wobble(0.02), truth.yaw + wobble(0.01)],
      odometry: [truth.x + 0.02 * this.time, truth.y - 0.03 * this.time, truth.yaw + 0.01 * this.time],
    };
    const header = { channel: "poses", key: "", utime: Date.now() * 1000, errors: {} };
    for (const [name, [x, y, yaw]] of Object.entries(found)) {
      header[name] = { T: T(x, y, 0, yaw), status: "TRACKING", quality: 0.91, inliers: 4210, detail: "", sigma: [0.012, 0.009, 0.004, 0.002, 0.002, 0.006] };
      if (name !== "truth") header.errors[name] = Math.hypot(x - truth.x, y - truth.y);
      this.path[name].push(x, y, 0.03);
      const piece = Math.floor((this.path[name].length / 3 - 1) / 512);
      this.put(encode({ channel: "path", key: `${name}/${piece}` }, floats(this.path[name].slice(3 * 512 * piece))));
    }
    this.put(encode(header));
    const particles = Array.from({ length: 100 }, () => [found.fastslam[0] + wobble(0.14), found.fastslam[1] + wobble(0.14), 0.05, this.random() / 50]).flat();
    this.put(encode({ channel: "particles", key: "", best: 3, effective: 61.2, total: 100 }, floats(particles)));
  }

  #image(frame) {
    const image = this.images[Math.floor(frame / 3) % this.images.length];
    const random = randomNumbers(Math.floor(frame / 3));
    const tracks = Array.from({ length: 60 }, (_, i) => [20 + 600 * random(), 20 + 440 * random(), 100 + i, [0, 0, 0, 1, 3, 0, 2][i % 7]]);
    this.put(encode({ channel: "image", key: "", utime: Date.now() * 1000, width: 640, height: 480, tracks }, image));
  }

  #report() {
    const n = 8 + Math.floor(6 * this.random());
    const rms = Array.from({ length: n }, (_, i) => 0.0035 + 0.02 * Math.exp(-i / 2.2) * (0.8 + 0.4 * this.random()));
    this.put(encode({ channel: "report", key: "", utime: Date.now() * 1000, rms, inliers: 4211, overlap: 0.83, stop: "converged", correction: [0.0123, 0.004] }));
  }
}

function processes() {
  const one = (name, level, words, mend, cpu, memory, latency, rate) => ({ name, level, state: "running", words, mend, cpu, memory, latency, rate });
  return [
    one("camera", "good", "", "", 0.05, 41e6, [0.001, 0.002], 15),
    one("surf", "good", "", "", 0.34, 88e6, [0.018, 0.027], 15),
    one("fastslam", "good", "", "", 0.52, 143e6, [0.021, 0.034], 15),
    one("icp", "good", "", "", 0.61, 312e6, [0.024, 0.041], 15),
    one("odometry", "warn", "3 messages of WHEELS were lost", "look at the network's load", 0.01, 18e6, [0.0002, 0.0004], 50),
    one("map-server", "good", "", "", 0.22, 406e6, [0.003, 0.009], 20),
  ];
}
