// Lines 1 m apart on the ground, and the axes of the map's frame.
import { BufferAttribute, BufferGeometry, Group, LineBasicMaterial, LineSegments } from "three";

const reach = 12; // m
const below = -0.03; // m: a floor of the map hides the lines

export class GroundView {
  constructor(stage, switches, onTheme) {
    const root = new Group();
    stage.map.add(root);
    const lines = [];
    for (let i = -reach; i <= reach; ++i) lines.push(i, -reach, below, i, reach, below, -reach, i, below, reach, i, below);
    const grid = segments(lines);
    grid.material.opacity = 0.55;
    const axes = segments([0, 0, 0.003, 0.5, 0, 0.003, 0, 0, 0.003, 0, 0.25, 0.003]);
    axes.material.opacity = 0.4;
    root.add(grid, axes);
    onTheme(({ line, ink }) => {
      grid.material.color.copy(line);
      axes.material.color.copy(ink);
    });
    switches.on(["ground"], () => {
      root.visible = switches.is("ground");
      stage.invalidate();
    });
    this.root = root;
  }
}

function segments(positions) {
  const geometry = new BufferGeometry();
  geometry.setAttribute("position", new BufferAttribute(new Float32Array(positions), 3));
  const object = new LineSegments(geometry, new LineBasicMaterial({ transparent: true, depthWrite: false }));
  object.renderOrder = -2;
  return object;
}
