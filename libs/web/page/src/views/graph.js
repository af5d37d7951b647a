// Keyframes as small cameras, and the edges between them: loops strongly, and more so as they close.
import { BufferAttribute, BufferGeometry, Group, LineBasicMaterial, LineSegments, Vector3 } from "three";
import { graphArrays } from "../messages.js";

const loopKind = 2;
const depth = 0.08; // m of a keyframe's pyramid
const corners = [[-0.06, -0.045], [0.06, -0.045], [0.06, 0.045], [-0.06, 0.045]].map(([x, y]) => new Vector3(x, y, depth));

export class GraphView {
  #nodes = [];
  #edges = { plain: [], loops: [], fresh: [] };
  #known = null; // loops that were there before
  #stop = () => {};

  constructor(stage, board, switches, poses, onTheme) {
    Object.assign(this, { stage, poses });
    this.root = new Group();
    stage.map.add(this.root);
    this.lines = {
      cameras: lines({ opacity: 0.7 }, 2),
      plain: lines({ opacity: 0.25 }, 1),
      loops: lines({ opacity: 0.65, depthTest: false }, 4),
      fresh: lines({ opacity: 1, depthTest: false }, 4),
    };
    this.root.add(...Object.values(this.lines));
    onTheme(({ icp, loop, ink }) => {
      this.lines.cameras.material.color.copy(icp);
      this.lines.plain.material.color.copy(ink);
      for (const name of ["loops", "fresh"]) this.lines[name].material.color.copy(loop);
    });
    poses.moved = () => this.#redraw();
    board.on("graph", (item) => this.#take(item));
    switches.on(["keyframes"], () => {
      this.root.visible = switches.is("keyframes");
      stage.invalidate();
    });
  }

  get keyframes() {
    return this.#nodes.length;
  }

  get loops() {
    return this.#edges.loops.length + this.#edges.fresh.length;
  }

  #take(item) {
    const { nodes, edges } = item ? graphArrays(item) : { nodes: [], edges: [] };
    if (!item) this.poses.clear();
    this.#nodes = nodes;
    const name = ({ from, to }) => `${from} ${to}`;
    const loops = edges.filter(({ kind }) => kind === loopKind);
    const isFresh = (edge) => this.#known !== null && !this.#known.has(name(edge));
    this.#edges = {
      plain: edges.filter(({ kind }) => kind !== loopKind),
      loops: loops.filter((edge) => !isFresh(edge)),
      fresh: loops.filter(isFresh),
    };
    this.#known = item ? new Set(loops.map(name)) : null;
    if (this.#edges.fresh.length > 0) this.#fadeIn();
    this.poses.correct(nodes);
    this.#redraw();
    this.stage.invalidate();
  }

  #fadeIn() {
    this.#stop();
    this.#stop = this.stage.animate(0.8, (share) => (this.lines.fresh.material.opacity = 1 - 0.35 * share * share));
  }

  #redraw() {
    const positions = [];
    for (const { keyframe } of this.#nodes) {
      const matrix = this.poses.group(keyframe).matrixWorld;
      const apex = new Vector3().setFromMatrixPosition(matrix);
      const rim = corners.map((corner) => corner.clone().applyMatrix4(matrix));
      rim.forEach((corner, i) => positions.push(...apex, ...corner, ...corner, ...rim[(i + 1) % 4]));
    }
    setPositions(this.lines.cameras, positions);
    for (const name of ["plain", "loops", "fresh"]) {
      const ends = this.#edges[name].flatMap(({ from, to }) => [from, to].flatMap((id) => this.poses.group(id).position.toArray()));
      setPositions(this.lines[name], ends);
    }
  }
}

function lines(look, order) {
  const object = new LineSegments(new BufferGeometry(), new LineBasicMaterial({ transparent: true, depthWrite: false, ...look }));
  object.frustumCulled = false;
  object.renderOrder = order;
  return object;
}

function setPositions(object, positions) {
  object.geometry.dispose();
  object.geometry = new BufferGeometry();
  object.geometry.setAttribute("position", new BufferAttribute(new Float32Array(positions), 3));
}
