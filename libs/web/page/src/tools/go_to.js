// Press where the robot is to go, drag where it is to look, let go: it is said to whoever drives it.
import { Vector3 } from "three";
import { angle } from "../format.js";
import { Mark } from "./marks.js";

const least = 12; // px of a drag that means a heading

export class GoTo {
  constructor({ stage, picker, card, command, robot, notify }) {
    Object.assign(this, { picker, card, command, robot, notify });
    this.mark = new Mark(stage);
    this.goal = null;
  }

  enter() {
    this.card.show("Go to", [["Where", "press the place, drag to where it is to look"]], () => this.done());
  }

  press(event) {
    const hit = this.picker.ground(event, this.robot()?.position.z ?? 0);
    if (!hit) return false;
    const robot = this.robot();
    const yaw = robot ? Math.atan2(hit.place.y - robot.position.y, hit.place.x - robot.position.x) : 0;
    this.goal = { place: hit.place, yaw, begin: [event.clientX, event.clientY] };
    this.#draw();
    return true;
  }

  drag(event) {
    if (!this.goal) return; // laid down and taken again meanwhile
    if (Math.hypot(event.clientX - this.goal.begin[0], event.clientY - this.goal.begin[1]) < least) return;
    const hit = this.picker.ground(event, this.goal.place.z);
    if (!hit) return;
    this.goal.yaw = Math.atan2(hit.place.y - this.goal.place.y, hit.place.x - this.goal.place.x);
    this.#draw();
  }

  async release(event, cancelled) {
    if (!this.goal) return;
    const { place, yaw } = this.goal;
    this.goal = null;
    if (cancelled) return this.mark.hide();
    const where = `${place.x.toFixed(2)}, ${place.y.toFixed(2)} m, ${angle(yaw)}`;
    this.card.show("Go to", [["Goal", where]], () => this.done());
    try {
      const { words } = await this.command.do("go_to", { x: place.x, y: place.y, yaw });
      this.notify("good", words || `The goal was sent: ${where}`);
    } catch (error) {
      this.notify("bad", `The goal was not taken: ${error.message}`);
    }
  }

  leave() {
    this.goal = null;
    this.mark.hide();
    this.card.hide();
  }

  #draw() {
    const { place, yaw } = this.goal;
    const at = (along, across) => new Vector3(place.x + along * Math.cos(yaw) - across * Math.sin(yaw), place.y + along * Math.sin(yaw) + across * Math.cos(yaw), place.z + 0.02);
    this.mark.draw([at(-0.25, 0), at(0.45, 0), at(0.28, 0.12), at(0.45, 0), at(0.28, -0.12)]);
  }
}
