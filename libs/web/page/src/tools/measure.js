// Two clicks: the distance between them, along the ground and in height.
import { length } from "../format.js";
import { Mark } from "./marks.js";

export class Measure {
  constructor({ stage, picker, labels, card }) {
    Object.assign(this, { picker, labels, card });
    this.mark = new Mark(stage);
    this.from = null;
  }

  enter() {
    this.card.show("Measure", [["First point", "press a place of the map"]], () => this.done());
  }

  click(event) {
    const hit = this.picker.at(event);
    if (!hit) return;
    if (!this.from) {
      this.#clear();
      this.from = hit.place;
      this.labels.add("measure", hit.place, "A");
      this.card.show("Measure", [["Second point", "press another place"]], () => this.done());
      return;
    }
    const [a, b] = [this.from, hit.place];
    this.from = null;
    this.mark.draw([a, b]);
    this.labels.add("measure", b, `B  ${length(a.distanceTo(b))}`);
    this.card.show("Measure", [
      ["Distance", length(a.distanceTo(b))],
      ["Along the ground", length(Math.hypot(b.x - a.x, b.y - a.y))],
      ["In height", length(b.z - a.z)],
    ], () => this.done());
  }

  leave() {
    this.#clear();
    this.from = null;
    this.card.hide();
  }

  #clear() {
    this.mark.hide();
    this.labels.clear("measure");
  }
}
