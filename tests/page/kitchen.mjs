// A kitchen of flat faces: what the mock server's robot sees of it.
import { encode, floats, randomNumbers } from "./messages.mjs";

/** A face: a corner, two sides, a colour, how strongly tiles are drawn on it; it is seen from u x v, or from behind if turned. */
const faces = [];
function face(corner, u, v, colour, tile = 0, turned = false) {
  faces.push({ corner, u, v, colour, tile, turned });
}

function box([x, y, z], [a, b, c], colour, top = colour) {
  face([x, y, z], [a, 0, 0], [0, 0, c], colour, 0.6);
  face([x, y + b, z], [a, 0, 0], [0, 0, c], colour, 0.6, true);
  face([x, y, z], [0, b, 0], [0, 0, c], colour.map((k) => k * 0.85), 0.6, true);
  face([x + a, y, z], [0, b, 0], [0, 0, c], colour.map((k) => k * 0.85), 0.6);
  face([x, y, z + c], [a, 0, 0], [0, b, 0], top);
}

face([-1, -2, 0], [5, 0, 0], [0, 4, 0], [176, 150, 118], 0.5); // floor
face([-1, 2, 0], [5, 0, 0], [0, 0, 2.4], [214, 212, 200], 0.2);
face([4, -2, 0], [0, 4, 0], [0, 0, 2.4], [196, 206, 208], 0.2, true);
face([-1, -2, 0], [0, 4, 0], [0, 0, 2.4], [206, 200, 190], 0.2);
box([-1, 1.4, 0], [3.6, 0.6, 0.9], [92, 118, 130], [70, 62, 58]); // counter
box([3.3, 0.8, 0], [0.7, 1.2, 1.9], [198, 84, 62]); // fridge
box([1.2, -1.5, 0.7], [1.4, 0.8, 0.04], [150, 98, 58]); // table
for (const [x, y] of [[1.22, -1.48], [2.52, -1.48], [1.22, -0.78], [2.52, -0.78]]) box([x, y, 0], [0.06, 0.06, 0.7], [110, 72, 44]);
box([1.6, -1.2, 0.74], [0.12, 0.12, 0.22], [60, 140, 180]); // a jug
box([2.1, -1.1, 0.74], [0.22, 0.16, 0.1], [226, 190, 70]); // a loaf
box([-0.4, 1.55, 0.9], [0.3, 0.3, 0.28], [180, 184, 190]); // a kettle

function colourAt({ colour, tile }, s, t) {
  const line = tile && (Math.abs(((s * 2) % 1) - 0.5) > 0.475 || Math.abs(((t * 2) % 1) - 0.5) > 0.475);
  const wave = 1 + 0.05 * Math.sin(5 * s + 2 * t);
  return colour.map((k) => Math.max(0, Math.min(255, k * wave * (line ? 1 - tile * 0.5 : 1))));
}

const side = (v) => Math.hypot(...v);
const area = ({ u, v }) => side(u) * side(v);

/** n coloured points of the kitchen within 3.2 m of a place and before the camera there. */
function seen(position, yaw, n, random) {
  const total = faces.reduce((sum, each) => sum + area(each), 0);
  const found = [];
  for (let tries = 0; found.length < n && tries < 40 * n; ++tries) {
    let left = random() * total;
    const hit = faces.find((each) => (left -= area(each)) <= 0) ?? faces[0];
    const [s, t] = [random(), random()];
    const p = hit.corner.map((c, k) => c + s * hit.u[k] + t * hit.v[k] + 0.004 * (random() - 0.5));
    const d = p.map((c, k) => c - position[k]);
    const far = side(d);
    const off = Math.atan2(d[1], d[0]) - yaw;
    if (far > 3.4 || Math.abs(Math.atan2(Math.sin(off), Math.cos(off))) > 0.6) continue;
    found.push({ p, colour: colourAt(hit, s * side(hit.u), t * side(hit.v)) });
  }
  return found;
}

/** A pose of the robot on its round, at a share of it. */
export function onTheRound(share) {
  const a = 2 * Math.PI * share;
  return { x: 1.2 + 1.3 * Math.sin(a), y: 0.15 - 0.6 * Math.cos(a), yaw: Math.atan2(0.6 * Math.sin(a), 1.3 * Math.cos(a)) };
}

