// The dense surface, a mesh for each of its cubes. Only the sides that were seen are drawn: one looks into rooms from outside.
import { BufferAttribute, BufferGeometry, Group, Mesh, Raycaster, ShaderMaterial } from "three";
import { meshArrays } from "../messages.js";
import { Filled } from "./cover.js";
import { chooseLevels, coarsen } from "./mesh_levels.js";

const most = 4_000_000; // triangles drawn at once on a machine that is quick enough
const preparing = 8; // ms of a frame

const vertexShader = `
  attribute vec3 colour;
  varying vec3 shown, facing, towards;
  void main() {
    vec4 p = modelViewMatrix * vec4(position, 1.0);
    gl_Position = projectionMatrix * p;
    shown = colour;
    facing = normalMatrix * normal;
    towards = -p.xyz;
  }`;
const fragmentShader = `
  uniform float shade;
  varying vec3 shown, facing, towards;
  void main() {
    float light = abs(dot(normalize(facing), normalize(towards)));
    gl_FragColor = vec4(shown * mix(1.0, 0.62 + 0.45 * light, shade), 1.0);
  }`;

export class MeshView {
  #cubes = new Map();

  constructor(stage, board, switches) {
    this.stage = stage;
    this.root = new Group();
    this.triangles = 0;
    this.filled = new Filled();
    stage.map.add(this.root);
    this.material = new ShaderMaterial({ vertexShader, fragmentShader, uniforms: { shade: { value: 1 } } });
    board.on("mesh", (item, key) => this.#take(item, key));
    switches.on(["mesh", "shade"], () => {
      this.root.visible = switches.is("mesh");
      this.material.uniforms.shade.value = switches.is("shade") ? 1 : 0;
      stage.invalidate();
    });
    stage.beforeFrame(() => this.#choose());
  }

  #take(item, key) {
    const old = this.#cubes.get(key);
    if (old) {
      this.triangles -= old.counts[0];
      this.filled.remove(old.cells);
      old.mesh.removeFromParent();
      for (const geometry of old.levels) geometry.dispose();
      this.#cubes.delete(key);
    }
    if (item && item.header.n_triangles > 0) this.#add(item, key);
    this.stage.invalidate();
  }

  #add(item, key) {
    const levels = [geometryOf(item)];
    const mesh = new Mesh(levels[0], this.material);
    mesh.position.fromArray(item.header.origin);
    mesh.scale.setScalar(item.header.unit);
    mesh.updateMatrixWorld();
    this.root.add(mesh);
    const n = item.header.n_triangles;
    const { array, count } = levels[0].attributes.position;
    this.#cubes.set(key, { mesh, levels, counts: [n], distance: 0, item, cells: this.filled.add(array, count, item.header) });
    this.triangles += n;
  }

  /** All cubes finely where the machine is quick enough, else the nearest ones; none is left out. */
  #choose() {
    const budget = most * this.stage.ease;
    const cubes = [...this.#cubes.values()];
    const all = !this.root.visible || this.triangles <= budget;
    if (!all) this.#prepare(cubes);
    const chosen = all ? null : chooseLevels(cubes, budget);
    for (const cube of cubes) cube.mesh.geometry = cube.levels[all ? 0 : chosen.get(cube)];
  }

  /** Coarser levels where they are wanted for the first time, a few in each frame; distances from the viewer. */
  #prepare(cubes) {
    const end = performance.now() + preparing * (this.stage.software ? 4 : 1);
    for (const cube of cubes) {
      const { mesh, levels, counts, item } = cube;
      if (levels.length === 1 && performance.now() < end) {
        const { packed, triangles } = meshArrays(item);
        for (const fewer of coarsen(packed, triangles)) {
          levels.push(withTriangles(levels[0], fewer));
          counts.push(fewer.length / 3);
        }
      }
      cube.distance = levels[0].boundingSphere.center.clone().applyMatrix4(mesh.matrixWorld).distanceTo(this.stage.camera.position);
    }
  }

  /** @returns {{place, distance}|null} where a ray meets the surface */
  pick(ray) {
    if (!this.root.visible) return null;
    const caster = new Raycaster(ray.origin, ray.direction);
    const hit = caster.intersectObject(this.root, true)[0];
    return hit ? { place: hit.point, distance: hit.distance } : null;
  }

  /** Centres of the cubes. */
  centres() {
    return [...this.#cubes.values()].map(({ mesh, levels }) => levels[0].boundingSphere.center.clone().applyMatrix4(mesh.matrixWorld));
  }
}

/** Unpacks 10-bit positions and octahedral normals into what graphics cards read. */
function geometryOf(item) {
  const { packed, normals, colours, triangles } = meshArrays(item);
  const n = packed.length;
  const positions = new Uint16Array(4 * n);
  const directions = new Int8Array(4 * n);
  const wide = new Uint8Array(4 * n);
  for (let i = 0; i < n; ++i) {
    positions[4 * i] = packed[i] & 1023;
    positions[4 * i + 1] = (packed[i] >>> 10) & 1023;
    positions[4 * i + 2] = (packed[i] >>> 20) & 1023;
    unfold(normals[2 * i] / 127, normals[2 * i + 1] / 127, directions, 4 * i);
    for (let k = 0; k < 3; ++k) wide[4 * i + k] = colours[3 * i + k];
  }
  const geometry = new BufferGeometry();
  geometry.setAttribute("position", new BufferAttribute(positions, 4));
  geometry.setAttribute("normal", new BufferAttribute(directions, 4, true));
  geometry.setAttribute("colour", new BufferAttribute(wide, 4, true));
  geometry.setIndex(new BufferAttribute(triangles.slice(), 1));
  geometry.computeBoundingSphere();
  return geometry;
}

/** The same vertices with other triangles. */
function withTriangles(geometry, triangles) {
  const other = new BufferGeometry();
  for (const [name, attribute] of Object.entries(geometry.attributes)) other.setAttribute(name, attribute);
  other.setIndex(new BufferAttribute(triangles, 1));
  other.boundingSphere = geometry.boundingSphere;
  return other;
}

/** A direction from the octahedron's unfolded faces (Meyer et al., On Floating-Point Normal Vectors, 2010). */
function unfold(u, v, out, at) {
  const z = 1 - Math.abs(u) - Math.abs(v);
  const x = z >= 0 ? u : (1 - Math.abs(v)) * (u >= 0 ? 1 : -1);
  const y = z >= 0 ? v : (1 - Math.abs(u)) * (v >= 0 ? 1 : -1);
  const scale = 127 / Math.hypot(x, y, z);
  out[at] = x * scale;
  out[at + 1] = y * scale;
  out[at + 2] = z * scale;
}
