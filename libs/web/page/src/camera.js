// Where the viewer stands: around a target, by yaw, pitch and distance. Views with names, and following the robot.
import { Vector3 } from "three";

const up = new Vector3(0, 0, 1);
const steepest = Math.PI / 2 - 0.001;

export const views = {
  free: { label: "Free view", key: "v" },
  front: { label: "Front view", key: "f" },
  top: { label: "View from above", key: "t" },
  robot: { label: "Robot's view", key: "r" },
};

const angles = { front: { yaw: -Math.PI, pitch: 0.35 }, top: { yaw: -Math.PI, pitch: steepest } };

export class View extends EventTarget {
  #stop = () => {};
  #flight = []; // places between which the target flies

  constructor(stage) {
    super();
    this.stage = stage;
    this.target = new Vector3(1.5, 0, 0.4);
    this.yaw = -2.3; // of the way from the target to the viewer
    this.pitch = 0.6;
    this.distance = 6;
    this.name = "free";
    this.follow = false;
    this.robot = null; // {position: Vector3, yaw}
    this.untouched = true; // nobody has chosen a view yet: it fits the map as that grows
    /** Where the map lies, for views that show all of it: {centre: Vector3, places: Vector3[]}. */
    this.extent = () => ({ centre: new Vector3(), places: [] });
    this.#place();
  }

  /** Turns about the target by angles in rad. */
  orbit(yaw, pitch) {
    this.#free();
    this.yaw += yaw;
    this.pitch = Math.max(-0.3, Math.min(steepest, this.pitch + pitch));
    this.#moved();
  }

  /** Moves the ground in the picture, to the right and downwards, by shares of the picture's height. */
  pan(right, down) {
    if (this.follow || this.name === "robot") this.setFollow(false);
    this.#free();
    const scale = 2 * this.distance * Math.tan((this.stage.camera.fov * Math.PI) / 360);
    const { sideways, ahead } = this.#ground();
    this.target.addScaledVector(sideways, -right * scale).addScaledVector(ahead, (down * scale) / Math.max(0.3, Math.sin(Math.abs(this.pitch))));
    this.#moved();
  }

  /** How far away things may be that belong to the map, seen from where all of it is in sight. */
  reach() {
    return 2 * this.#fit(this.yaw, this.pitch).distance;
  }

  /** Nearer (factor below 1) or farther; `towards`: a point that stays where it is in the picture. */
  zoom(factor, towards = null) {
    this.#halt();
    this.untouched = false;
    const distance = Math.max(0.3, Math.min(Math.max(150, this.distance, this.reach()), this.distance * factor));
    if (towards && !this.follow && this.name !== "robot") this.target.lerp(towards, 1 - distance / this.distance);
    this.distance = distance;
    this.#moved();
  }

  /** One of `views`. */
  show(name) {
    if (!(name in views)) return;
    this.name = name;
    this.untouched = false;
    const named = angles[name];
    const isFollowing = this.follow && this.robot;
    if (named) this.#flyTo({ ...(isFollowing ? { target: this.robot.position, distance: this.distance } : this.#fit(named.yaw, named.pitch)), ...named });
    if (name === "robot") this.#chase(true);
    this.#say();
  }

  /** Shows the whole map from where one looks now. */
  fitAll() {
    if (this.name !== "free" || this.follow) this.setFollow(false);
    const pitch = Math.max(0.5, this.pitch);
    this.#flyTo({ ...this.#fit(this.yaw, pitch), yaw: this.yaw, pitch });
  }

  /** Fits the map as it grows, as long as nobody has chosen a view. */
  keepAll() {
    if (!this.untouched) return;
    const { target, distance } = this.#fit(this.yaw, this.pitch);
    const fits = Math.abs(distance / this.distance - 1) < 0.1 && target.distanceTo(this.target) < 0.05 * distance;
    if (!fits) this.#flyTo({ target, yaw: this.yaw, pitch: this.pitch, distance });
  }

