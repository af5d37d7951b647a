// A coarser surface out of the same vertices, for what is far and for slow machines: vertices of a cell become one
// (Rossignac and Borrel, Multi-resolution 3D approximations, 1993).

const shares = [1 / 8, 1 / 64]; // of the triangles that each coarser level may have
const mostCells = 2 ** 17;
const cells = [4, 5, 6, 7, 8]; // bits of the 10 that a cell leaves out

/**
 * @param {Uint32Array} packed positions, 10 bits each
 * @param {Uint16Array|Uint32Array} triangles
 * @returns {(Uint16Array|Uint32Array)[]} fewer and fewer triangles of the same vertices
 */
export function coarsen(packed, triangles) {
  const levels = [];
  for (const bits of cells) {
    const fewer = cluster(packed, levels.at(-1) ?? triangles, bits);
    if (fewer.length <= shares[levels.length] * triangles.length || bits === cells.at(-1)) levels.push(fewer);
    if (levels.length === shares.length) break;
  }
  return levels;
}

/**
 * How well a position stands for its cell: along each axis the outermost where the cell touches the cube's border, so that
 * cubes go on touching, else the cell's middle, so that triangles do not turn over.
 */
function fitness(p, bits) {
  const size = 1 << bits;
  let sum = 0;
  for (const value of [p & 1023, (p >>> 10) & 1023, (p >>> 20) & 1023]) {
    const outwards = Math.abs(value - 511.5);
    sum += outwards > 512 - size ? outwards : -Math.abs((value & (size - 1)) - size / 2);
  }
  return sum;
}

function cluster(packed, triangles, bits) {
  const numbers = new Map();
  const firsts = []; // of each cell the vertex that stands for all of it
  const best = [];
  const cellOf = new Uint32Array(packed.length);
  const mask = (1023 >>> bits) << bits;
  for (let i = 0; i < packed.length; ++i) {
    const cell = packed[i] & (mask | (mask << 10) | (mask << 20));
    if (!numbers.has(cell)) {
      numbers.set(cell, firsts.length);
      firsts.push(i);
    }
    const number = (cellOf[i] = numbers.get(cell));
    const fit = fitness(packed[i], bits);
    if (best[number] === undefined || fit > best[number]) [best[number], firsts[number]] = [fit, i];
  }
  const kept = [];
  const seen = new Set();
  for (let t = 0; t < triangles.length; t += 3) {
    const [a, b, c] = [cellOf[triangles[t]], cellOf[triangles[t + 1]], cellOf[triangles[t + 2]]];
    if (a === b || b === c || c === a) continue;
    const least = Math.min(a, b, c);
    // The same triangle, whichever corner comes first; its winding counts.
    const [p, q, r] = least === a ? [a, b, c] : least === b ? [b, c, a] : [c, a, b];
    const name = (p * mostCells + q) * mostCells + r; // below 2^53
    if (seen.has(name)) continue;
    seen.add(name);
    kept.push(firsts[p], firsts[q], firsts[r]);
  }
  return new triangles.constructor(kept);
}

/**
 * All cubes at their coarsest, then the nearest ones finer, step by step, as far as the budget goes.
 * @param {{counts: number[], distance: number}[]} cubes triangles of each level, the finest first
 * @returns {Map} the level of each cube
 */
export function chooseLevels(cubes, budget) {
  const nearest = [...cubes].sort((a, b) => a.distance - b.distance);
  const chosen = new Map(nearest.map((cube) => [cube, cube.counts.length - 1]));
  let left = nearest.reduce((rest, { counts }) => rest - counts.at(-1), budget);
  for (let level = shares.length - 1; level >= 0; --level)
    for (const cube of nearest) {
      if (chosen.get(cube) !== level + 1) continue;
      left -= cube.counts[level] - cube.counts[level + 1];
      if (left < 0) return chosen;
      chosen.set(cube, level);
    }
  return chosen;
}
