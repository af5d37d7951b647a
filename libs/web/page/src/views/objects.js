// What stands on floors and tables: boxes.
import { BoxGeometry, EdgesGeometry, Group, LineBasicMaterial, LineSegments, Vector3 } from "three";

export class ObjectsView {
  constructor(stage, board, switches, labels, onTheme) {
    this.root = new Group();
    stage.map.add(this.root);
    const material = new LineBasicMaterial({ transparent: true, opacity: 0.95 });
    const edges = new EdgesGeometry(new BoxGeometry(1, 1, 1));
    let objects = [];
    onTheme(({ loop }) => material.color.copy(loop));
    const redraw = () => {
      this.root.clear();
      labels.clear("object");
      for (const { centre, quaternion: [w, x, y, z], size, on } of switches.is("objects") ? objects : []) {
        const box = new LineSegments(edges, material);
        box.position.fromArray(centre);
        box.quaternion.set(x, y, z, w);
        box.scale.fromArray(size.map((side) => Math.max(side, 0.005)));
        this.root.add(box);
        if ([...size].sort((a, b) => a - b)[1] < 0.04) continue; // a sliver: no name
        const sides = size.map((side) => Math.round(side * 100)).join(" × ");
        labels.add("object", new Vector3(...centre).add(new Vector3(0, 0, size[2] / 2)), `${sides} cm${on ? `, on ${on}` : ""}`);
      }
      stage.invalidate();
    };
    board.on("objects", (item) => {
      objects = item?.header.objects ?? [];
      redraw();
    });
    switches.on(["objects"], redraw);
  }
}
