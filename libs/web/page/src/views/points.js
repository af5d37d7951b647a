// Keyframes' coloured points. Each piece hangs on its keyframe; levels add up.
import { BufferAttribute, BufferGeometry, Frustum, Matrix4, Points, ShaderMaterial, Sphere, Vector3 } from "three";
import { pointArrays } from "../messages.js";
import { isCovered } from "./cover.js";
import { budgets, choose, surplus } from "./point_budget.js";

const finest = 0.014; // m, size of a point where all levels are drawn
const levels = 3;

const vertexShader = `
  uniform float size, scale;
  attribute vec3 colour;
  varying vec3 shown;
  void main() {
    vec4 p = modelViewMatrix * vec4(position, 1.0);
    gl_Position = projectionMatrix * p;
    gl_PointSize = clamp(size * scale / -p.z, 1.5, 48.0);
    shown = colour;
  }`;
const fragmentShader = `
  varying vec3 shown;
  void main() {
    vec2 q = 2.0 * gl_PointCoord - 1.0;
    if (dot(q, q) > 1.1) discard;
    gl_FragColor = vec4(shown, 1.0);
  }`;

export class PointsView {
  #pieces = new Map();
  #covered = new Set(); // keyframes that the surface shows
  #frustum = new Frustum();
  #matrix = new Matrix4();
  #sphere = new Sphere();

  constructor(stage, board, switches, poses) {
    Object.assign(this, { stage, switches, poses });
    this.budgets = budgets();
    this.resident = 0;
    this.drawn = 0;
    // Where finer levels are missing, points are larger, so that surfaces stay closed.
    this.materials = Array.from({ length: levels }, (_, level) => new ShaderMaterial({
      vertexShader, fragmentShader, uniforms: { size: { value: finest * 1.7 ** (levels - 1 - level) }, scale: { value: 1 } },
    }));
    board.on("points", (item, key) => this.#take(item, key));
    switches.on(["points"], () => stage.invalidate());
    stage.beforeFrame(() => this.#choose());
  }

  #take(item, key) {
    this.#remove(key);
    if (item && item.header.n > 0) this.#add(item, key);
    this.stage.invalidate();
  }

  #add(item, key) {
    const { keyframe, level, n, unit, T } = item.header;
    const { positions, colours } = pointArrays(item);
    const geometry = new BufferGeometry();
    geometry.setAttribute("position", new BufferAttribute(widen(positions, n), 4));
    geometry.setAttribute("colour", new BufferAttribute(widen(colours, n), 4, true));
    geometry.computeBoundingSphere();
    const points = new Points(geometry, this.materials[Math.min(level, levels - 1)]);
    points.scale.setScalar(unit);
    points.frustumCulled = false; // choose() looks
    this.poses.group(keyframe, T).add(points);
    points.updateMatrixWorld();
    this.#pieces.set(key, { key, keyframe, level: Math.min(level, levels - 1), n, points, distance: 0, centre: new Vector3() });
    this.resident += n;
    item.buffer = null; // the numbers are in the attributes now
    if (this.resident > this.budgets.resident) {
      this.#measure();
      for (const piece of surplus([...this.#pieces.values()], this.budgets.resident)) this.#remove(piece.key);
    }
  }

  #remove(key) {
    const piece = this.#pieces.get(key);
    if (!piece) return;
    this.#pieces.delete(key);
    this.resident -= piece.n;
    piece.points.removeFromParent();
    piece.points.geometry.dispose();
  }

  /** Distances of all pieces from the viewer. @returns those in sight */
  #measure() {
    const { camera } = this.stage;
    this.#frustum.setFromProjectionMatrix(this.#matrix.multiplyMatrices(camera.projectionMatrix, camera.matrixWorldInverse));
    const inSight = [];
    for (const piece of this.#pieces.values()) {
      const sphere = this.#sphere.copy(piece.points.geometry.boundingSphere).applyMatrix4(piece.points.matrixWorld);
      piece.centre.copy(sphere.center);
      piece.distance = Math.max(0, sphere.center.distanceTo(camera.position) - sphere.radius);
      if (this.#frustum.intersectsSphere(sphere)) inSight.push(piece);
    }
    return inSight;
  }

  #choose() {
    const shown = this.switches.is("points");
    const pieces = this.#measure().filter(({ keyframe }) => !this.#covered.has(keyframe));
    const chosen = shown ? choose(pieces, this.budgets.drawn * this.stage.ease) : new Set();
    const fine = new Map(); // of each keyframe the finest level that is drawn
    this.drawn = 0;
    for (const piece of this.#pieces.values()) {
      piece.points.visible = chosen.has(piece);
      if (!piece.points.visible) continue;
      this.drawn += piece.n;
      fine.set(piece.keyframe, Math.max(piece.level, fine.get(piece.keyframe) ?? 0));
    }
    for (const piece of chosen) piece.points.material = this.materials[fine.get(piece.keyframe)];
    const { size, camera } = this.stage;
    for (const material of this.materials) material.uniforms.scale.value = (size.y / 2) * camera.projectionMatrix.elements[5];
  }

  /** Points that the surface shows give way to it; null: none do. @returns {boolean} whether that changes what is drawn */
  cover(filled) {
    const before = this.#covered;
    const coarse = filled ? [...this.#pieces.values()].filter(({ level }) => level === 0) : [];
    this.#covered = new Set(coarse.filter(({ points }) => isCovered(filled, points)).map(({ keyframe }) => keyframe));
    return this.#covered.size !== before.size || [...before].some((keyframe) => !this.#covered.has(keyframe));
  }

  /** @returns the point next to a ray of those within `cone` (rad) of it, null without one */
  pick(ray, cone) {
    let best = null;
    for (const { points } of this.#pieces.values()) {
      if (!points.visible) continue;
      const sphere = this.#sphere.copy(points.geometry.boundingSphere).applyMatrix4(points.matrixWorld);
      if (ray.distanceToPoint(sphere.center) > sphere.radius * 1.05) continue;
      const at = nearest(points.geometry.attributes.position.array, ray.clone().applyMatrix4(points.matrixWorld.clone().invert()), cone);
      if (at === null) continue;
      const place = new Vector3(...at).applyMatrix4(points.matrixWorld);
      const distance = place.distanceTo(ray.origin);
      if (!best || distance < best.distance) best = { place, distance };
    }
    return best;
  }

  /** Calls for the centre of each piece. */
  centres() {
    this.#measure();
    return [...this.#pieces.values()].filter(({ level }) => level === 0).map(({ centre }) => centre);
  }
}

/** Three numbers a point as four: what graphics cards read without copying. */
function widen(values, n) {
  const wide = new values.constructor(4 * n);
  for (let i = 0; i < n; ++i) {
    wide[4 * i] = values[3 * i];
    wide[4 * i + 1] = values[3 * i + 1];
    wide[4 * i + 2] = values[3 * i + 2];
  }
  return wide;
}

/** The first point along a ray (all in the points' own units) within a cone about it. */
function nearest(positions, { origin: o, direction }, cone) {
  const d = direction.clone().normalize();
  const limit = Math.tan(cone) ** 2;
  let found = -1;
  let least = Infinity;
  for (let i = 0; i < positions.length; i += 4) {
    const [x, y, z] = [positions[i] - o.x, positions[i + 1] - o.y, positions[i + 2] - o.z];
    const along = x * d.x + y * d.y + z * d.z;
    if (along <= 0 || along > least) continue;
    if (x * x + y * y + z * z - along * along < limit * along * along) {
      least = along;
      found = i;
    }
  }
  return found < 0 ? null : [positions[found], positions[found + 1], positions[found + 2]];
}
