// What is shown: one boolean each, with who listens. The address keeps what differs from the defaults.

export const layers = [
  { name: "mesh", label: "Surface", group: "6-D SLAM", on: true, key: "1", about: "the dense coloured surface" },
  { name: "points", label: "Points", group: "6-D SLAM", on: true, key: "2", about: "keyframes' coloured points, where the surface does not show the same; off and on: all of them" },
  { name: "icp", label: "Path", group: "6-D SLAM", on: true, swatch: true, about: "where 6-D SLAM says the robot was" },
  { name: "keyframes", label: "Keyframes", group: "6-D SLAM", on: true, key: "5", about: "keyframes and the loops between them" },
  { name: "landmarks", label: "Landmarks", group: "FastSLAM", on: true, key: "3", about: "FastSLAM's landmarks" },
  { name: "ellipsoids", label: "2 σ", aloud: "Ellipsoids of two sigma", group: "FastSLAM", on: true, key: "4", about: "where a landmark is, two sigma" },
  { name: "particles", label: "Particles", group: "FastSLAM", on: true, key: "6", about: "poses that the filter holds possible" },
  { name: "fastslam", label: "Path", group: "FastSLAM", on: true, swatch: true, about: "where FastSLAM says the robot was" },
  { name: "odometry", label: "Odometry", group: "Robot", on: false, swatch: true, about: "the path by odometry alone" },
  { name: "truth", label: "Truth", group: "Robot", on: true, swatch: true, about: "the true path, where it is known" },
  { name: "robot", label: "Robot", group: "Robot", on: true, about: "the robot's shape" },
  { name: "grid", label: "Free space", group: "Layers", on: false, key: "7", about: "where the robot can drive" },
  { name: "planes", label: "Planes", group: "Layers", on: false, key: "8", about: "floors, tables and walls" },
  { name: "objects", label: "Objects", group: "Layers", on: false, key: "9", about: "what stands on planes" },
  { name: "ground", label: "Ground", group: "Robot", on: true, about: "lines on the ground, 1 m apart" },
  { name: "shade", label: "Shading", group: "Layers", on: true, key: "0", about: "light from the viewer on the surface" },
];

const defaults = Object.fromEntries(layers.map(({ name, on }) => [name, on]));

export class Switches {
  #values = { ...defaults };
  #listeners = [];
  /** Which of them a person, or the address, chose. */
  chosen = new Set();

  is(name) {
    return this.#values[name];
  }

  /** Calls now and at each change of any of `names`. */
  on(names, listener) {
    this.#listeners.push({ names, listener });
    listener();
  }

  set(name, value) {
    if (!(name in this.#values)) return;
    this.chosen.add(name);
    if (this.#values[name] === value) return;
    this.#values[name] = value;
    for (const { names, listener } of this.#listeners) if (names.includes(name) || names.includes("*")) listener();
  }

  toggle(name) {
    this.set(name, !this.is(name));
  }

  /** @returns {{on: string[], off: string[]}} what differs from the defaults */
  differences() {
    const differ = Object.keys(defaults).filter((name) => this.#values[name] !== defaults[name]);
    return { on: differ.filter((name) => this.is(name)), off: differ.filter((name) => !this.is(name)) };
  }
}
