// A click on the map: position, clearance, headroom, plane.
import { Vector3 } from "three";
import { length, point } from "../format.js";
import { clearance, columnAbove, headroom } from "./headroom.js";

export class Inspect {
  /** @param {{picker, labels, planes, card, command, robot: () => object, can: (what: string) => boolean}} parts */
  constructor(parts) {
    Object.assign(this, parts);
    this.turn = 0;
  }

  async click(event) {
    const hit = this.picker.at(event);
    this.labels.clear("pin");
    if (!hit) return this.card.hide();
    this.labels.add("pin", hit.place, "");
    const rows = [["Position", point(hit.place.toArray())], ...this.#near(hit)];
    const title = hit.what === "surface" ? "Point" : hit.what[0].toUpperCase() + hit.what.slice(1);
    this.card.show(title, rows, () => this.leave());
    if (!this.can("query")) return;
    const turn = ++this.turn;
    try {
      const answers = await this.#ask(hit.place);
      if (turn === this.turn) this.card.show(title, [...rows, ...answers], () => this.leave());
    } catch (error) {
      if (turn === this.turn) this.card.show(title, [...rows, ["Clearance", error.message]], () => this.leave());
    }
  }

  leave() {
    this.turn += 1;
    this.labels.clear("pin");
    this.card.hide();
  }

  /** What the page knows itself. */
  #near({ place, sigma, observations }) {
    const rows = [];
    const robot = this.robot();
    if (robot) rows.push(["From the robot", length(place.distanceTo(robot.position))]);
    if (sigma !== undefined) rows.push(["Sigma", length(sigma)], ["Observations", observations === 255 ? "255 or more" : String(observations)]);
    const plane = this.planes.under(place);
    if (plane) rows.push(["Plane", `${plane.label}, ${plane.area.toFixed(2)} m²`]);
    return rows;
  }

  /** Clearance is asked where a robot's middle would be: right on a surface it is always 0. */
  async #ask(place) {
    const half = this.robotHeight() / 2;
    const middle = place.clone().add(new Vector3(0, 0, half)).toArray();
    const [distance, space] = await Promise.all([
      this.command.ask({ ask: "distance", points: [middle] }),
      this.command.ask({ ask: "space", points: [middle, ...columnAbove(place)] }),
    ]);
    const [state, ...above] = space.states;
    return [
      [`Clearance, ${half.toFixed(2)} m above`, clearance(distance.distances[0], distance.truncation, state)],
      ["Free above", headroom(above)],
    ];
  }
}
