// Planes of the map: outlines that are filled faintly; tables and floors with their name and height.
import { BufferAttribute, BufferGeometry, Group, LineBasicMaterial, LineLoop, Mesh, MeshBasicMaterial, ShapeUtils, Vector2, Vector3 } from "three";

const names = { floor: "truth", table: "fastslam", wall: "icp", ceiling: "odometry", other: "odometry" };

export class PlanesView {
  /** @param labels views/labels.js */
  constructor(stage, board, switches, labels, onTheme) {
    Object.assign(this, { stage, switches, labels });
    this.root = new Group();
    this.planes = [];
    stage.map.add(this.root);
    onTheme((colours) => {
      this.colours = colours;
      this.#redraw();
    });
    board.on("planes", (item) => {
      this.planes = item?.header.planes ?? [];
      this.#redraw();
    });
    switches.on(["planes"], () => this.#redraw());
  }

  #redraw() {
    for (const child of [...this.root.children]) {
      this.root.remove(child);
      child.geometry.dispose();
      child.material.dispose();
    }
    this.labels.clear("plane");
    if (this.switches.is("planes")) for (const plane of this.planes) if (plane.outline.length >= 3) this.#draw(plane);
    this.stage.invalidate();
  }

  #draw({ label, outline, normal, area }) {
    const color = this.colours[names[label] ?? names.other];
    const corners = outline.map((corner) => new Vector3(...corner));
    const geometry = fill(corners, new Vector3(...normal));
    const surface = new Mesh(geometry, new MeshBasicMaterial({ color, transparent: true, opacity: 0.14, side: 2, depthWrite: false }));
    const edge = new LineLoop(new BufferGeometry().setFromPoints(corners), new LineBasicMaterial({ color, transparent: true, opacity: 0.9 }));
    surface.renderOrder = 1;
    this.root.add(surface, edge);
    if (label === "table" || label === "floor") {
      const centre = corners.reduce((sum, corner) => sum.add(corner), new Vector3()).divideScalar(corners.length);
      const height = label === "table" ? `, ${centre.z.toFixed(2)} m high` : "";
      this.labels.add("plane", centre, `${label} ${area.toFixed(1)} m²${height}`);
    }
  }

  /** @returns the plane on which a point lies, within 6 cm */
  under(place) {
    return this.planes.find(({ outline, normal }) => {
      const n = new Vector3(...normal);
      const origin = new Vector3(...outline[0]);
      if (Math.abs(place.clone().sub(origin).dot(n)) > 0.06) return false;
      const { flat } = flatten([...outline.map((corner) => new Vector3(...corner)), place], n);
      return contains(flat.slice(0, -1), flat.at(-1));
    });
  }
}

/** Corners in the plane's own two directions. */
function flatten(corners, normal) {
  const u = Math.abs(normal.z) < 0.9 ? new Vector3(0, 0, 1).cross(normal).normalize() : new Vector3(1, 0, 0).cross(normal).normalize();
  const v = normal.clone().cross(u);
  return { flat: corners.map((corner) => new Vector2(corner.dot(u), corner.dot(v))) };
}

function fill(corners, normal) {
  const { flat } = flatten(corners, normal);
  const geometry = new BufferGeometry().setFromPoints(corners);
  geometry.setIndex(new BufferAttribute(new Uint16Array(ShapeUtils.triangulateShape(flat, []).flat()), 1));
  return geometry;
}

/** Whether a polygon holds a point: a ray crosses its border an odd number of times. */
function contains(polygon, { x, y }) {
  let inside = false;
  polygon.forEach((a, i) => {
    const b = polygon[(i + 1) % polygon.length];
    if (a.y > y !== b.y > y && x < ((b.x - a.x) * (y - a.y)) / (b.y - a.y) + a.x) inside = !inside;
  });
  return inside;
}
