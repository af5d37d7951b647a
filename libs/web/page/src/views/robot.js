// The robot: a translucent box with a wedge ahead, where the best mapper says it is; the others as wedges on the ground.
import { BoxGeometry, BufferAttribute, BufferGeometry, EdgesGeometry, Group, LineBasicMaterial, LineLoop, LineSegments, Mesh, MeshBasicMaterial, Quaternion, Vector3 } from "three";

const order = ["icp", "fastslam", "odometry", "truth"];
const mappers = ["icp", "fastslam"];
const unsure = ["LOST", "SILENT"]; // nobody knows where the robot is now: LOST is a guess, SILENT of once
const settle = 0.12; // s in which the robot glides to its newest pose

export class RobotView {
  #poses = {};

  constructor(stage, board, switches, view, onTheme) {
    Object.assign(this, { stage, switches, view });
    this.body = new Group();
    this.body.visible = false;
    stage.front.add(this.body);
    this.fill = new MeshBasicMaterial({ transparent: true, opacity: 0.1, depthWrite: false });
    this.edge = new LineBasicMaterial({ transparent: true, opacity: 0.9 });
    this.nose = new MeshBasicMaterial({ transparent: true, opacity: 0.85, side: 2 });
    this.#shape({ length: 0.5, width: 0.4, height: 0.5 });
    this.wedges = Object.fromEntries(order.map((name) => [name, wedge(stage)]));
    this.ellipse = new LineLoop(circle(), this.edge);
    stage.front.add(this.ellipse);
    onTheme((colours) => {
      for (const { color } of [this.fill, this.nose]) color.copy(colours.accent);
      this.edge.color.copy(colours.ink);
      for (const name of order) this.wedges[name].material.color.copy(colours[name]);
    });
    board.on("about", (item) => item?.header.robot && this.#shape(item.header.robot));
    board.on("poses", (item) => this.#take(item?.header ?? {}));
    switches.on(["robot", ...order], () => this.#show());
  }

  #shape({ length, width, height }) {
    for (const child of [...this.body.children]) {
      this.body.remove(child);
      child.geometry.dispose();
    }
    const box = new BoxGeometry(length, width, height).translate(0, 0, height / 2 + 0.01);
    const nose = new BufferGeometry();
    const [x, y, z] = [length / 2, width / 2, height + 0.002];
    nose.setAttribute("position", new BufferAttribute(new Float32Array([x, 0, z, -0.2 * x, 0.7 * y, z, -0.2 * x, -0.7 * y, z]), 3));
    this.body.add(new Mesh(box, this.fill), new LineSegments(new EdgesGeometry(box), this.edge), new Mesh(nose, this.nose));
    this.body.children.forEach((child) => (child.renderOrder = 4));
  }

  #take(header) {
    const last = this.main;
    this.#poses = Object.fromEntries(order.map((name) => [name, header[name] ?? null]));
    this.main = mapperOf(header) ?? order.find((name) => this.#poses[name]?.T);
    this.edge.opacity = unsure.includes(this.#poses[this.main]?.status) ? 0.25 : 0.9; // where it was once, or may be
    this.#show();
    for (const name of order) if (this.#poses[name]?.T) put(this.wedges[name], this.#poses[name].T);
    if (!this.main) return;
    this.#glide(this.#poses[this.main].T, last === this.main);
    this.#spread(this.#poses[this.main]);
  }

  #show() {
    const shown = this.switches.is("robot");
    this.body.visible = shown && Boolean(this.main);
    for (const name of order)
      this.wedges[name].visible = shown && name !== this.main && this.switches.is(name) && Boolean(this.#poses[name]?.T);
    this.ellipse.visible = this.body.visible && Boolean(this.#poses[this.main]?.sigma);
    this.stage.refresh();
  }

  #glide([x, y, z, qw, qx, qy, qz], near) {
    const position = new Vector3(x, y, z);
    const turn = new Quaternion(qx, qy, qz, qw);
    const [from, turned] = [this.body.position.clone(), this.body.quaternion.clone()];
    this.stopGlide?.();
    const step = (share) => {
      this.body.position.lerpVectors(from, position, share);
      this.body.quaternion.slerpQuaternions(turned, turn, share);
      this.ellipse.position.copy(this.body.position);
      this.view.robotAt(this.body.position, yawOf(this.body.quaternion));
    };
    const still = position.distanceTo(from) < 2e-3 && turn.angleTo(turned) < 2e-3;
    const slow = this.stage.frameTime > 0.04; // frames between two poses would come too late
    if (!near || still || slow || position.distanceTo(from) > 1) step(1);
    else this.stopGlide = this.stage.animate(settle, step, true);
  }

  /** The ellipse of two sigma on the ground; sigma is in the robot's own directions. */
  #spread({ T, sigma }) {
    if (!sigma) return;
    this.ellipse.scale.set(Math.max(2 * sigma[0], 1e-4), Math.max(2 * sigma[1], 1e-4), 1);
    this.ellipse.quaternion.set(T[4], T[5], T[6], T[3]);
  }

  /** @returns {{position: Vector3, yaw: number}|null} of the robot that is drawn */
  get pose() {
    return this.main ? { position: this.body.position, yaw: yawOf(this.body.quaternion) } : null;
  }
}

/** @returns {string|undefined} whose pose the robot's is: the first mapper's that knows it, else that guesses, else that told one */
export function mapperOf(header) {
  const told = mappers.filter((name) => header[name]?.T);
  const without = (statuses) => told.find((name) => !statuses.includes(header[name].status));
  return without(unsure) ?? without(["SILENT"]) ?? told[0];
}

export function yawOf({ x, y, z, w }) {
  return Math.atan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z));
}

function put(object, [x, y, z, qw, qx, qy, qz]) {
  object.position.set(x, y, z + 0.012);
  object.quaternion.set(qx, qy, qz, qw);
}

function wedge(stage) {
  const geometry = new BufferGeometry();
  geometry.setAttribute("position", new BufferAttribute(new Float32Array([0.2, 0, 0, -0.1, 0.1, 0, -0.1, -0.1, 0]), 3));
  const mesh = new Mesh(geometry, new MeshBasicMaterial({ transparent: true, opacity: 0.9, side: 2, depthTest: false }));
  mesh.renderOrder = 5;
  stage.front.add(mesh);
  return mesh;
}

function circle() {
  const points = Array.from({ length: 48 }, (_, i) => [Math.cos((i * Math.PI) / 24), Math.sin((i * Math.PI) / 24), 0.01]).flat();
  const geometry = new BufferGeometry();
  geometry.setAttribute("position", new BufferAttribute(new Float32Array(points), 3));
  return geometry;
}