  /** @returns where to look, and from how far, so that all of the map is seen beside the panels */
  #fit(yaw, pitch) {
    const { camera, canvas, inset } = this.stage;
    const tangent = Math.tan((camera.fov * Math.PI) / 360) / 1.05;
    const wide = (tangent * (canvas.clientWidth - inset.left - inset.right)) / canvas.clientHeight;
    const high = (tangent * (canvas.clientHeight - inset.top - inset.bottom)) / canvas.clientHeight;
    const back = new Vector3(Math.cos(yaw) * Math.cos(pitch), Math.sin(yaw) * Math.cos(pitch), Math.sin(pitch));
    const right = new Vector3(-Math.sin(yaw), Math.cos(yaw), 0);
    const above = back.clone().cross(right);
    const { centre, places } = this.extent();
    let distance = 2;
    for (const place of places) {
      const p = place.clone().sub(centre);
      const aside = Math.max(Math.abs(p.dot(right)) / wide, Math.abs(p.dot(above)) / high);
      distance = Math.max(distance, p.dot(back) + aside);
    }
    return { target: centre, distance };
  }

  setFollow(on) {
    this.follow = on;
    this.untouched = false;
    if (!on && this.name === "robot") this.name = "free";
    if (on && this.robot) this.#flyTo({ target: this.robot.position.clone(), yaw: this.yaw, pitch: this.pitch, distance: Math.min(this.distance, 6) });
    this.#say();
  }

  /** The robot has moved to here. */
  robotAt(position, yaw) {
    const step = this.robot ? position.clone().sub(this.robot.position) : null;
    this.robot = { position: position.clone(), yaw };
    if (this.name === "robot") this.#chase(step === null);
    else if (this.follow && !step) this.setFollow(true);
    else if (this.follow) {
      for (const place of [this.target, ...this.#flight]) place.add(step);
      this.#moved(false);
    }
  }

  /** Puts the view to what an address asks for. */
  restore({ at, turn, far, view, follow }) {
    this.#stop();
    this.untouched = !at && !turn && !far && !follow && (!view || view in angles); // the map is still to come
    if (at) this.target.fromArray(at);
    if (turn) [this.yaw, this.pitch] = turn;
    if (far) this.distance = Math.max(0.3, Math.min(100_000, far)); // the map, which may be large, is not here yet
    if (follow !== null) this.follow = follow;
    if (view in views) {
      this.name = view;
      if (this.untouched) Object.assign(this, angles[view]);
      else if (!at) this.show(view);
    }
    this.#place();
  }

  #chase(fly) {
    if (!this.robot) return;
    const heading = new Vector3(Math.cos(this.robot.yaw), Math.sin(this.robot.yaw), 0);
    const goal = { target: this.robot.position.clone().addScaledVector(heading, 1.2).addScaledVector(up, 0.4), yaw: this.robot.yaw + Math.PI, pitch: 0.45, distance: 3.6 };
    if (fly) this.#flyTo(goal);
    else {
      Object.assign(this, { yaw: goal.yaw, pitch: goal.pitch });
      this.target.copy(goal.target);
      this.#moved(false);
    }
  }

  #flyTo({ target, yaw, pitch, distance }) {
    this.#stop();
    const to = target.clone();
    const from = { target: this.target.clone(), yaw: this.yaw, pitch: this.pitch, distance: this.distance };
    const turn = Math.atan2(Math.sin(yaw - from.yaw), Math.cos(yaw - from.yaw)); // the short way round
    this.#flight = [from.target, to];
    this.#stop = this.stage.animate(0.45, (share) => {
      this.target.lerpVectors(from.target, to, share);
      this.yaw = from.yaw + share * turn;
      this.pitch = from.pitch + share * (pitch - from.pitch);
      this.distance = from.distance * (distance / from.distance) ** share;
      this.#moved();
    });
  }

  /** Ends a flight where it is; one to the robot that is followed at the robot. */
  #halt() {
    this.#stop();
    if (this.follow && this.robot && this.name !== "robot") this.target.copy(this.robot.position);
  }

  #free() {
    this.#halt();
    this.untouched = false;
    if (this.name === "free") return;
    this.name = "free";
    this.#say();
  }

  #ground() {
    return { sideways: new Vector3(-Math.sin(this.yaw), Math.cos(this.yaw), 0), ahead: new Vector3(-Math.cos(this.yaw), -Math.sin(this.yaw), 0) };
  }

  #moved(quick = true) {
    this.#place();
    this.stage.invalidate(quick);
    this.dispatchEvent(new Event("moved"));
  }

  #place() {
    const { camera } = this.stage;
    const flat = Math.cos(this.pitch);
    camera.position.set(Math.cos(this.yaw) * flat, Math.sin(this.yaw) * flat, Math.sin(this.pitch)).multiplyScalar(this.distance).add(this.target);
    camera.near = Math.max(0.02, this.distance / 200);
    camera.far = Math.max(100, this.distance * 20);
    camera.lookAt(this.target);
    camera.updateProjectionMatrix();
    camera.updateMatrixWorld();
  }

  #say() {
    this.dispatchEvent(new Event("changed"));
    this.dispatchEvent(new Event("moved"));
  }
}