export function T(x, y, z, yaw) {
  return [x, y, z, Math.cos(yaw / 2), 0, 0, Math.sin(yaw / 2)];
}

/** The camera's axes: x right, y down, z ahead. @returns T_map_camera of a robot that looks along `yaw` */
export function cameraPose({ x, y, yaw }) {
  const q = multiply([Math.cos(yaw / 2), 0, 0, Math.sin(yaw / 2)], [0.5, -0.5, 0.5, -0.5]);
  return [x, y, 1.1, ...q];
}

function multiply([a, b, c, d], [e, f, g, h]) {
  return [a * e - b * f - c * g - d * h, a * f + b * e + c * h - d * g, a * g - b * h + c * e + d * f, a * h + b * g - c * f + d * e];
}

/** Three levels of one keyframe's points. */
export function pointsOf(keyframe, pose, n = 6000) {
  const random = randomNumbers(keyframe + 1);
  const all = seen([pose.x, pose.y, 1.1], pose.yaw, n, random);
  const unit = 0.001;
  const [c, s] = [Math.cos(pose.yaw), Math.sin(pose.yaw)];
  const inCamera = ([x, y, z]) => {
    const [dx, dy] = [x - pose.x, y - pose.y];
    return [-(-s * dx + c * dy), -(z - 1.1), c * dx + s * dy];
  };
  return [[0, 0.06], [0.06, 0.3], [0.3, 1]].map(([from, to], level) => {
    const part = all.slice(from * all.length, to * all.length);
    const payload = Buffer.alloc(9 * part.length);
    part.forEach(({ p, colour }, i) => {
      inCamera(p).forEach((value, k) => payload.writeInt16LE(Math.round(value / unit), 6 * i + 2 * k));
      colour.forEach((value, k) => (payload[6 * part.length + 3 * i + k] = value));
    });
    return encode({ channel: "points", key: `${keyframe}/${level}`, keyframe, level, n: part.length, unit, T: cameraPose(pose) }, payload);
  });
}

/** The surface in cubes of 1 m: [{key, centre, message}]. */
export function surface(cell = 0.04) {
  const cubes = new Map();
  for (const each of faces) {
    const [nu, nv] = [Math.max(1, Math.round(side(each.u) / cell)), Math.max(1, Math.round(side(each.v) / cell))];
    const at = (i, j) => each.corner.map((c, k) => c + (i / nu) * each.u[k] + (j / nv) * each.v[k]);
    for (let i = 0; i < nu; ++i)
      for (let j = 0; j < nv; ++j) {
        const corners = [[i, j], [i + 1, j], [i + 1, j + 1], [i, j + 1]];
        const origin = at(i + 0.5, j + 0.5).map(Math.floor);
        const key = origin.join(",");
        if (!cubes.has(key)) cubes.set(key, { key, origin, vertices: [], triangles: [] });
        const cube = cubes.get(key);
        const first = cube.vertices.length;
        for (const [a, b] of corners)
          cube.vertices.push({ p: at(a, b), normal: normalOf(each), colour: colourAt(each, (a / nu) * side(each.u), (b / nv) * side(each.v)) });
        cube.triangles.push(...(each.turned ? [0, 2, 1, 0, 3, 2] : [0, 1, 2, 0, 2, 3]).map((k) => first + k));
      }
  }
  return [...cubes.values()].map(({ key, origin, vertices, triangles }) => ({ key, centre: origin.map((c) => c + 0.5), message: meshMessage(key, origin, vertices, triangles) }));
}

function normalOf({ u, v, turned }) {
  const n = [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]];
  return n.map((c) => (turned ? -c : c) / side(n));
}

