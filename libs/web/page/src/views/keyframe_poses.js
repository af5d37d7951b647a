// Where each keyframe's camera is. What hangs on a keyframe hangs on its group, so that a new graph bends all of it.
import { Group, Quaternion, Vector3 } from "three";

const bendTime = 0.3; // s

export class KeyframePoses {
  #groups = new Map();
  #known = new Set(); // by the graph, which corrects what points say
  #stop = () => {};

  constructor(stage) {
    this.stage = stage;
    this.root = new Group();
    stage.map.add(this.root);
  }

  /** The group of a keyframe; `T` places it as long as no graph has. */
  group(keyframe, T) {
    let group = this.#groups.get(keyframe);
    if (!group) {
      group = new Group();
      this.#groups.set(keyframe, group);
      this.root.add(group);
      if (T) place(group, T);
    } else if (T && !this.#known.has(keyframe)) place(group, T);
    return group;
  }

  /** Moves keyframes to where the graph says they are now. */
  correct(nodes) {
    this.#stop();
    const moves = [];
    for (const { keyframe, T } of nodes) {
      const isNew = !this.#known.has(keyframe);
      const group = this.group(keyframe);
      const [position, turn] = [new Vector3(T[0], T[1], T[2]), new Quaternion(T[4], T[5], T[6], T[3])];
      this.#known.add(keyframe);
      if (isNew && group.children.length === 0) place(group, T);
      else if (group.position.distanceTo(position) > 1e-4 || group.quaternion.angleTo(turn) > 1e-4)
        moves.push({ group, position, turn, from: group.position.clone(), turned: group.quaternion.clone() });
    }
    if (moves.length === 0) return;
    this.#stop = this.stage.animate(bendTime, (share) => {
      for (const { group, position, turn, from, turned } of moves) {
        group.position.lerpVectors(from, position, share);
        group.quaternion.slerpQuaternions(turned, turn, share);
        group.updateMatrixWorld();
      }
      this.moved?.();
    });
  }

  clear() {
    this.#stop();
    this.#known.clear();
    for (const [keyframe, group] of this.#groups)
      if (group.children.length === 0) {
        this.root.remove(group);
        this.#groups.delete(keyframe);
      }
  }
}

function place(group, [x, y, z, qw, qx, qy, qz]) {
  group.position.set(x, y, z);
  group.quaternion.set(qx, qy, qz, qw);
  group.updateMatrixWorld();
}
