// FastSLAM's landmarks: a dot for each mean, and near the viewer the ellipsoid in which it lies at two sigma.
import { BufferAttribute, BufferGeometry, Group, IcosahedronGeometry, OctahedronGeometry, InstancedBufferAttribute, InstancedMesh, Matrix4, Points, ShaderMaterial } from "three";
import { landmarkBytes } from "../messages.js";

const near = 8; // m: farther ellipsoids are smaller than their dots
const most = 8000; // ellipsoids drawn at once
const sigmas = 2;
const smallest = 2.5; // px, radius

const dotVertex = `
  uniform float scale;
  attribute vec3 colour;
  varying vec3 shown;
  void main() {
    vec4 p = modelViewMatrix * vec4(position, 1.0);
    gl_Position = projectionMatrix * p;
    gl_PointSize = clamp(0.018 * scale / -p.z, 2.0, 12.0);
    shown = colour;
  }`;
const dotFragment = `
  uniform vec3 rim;
  varying vec3 shown;
  void main() {
    vec2 q = 2.0 * gl_PointCoord - 1.0;
    float r = dot(q, q);
    if (r > 1.0) discard;
    gl_FragColor = vec4(r > 0.45 ? rim : shown, 1.0);
  }`;
const ellipsoidVertex = `
  attribute vec3 colour;
  varying vec3 shown, facing, towards;
  void main() {
    vec4 p = modelViewMatrix * instanceMatrix * vec4(position, 1.0);
    gl_Position = projectionMatrix * p;
    facing = mat3(viewMatrix) * (transpose(inverse(mat3(instanceMatrix))) * position);
    towards = -p.xyz;
    shown = colour;
  }`;
const ellipsoidFragment = `
  uniform vec3 rim;
  varying vec3 shown, facing, towards;
  void main() {
    float light = abs(dot(normalize(facing), normalize(towards)));
    gl_FragColor = vec4(mix(rim, shown, 0.6 * light), 0.06 + 0.5 * (1.0 - light));
  }`;

export class LandmarksView {
  #cubes = new Map();

  constructor(stage, board, switches, onTheme) {
    Object.assign(this, { stage, switches });
    this.root = new Group();
    this.total = 0;
    stage.map.add(this.root);
    const rim = { value: null };
    this.dots = new ShaderMaterial({ vertexShader: dotVertex, fragmentShader: dotFragment, uniforms: { scale: { value: 1 }, rim } });
    this.shells = new ShaderMaterial({ vertexShader: ellipsoidVertex, fragmentShader: ellipsoidFragment, uniforms: { rim }, transparent: true, depthWrite: false });
    this.sphere = stage.software ? new OctahedronGeometry(1, 1) : new IcosahedronGeometry(1, 1);
    onTheme(({ fastslam }) => (rim.value = fastslam.clone()));
    board.on("landmarks", (item, key) => this.#take(item, key));
    switches.on(["landmarks", "ellipsoids"], () => {
      this.root.visible = switches.is("landmarks");
      stage.invalidate();
    });
    stage.beforeFrame(() => this.#choose());
  }

  #take(item, key) {
    const old = this.#cubes.get(key);
    if (old) {
      this.total -= old.n;
      this.root.remove(old.points);
      old.points.geometry.dispose();
      if (old.ellipsoids) this.#drop(old);
      this.#cubes.delete(key);
    }
    if (item && item.header.n > 0) this.#add(item, key);
    this.stage.invalidate();
  }

  #add(item, key) {
    const n = item.header.n;
    const view = new DataView(item.buffer, item.at, n * landmarkBytes);
    const means = new Float32Array(3 * n);
    const colours = new Uint8Array(4 * n);
    for (let i = 0; i < n; ++i) {
      for (let k = 0; k < 3; ++k) means[3 * i + k] = view.getFloat32(landmarkBytes * i + 4 * k, true);
      for (let k = 0; k < 3; ++k) colours[4 * i + k] = view.getUint8(landmarkBytes * i + 40 + k);
    }
    const geometry = new BufferGeometry();
    geometry.setAttribute("position", new BufferAttribute(means, 3));
    geometry.setAttribute("colour", new BufferAttribute(colours, 4, true));
    geometry.computeBoundingSphere();
    const points = new Points(geometry, this.dots);
    this.root.add(points);
    this.#cubes.set(key, { n, view, means, colours, points, ellipsoids: null });
    this.total += n;
  }