function meshMessage(key, origin, vertices, triangles) {
  const unit = 1.2 / 1023;
  const begin = origin.map((c) => c - 0.1);
  const n = vertices.length;
  const padding = (3 * n) & 1;
  const payload = Buffer.alloc(4 * n + 2 * n + 3 * n + padding + 2 * triangles.length);
  vertices.forEach(({ p, normal, colour }, i) => {
    const [x, y, z] = p.map((c, k) => Math.round((c - begin[k]) / unit));
    payload.writeUInt32LE((x | (y << 10) | (z << 20)) >>> 0, 4 * i);
    const sum = normal.reduce((total, c) => total + Math.abs(c), 0);
    let [a, b] = [normal[0] / sum, normal[1] / sum];
    if (normal[2] < 0) [a, b] = [(1 - Math.abs(b)) * (a >= 0 ? 1 : -1), (1 - Math.abs(a)) * (b >= 0 ? 1 : -1)];
    payload.writeInt8(Math.round(127 * a), 4 * n + 2 * i);
    payload.writeInt8(Math.round(127 * b), 4 * n + 2 * i + 1);
    colour.forEach((value, k) => (payload[6 * n + 3 * i + k] = value));
  });
  triangles.forEach((index, i) => payload.writeUInt16LE(index, 9 * n + padding + 2 * i));
  return encode({ channel: "mesh", key, n_vertices: n, n_triangles: triangles.length / 3, origin: begin, unit }, payload);
}

/** Landmarks on the kitchen's faces, in cubes of 1 m. */
export function landmarks(n = 600) {
  const random = randomNumbers(99);
  const cubes = new Map();
  for (let id = 0; id < n; ++id) {
    const [one] = seen([0.8, 0, 1], 2 * Math.PI * random(), 1, random);
    if (!one) continue;
    const key = one.p.map(Math.floor).join(",");
    cubes.set(key, [...(cubes.get(key) ?? []), { id, ...one }]);
  }
  return [...cubes].map(([key, list]) => {
    const payload = Buffer.concat(list.map(({ id, p, colour }) => {
      const s = 0.006 + 0.02 * random() ** 3;
      const tail = Buffer.alloc(8);
      tail.writeUInt32LE(id);
      colour.forEach((value, k) => (tail[4 + k] = value));
      tail[7] = 3 + (id % 60);
      return Buffer.concat([floats([...p, s * s, s * s * 0.4, 0, 2.2 * s * s, 0, 0.5 * s * s]), tail]);
    }));
    return encode({ channel: "landmarks", key, n: list.length }, payload);
  });
}

/** What does not change: planes, objects, the grid. */
export function layers() {
  const grid = Buffer.alloc(100 * 80);
  for (let j = 0; j < 80; ++j)
    for (let i = 0; i < 100; ++i) {
      const [x, y] = [-1 + 0.05 * i, -2 + 0.05 * j];
      const blocked = y > 1.35 || (x > 3.25 && y > 0.75) || (x > 1.15 && x < 2.65 && y < -0.65 && y > -1.55) || i < 2 || i > 97;
      grid[100 * j + i] = blocked ? 2 : y < -1.8 ? 0 : 1;
    }
  const rectangle = (x0, y0, x1, y1, z) => [[x0, y0, z], [x1, y0, z], [x1, y1, z], [x0, y1, z]];
  return [
    encode({ channel: "grid", key: "", origin: [-1, -2, 0], cell: 0.05, width: 100, height: 80 }, grid),
    encode({ channel: "planes", key: "", planes: [
      { label: "floor", outline: rectangle(-1, -2, 4, 2, 0), normal: [0, 0, 1], area: 20 },
      { label: "table", outline: rectangle(1.2, -1.5, 2.6, -0.7, 0.74), normal: [0, 0, 1], area: 1.12 },
      { label: "table", outline: rectangle(-1, 1.4, 2.6, 2, 0.9), normal: [0, 0, 1], area: 2.16 },
      { label: "wall", outline: [[4, -2, 0], [4, 2, 0], [4, 2, 2.4], [4, -2, 2.4]], normal: [-1, 0, 0], area: 9.6 },
    ] }),
    encode({ channel: "objects", key: "", objects: [
      { centre: [1.66, -1.14, 0.85], quaternion: [1, 0, 0, 0], size: [0.12, 0.12, 0.22], on: "table" },
      { centre: [2.21, -1.02, 0.79], quaternion: [1, 0, 0, 0], size: [0.22, 0.16, 0.1], on: "table" },
    ] }),
  ];
}
