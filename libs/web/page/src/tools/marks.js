// Lines that tools draw over the map.
import { Line2 } from "three/examples/jsm/lines/Line2.js";
import { LineGeometry } from "three/examples/jsm/lines/LineGeometry.js";
import { LineMaterial } from "three/examples/jsm/lines/LineMaterial.js";
import { onTheme } from "../theme.js";

export class Mark {
  constructor(stage) {
    this.stage = stage;
    this.line = new Line2(new LineGeometry(), new LineMaterial({ linewidth: 3, depthTest: false, transparent: true }));
    this.line.visible = false;
    this.line.renderOrder = 10;
    this.line.frustumCulled = false;
    stage.front.add(this.line);
    onTheme(({ accent }) => this.line.material.color.copy(accent));
  }

  /** @param {Vector3[]} places what the line joins */
  draw(places) {
    this.line.geometry.dispose();
    this.line.geometry = new LineGeometry();
    this.line.geometry.setPositions(places.flatMap((place) => place.toArray()));
    this.line.visible = true;
    this.stage.refresh();
  }

  hide() {
    this.line.visible = false;
    this.stage.refresh();
  }
}
