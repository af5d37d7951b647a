// Pointers and wheel on the canvas: orbit, pan, zoom, pinch; a press that does not move is a click. A tool that is in
// hand (measuring, go-to) may take a press first.
import { Raycaster, Vector2 } from "three";

const slop = 6; // px that a click may move

export class Gestures {
  #pointers = new Map();
  #moved = 0;
  #pinch = null;
  #taken = false;

  /**
   * @param {{click: Function, press: Function, drag: Function, release: Function}} hand what the tool in hand does;
   *   press returns true to keep the pointer for itself
   */
  constructor(canvas, view, hand) {
    this.canvas = canvas;
    this.view = view;
    this.hand = hand;
    canvas.addEventListener("pointerdown", (event) => this.#down(event));
    canvas.addEventListener("pointermove", (event) => this.#move(event));
    for (const end of ["pointerup", "pointercancel"]) canvas.addEventListener(end, (event) => this.#up(event));
    canvas.addEventListener("wheel", (event) => this.#wheel(event), { passive: false });
    canvas.addEventListener("contextmenu", (event) => event.preventDefault());
  }

  #down(event) {
    this.canvas.setPointerCapture(event.pointerId);
    document.activeElement?.blur(); // keys are for the map again
    this.#pointers.set(event.pointerId, event);
    if (this.#pointers.size === 1) {
      this.#moved = 0;
      this.#taken = event.button === 0 && this.hand.press(event);
    } else if (this.#taken) { // two fingers move the view: the first one meant no press
      this.#taken = false;
      this.hand.release(event, true);
    }
    this.#pinch = null;
  }

  #move(event) {
    const before = this.#pointers.get(event.pointerId);
    if (!before) return;
    this.#pointers.set(event.pointerId, event);
    const [dx, dy] = [event.clientX - before.clientX, event.clientY - before.clientY];
    this.#moved += Math.abs(dx) + Math.abs(dy);
    if (this.#taken) this.hand.drag(event);
    else if (this.#pointers.size >= 2) this.#pinchBy();
    else if (this.#moved > slop) this.#dragBy(event, dx, dy);
  }

  #dragBy(event, dx, dy) {
    const height = this.canvas.clientHeight;
    if (event.buttons & 6 || event.shiftKey) this.view.pan(dx / height, dy / height);
    else this.view.orbit((-dx / height) * Math.PI * 1.4, (dy / height) * Math.PI);
  }

  #pinchBy() {
    const [a, b] = [...this.#pointers.values()];
    const now = { x: (a.clientX + b.clientX) / 2, y: (a.clientY + b.clientY) / 2, far: Math.hypot(a.clientX - b.clientX, a.clientY - b.clientY), turn: Math.atan2(b.clientY - a.clientY, b.clientX - a.clientX) };
    const last = this.#pinch;
    this.#pinch = now;
    now.begin = last?.begin ?? now;
    now.pans = last?.pans || Math.hypot(now.x - now.begin.x, now.y - now.begin.y) > slop; // which ends following: zooming does not
    if (!last || now.far < 1) return;
    const height = this.canvas.clientHeight;
    if (now.pans) this.view.pan((now.x - last.x) / height, (now.y - last.y) / height);
    this.view.zoom(last.far / now.far);
    const turn = Math.atan2(Math.sin(now.turn - last.turn), Math.cos(now.turn - last.turn));
    if (Math.abs(turn) < 0.3) this.view.orbit(turn, 0);
  }

  #up(event) {
    if (!this.#pointers.delete(event.pointerId)) return;
    this.#pinch = null;
    if (this.#pointers.size > 0) {
      this.#moved = Infinity; // fingers leave one after the other: no click
      return;
    }
    if (this.#taken) this.hand.release(event, event.type === "pointercancel");
    else if (this.#moved <= slop && event.type === "pointerup" && event.button === 0) this.hand.click(event);
    this.#taken = false;
  }

  #wheel(event) {
    event.preventDefault();
    const pixels = event.deltaMode === 1 ? event.deltaY * 18 : event.deltaY;
    const towards = pointOnPlane(rayAt(event, this.canvas, this.view.stage.camera), this.view.target.z);
    const near = towards && towards.distanceTo(this.view.target) < 3 * this.view.distance;
    this.view.zoom(Math.exp(Math.max(-200, Math.min(200, pixels)) * 0.0016), near ? towards : null);
  }
}

const caster = new Raycaster();

/** The ray that leaves the viewer through an event's pixel. */
export function rayAt(event, canvas, camera) {
  const box = canvas.getBoundingClientRect();
  const at = new Vector2(((event.clientX - box.left) / box.width) * 2 - 1, 1 - ((event.clientY - box.top) / box.height) * 2);
  caster.setFromCamera(at, camera);
  return caster.ray.clone();
}

/** Where a ray meets the level plane at height z, null where it does not. */
export function pointOnPlane(ray, z) {
  const t = (z - ray.origin.z) / ray.direction.z;
  return t > 0 && Number.isFinite(t) ? ray.origin.clone().addScaledVector(ray.direction, t) : null;
}