  /** Ellipsoids are made for cubes that are near, and only then. */
  #choose() {
    const { camera, size } = this.stage;
    this.dots.uniforms.scale.value = (size.y / 2) * camera.projectionMatrix.elements[5];
    const wanted = this.root.visible && this.switches.is("ellipsoids");
    const cubes = [...this.#cubes.values()];
    for (const cube of cubes) {
      const { center, radius } = cube.points.geometry.boundingSphere;
      cube.distance = center.distanceTo(camera.position) - radius;
    }
    let left = most * this.stage.ease ** 2; // they are the first that slow machines leave out
    for (const cube of cubes.sort((a, b) => a.distance - b.distance)) {
      const drawn = wanted && cube.distance < near && left > 0;
      if (drawn && !cube.ellipsoids) this.root.add((cube.ellipsoids = this.#ellipsoids(cube)));
      if (cube.ellipsoids) cube.ellipsoids.visible = drawn;
      if (!drawn) continue;
      // The largest come first: those that would be smaller than their dots are left out.
      const least = (smallest * Math.max(cube.distance, 0.3)) / this.dots.uniforms.scale.value;
      const seen = cube.sizes.findIndex((size) => size < least);
      cube.ellipsoids.count = Math.min(seen < 0 ? cube.n : seen, Math.ceil(left));
      left -= cube.ellipsoids.count;
    }
  }

  #ellipsoids(cube) {
    const { n, view, means, colours } = cube;
    const covariances = Array.from({ length: n }, (_, i) => Array.from({ length: 6 }, (_, k) => view.getFloat32(landmarkBytes * i + 12 + 4 * k, true)));
    const size = ([xx, , , yy, , zz]) => sigmas * Math.sqrt(Math.max(xx, yy, zz));
    const order = covariances.map((_, i) => i).sort((i, j) => size(covariances[j]) - size(covariances[i]));
    cube.sizes = order.map((i) => size(covariances[i]));
    const mesh = new InstancedMesh(this.sphere.clone(), this.shells, n);
    const matrix = new Matrix4();
    const sorted = new Uint8Array(4 * n);
    order.forEach((i, at) => {
      mesh.setMatrixAt(at, ellipsoidMatrix(means.subarray(3 * i, 3 * i + 3), covariances[i], matrix));
      sorted.set(colours.subarray(4 * i, 4 * i + 4), 4 * at);
    });
    mesh.geometry.setAttribute("colour", new InstancedBufferAttribute(sorted, 4, true));
    mesh.computeBoundingSphere();
    return mesh;
  }

  #drop(cube) {
    this.root.remove(cube.ellipsoids);
    cube.ellipsoids.geometry.dispose();
    cube.ellipsoids.dispose();
  }

  /** @returns the landmark next to a ray, within `cone` rad of it */
  pick(ray, cone) {
    if (!this.root.visible) return null;
    let best = null;
    const place = ray.origin.clone();
    for (const { n, means, view } of this.#cubes.values())
      for (let i = 0; i < n; ++i) {
        place.fromArray(means, 3 * i);
        const distance = place.distanceTo(ray.origin);
        if (ray.distanceToPoint(place) > Math.tan(cone) * distance || (best && best.distance <= distance)) continue;
        const sigma = Math.sqrt(Math.max(...[0, 3, 5].map((k) => view.getFloat32(landmarkBytes * i + 12 + 4 * k, true))));
        best = { place: place.clone(), distance, landmark: view.getUint32(landmarkBytes * i + 36, true), sigma, observations: view.getUint8(landmarkBytes * i + 43) };
      }
    return best;
  }

  /** Centres of the cubes. */
  centres() {
    return [...this.#cubes.values()].map(({ points }) => points.geometry.boundingSphere.center.clone());
  }
}

/**
 * Takes the unit sphere to the ellipsoid of two sigma: any root L of the covariance (L L^T) does; this one is Cholesky's.
 * @param covariance xx xy xz yy yz zz, m^2
 */
export function ellipsoidMatrix([x, y, z], [xx, xy, xz, yy, yz, zz], out) {
  const least = 1e-10; // (0.01 mm)^2: flat ones stay invertible
  const a = Math.sqrt(Math.max(xx, least));
  const b = xy / a;
  const c = xz / a;
  const d = Math.sqrt(Math.max(yy - b * b, least));
  const e = (yz - b * c) / d;
  const f = Math.sqrt(Math.max(zz - c * c - e * e, least));
  const s = sigmas;
  return out.set(s * a, 0, 0, x, s * b, s * d, 0, y, s * c, s * e, s * f, z, 0, 0, 0, 1);
}
