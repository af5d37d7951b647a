// Points before a surface make it speckled: those of a keyframe give way where the surface is there, and there alone. A part of
// the map that has none (its images are gone, or there is no room for more) goes on showing its points.
import { Vector3 } from "three";

const cell = 0.25; // m
const reach = 0.1; // m around a vertex that count as surface
const enough = 0.7; // share of a keyframe's points: the surface leaves out what was seen once, or from afar
const samples = { vertices: 128, points: 32 }; // of a cube, of a keyframe
const period = 500; // ms between two looks

/** A place along one axis in cells, and three of them as one number. */
const along = (value) => Math.floor(value / cell) + 32768;
const cellOf = (i, j, k) => (i * 65536 + j) * 65536 + k;

/** Where there is surface: each cell with how many cubes of the surface say so. */
export class Filled {
  #counts = new Map();

  /** @returns {Set<number>} the cells that a cube fills, to be taken away with it */
  add(positions, n, { origin: [x, y, z], unit }) {
    const cells = new Set();
    const step = 4 * Math.ceil(n / samples.vertices);
    for (let at = 0; at < 4 * n; at += step) {
      const [px, py, pz] = [x + unit * positions[at], y + unit * positions[at + 1], z + unit * positions[at + 2]];
      const [endX, endY, endZ] = [along(px + reach), along(py + reach), along(pz + reach)];
      for (let i = along(px - reach); i <= endX; ++i)
        for (let j = along(py - reach); j <= endY; ++j) for (let k = along(pz - reach); k <= endZ; ++k) cells.add(cellOf(i, j, k));
    }
    for (const each of cells) this.#counts.set(each, (this.#counts.get(each) ?? 0) + 1);
    return cells;
  }

  remove(cells) {
    for (const each of cells) {
      const left = this.#counts.get(each) - 1;
      if (left > 0) this.#counts.set(each, left);
      else this.#counts.delete(each);
    }
  }

  has({ x, y, z }) {
    return this.#counts.has(cellOf(along(x), along(y), along(z)));
  }
}

/** @returns {boolean} whether the surface shows what a keyframe's points show */
export function isCovered(filled, { geometry, matrixWorld }) {
  const { array, count } = geometry.attributes.position;
  const step = Math.ceil(count / samples.points);
  const place = new Vector3();
  let [seen, covered] = [0, 0];
  for (let i = 0; i < count; i += step) {
    seen += 1;
    covered += filled.has(place.fromArray(array, 4 * i).applyMatrix4(matrixWorld));
  }
  return covered >= enough * seen;
}

/** Looks, as surface and points come, at which keyframes' points are covered. */
export function keepCovered(stage, board, switches, { mesh, points }) {
  let isOld = true;
  for (const channel of ["mesh", "points", "graph"]) board.on(channel, () => (isOld = true));
  switches.on(["mesh", "points"], () => (isOld = true));
  setInterval(() => {
    if (!isOld || document.hidden) return;
    isOld = false;
    // Whoever chose points wants all of them.
    if (points.cover(switches.is("mesh") && !switches.chosen.has("points") ? mesh.filled : null)) stage.invalidate();
  }, period);
}
