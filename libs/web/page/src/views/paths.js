// The ways of the robot: by 6-D SLAM, by FastSLAM, by odometry, in truth. Told apart by colour and by dash.
import { BufferGeometry, Float32BufferAttribute, Group, Line, LineBasicMaterial, LineDashedMaterial, Vector3 } from "three";
import { Line2 } from "three/examples/jsm/lines/Line2.js";
import { LineGeometry } from "three/examples/jsm/lines/LineGeometry.js";
import { LineMaterial } from "three/examples/jsm/lines/LineMaterial.js";
import { floats } from "../messages.js";

/** Dash and gap in m; null: a whole line. */
export const styles = {
  icp: { label: "6-D SLAM", width: 2.5, dash: null },
  fastslam: { label: "FastSLAM", width: 2.5, dash: [0.14, 0.07] },
  odometry: { label: "Odometry", width: 2, dash: [0.03, 0.05] },
  truth: { label: "Truth", width: 2, dash: null },
};

export class PathsView {
  #pieces = new Map();
  #kinds = {};

  constructor(stage, board, switches, onTheme) {
    this.stage = stage;
    for (const [name, { width, dash }] of Object.entries(styles)) this.#kinds[name] = this.#kind(width, dash);
    onTheme((colours) => {
      for (const [name, { materials }] of Object.entries(this.#kinds)) for (const material of Object.values(materials)) material.color.copy(colours[name]);
    });
    board.on("path", (item, key) => this.#take(item, key));
    switches.on(Object.keys(styles), () => {
      for (const [name, { root }] of Object.entries(this.#kinds)) root.visible = switches.is(name);
      stage.refresh();
    });
  }

  /** Plainly where it is in sight, faintly where something stands before it; thin while software cannot keep up: wide lines
   *  are what it does worst. */
  #kind(width, dash) {
    const root = new Group();
    const [wide, thin] = [new Group(), new Group()];
    this.stage.front.add(root.add(wide, thin));
    const dashes = dash ? { dashSize: dash[0], gapSize: dash[1] } : {};
    const dashed = dash ? { dashed: true, ...dashes } : {};
    const look = { transparent: true, depthWrite: false };
    const materials = {
      plain: new LineMaterial({ linewidth: width, ...look, ...dashed }),
      faint: new LineMaterial({ linewidth: width, ...look, ...dashed, opacity: 0.22, depthTest: false }),
      thin: dash ? new LineDashedMaterial({ ...look, ...dashes }) : new LineBasicMaterial(look),
    };
    this.stage.beforeFrame(() => {
      thin.visible = this.stage.isCoarse;
      wide.visible = !thin.visible;
    });
    return { root, wide, thin, materials };
  }

  #take(item, key) {
    const [name, number] = [key.slice(0, key.indexOf("/")), Number(key.slice(key.indexOf("/") + 1))];
    const kind = this.#kinds[name];
    if (!kind) return;
    this.#drop(key);
    if (item) {
      this.#pieces.set(key, { values: floats(item), lines: [] });
      this.#draw(kind, name, number);
      if (this.#pieces.has(`${name}/${number + 1}`)) this.#draw(kind, name, number + 1);
    }
    this.stage.refresh();
  }

  #drop(key) {
    const piece = this.#pieces.get(key);
    if (!piece) return;
    this.#erase(piece);
    this.#pieces.delete(key);
  }

  #erase(piece) {
    for (const line of piece.lines) {
      line.removeFromParent();
      line.geometry.dispose();
    }
    piece.lines = [];
  }

  /** A piece begins where the one before ends. */
  #draw(kind, name, number) {
    const piece = this.#pieces.get(`${name}/${number}`);
    this.#erase(piece);
    const before = this.#pieces.get(`${name}/${number - 1}`)?.values;
    const positions = [...(before ? before.slice(-3) : []), ...piece.values];
    if (positions.length < 6) return;
    const { wide, thin, materials } = kind;
    const geometry = new LineGeometry();
    geometry.setPositions(positions);
    piece.lines = [new Line2(geometry, materials.faint), new Line2(geometry, materials.plain)];
    wide.add(...piece.lines);
    const narrow = new Line(new BufferGeometry().setAttribute("position", new Float32BufferAttribute(positions, 3)), materials.thin);
    thin.add(narrow);
    piece.lines.push(narrow);
    if (materials.thin.isLineDashedMaterial) for (const line of piece.lines) line.computeLineDistances();
  }

  /** Where the pieces of what is shown begin and end. */
  centres() {
    const shown = [...this.#pieces].filter(([key, { values }]) => values.length >= 3 && this.#kinds[key.slice(0, key.indexOf("/"))].root.visible);
    return shown.flatMap(([, { values }]) => [0, values.length - 3].map((at) => new Vector3().fromArray(values, at)));
  }
}
