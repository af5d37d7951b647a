// The canvas: draws when something has changed, and says how long frames take.
import { ColorManagement, LinearSRGBColorSpace, PerspectiveCamera, Scene, Vector2, WebGLRenderer } from "three";
import { MapCache } from "./map_cache.js";
import { onTheme } from "./theme.js";

const still = 0.3; // s without a frame or a move after which everything is drawn
const slow = { moving: 1 / 28, standing: 0.1 }; // s that a frame may wait for the one before
const swift = 1 / 45;
const least = 0.004;

/** Whether motion is to be avoided. */
export function calm() {
  return matchMedia("(prefers-reduced-motion: reduce)").matches;
}

export class Stage {
  #asked = false;
  #movedAt = -1;
  #tweens = new Set();
  #before = [];
  #settle = 0;
  #askedAt = 0;
  #coarse = false;
  #isMapOld = true;
  #wasMapDrawn = false;
  #wholeTime = 0; // s that all of the map took

  constructor(canvas) {
    this.canvas = canvas;
    this.software = usesSoftware();
    // Smooth edges cost most where no graphics card draws.
    this.renderer = new WebGLRenderer({ canvas, antialias: !this.software, powerPreference: "high-performance" });
    this.renderer.autoClear = false;
    // Nothing is lit: colours stay as they are written.
    ColorManagement.enabled = false;
    this.renderer.outputColorSpace = LinearSRGBColorSpace;
    /** What changes seldom, and what moves in front of it: robot, particles, paths. */
    this.map = new Scene();
    this.front = new Scene();
    this.cache = new MapCache(this.renderer, this.software ? 0 : 4);
    this.camera = new PerspectiveCamera(50, 1, 0.05, 400);
    this.camera.up.set(0, 0, 1);
    this.size = new Vector2();
    this.inset = { top: 0, right: 0, bottom: 0, left: 0 };
    /** 1: everything is drawn; less while frames take too long. */
    this.ease = 1;
    this.afterFrame = () => {};
    this.frames = 0;
    this.frameTime = 0;
    onTheme(({ scene }) => {
      this.renderer.setClearColor(scene);
      this.invalidate();
    });
    canvas.addEventListener("webglcontextrestored", () => this.invalidate());
    new ResizeObserver(() => this.#resize()).observe(canvas.parentElement);
    this.#resize();
    document.addEventListener("visibilitychange", () => this.invalidate());
  }

  /** Called before each frame. */
  beforeFrame(step) {
    this.#before.push(step);
  }

  /** Draw all of it soon. `moved`: the view moves, so that speed counts more than detail. */
  invalidate(moved = false) {
    if (moved) this.#movedAt = performance.now();
    this.#isMapOld = true;
    this.refresh();
  }

  /** Draw soon; the map is as it was. */
  refresh() {
    if (this.#asked) return;
    this.#asked = true;
    this.#askedAt = performance.now();
    requestAnimationFrame((now) => this.#frame(now));
  }

  /** Calls step(0..1), eased, until `duration` s are over; at once where motion is to be avoided. `inFront`: not the map. */
  animate(duration, step, inFront = false) {
    const show = () => (inFront ? this.refresh() : this.invalidate());
    show();
    if (calm() || document.hidden) {
      step(1);
      return () => {};
    }
    const tween = { begin: performance.now(), duration: duration * 1000, step, show };
    this.#tweens.add(tween);
    return () => this.#tweens.delete(tween);
  }

  #frame(now) {
    this.#asked = false;
    this.#judge();
    for (const tween of this.#tweens) {
      const share = Math.min(1, Math.max(0, (now - tween.begin) / tween.duration));
      tween.step(share * share * (3 - 2 * share));
      if (share >= 1) this.#tweens.delete(tween);
      tween.show();
    }
    for (const step of this.#before) step();
    this.#wasMapDrawn = this.#isMapOld;
    this.draw();
    this.afterFrame();
    this.frames += 1;
  }

  /** Draws now: all of it, or what moves over the picture of the map. */
  draw() {
    this.renderer.clear();
    if (this.#isMapOld) {
      this.renderer.render(this.map, this.camera);
      this.cache.forget();
      clearTimeout(this.#settle);
      const patience = Math.max(still, 3 * this.#wholeTime);
      if (this.ease < 1) this.#settle = setTimeout(() => this.#finish(), patience * 1000);
    } else this.cache.draw(this.map, this.camera, this.size);
    this.renderer.render(this.front, this.camera);
    this.#isMapOld = false;
  }

  /** How long a frame waits for the one before tells how long that took: less is drawn then, later more again. */
  #judge() {
    const waited = (performance.now() - this.#askedAt) / 1000;
    if (this.#wasMapDrawn) this.frameTime = 0.5 * this.frameTime + 0.5 * Math.min(waited, 1);
    if (this.#wasMapDrawn && this.ease === 1) this.#wholeTime = waited;
    if (!this.#isMapOld) return;
    const limit = performance.now() - this.#movedAt < still * 1000 ? slow.moving : slow.standing;
    if (this.frameTime > limit) this.#setEase(Math.max(least, this.ease * Math.max(0.25, (0.9 * limit) / this.frameTime)));
    else if (this.frameTime < swift) this.#setEase(Math.min(1, this.ease * 1.1));
  }

  /** The map has stood for a while: all of it is drawn. */
  #finish() {
    if (this.#isMapOld) return; // a slow frame is still to come
    this.#setEase(1);
    this.frameTime = 0;
    this.invalidate();
  }

  /** Software draws, and cannot keep up. */
  get isCoarse() {
    return this.#coarse;
  }

  #setEase(ease) {
    const coarse = this.software && ease < (this.#coarse ? 0.4 : 0.1);
    this.ease = ease;
    if (coarse !== this.#coarse) this.#setPixels(coarse ? 0.6 : 1);
    this.#coarse = coarse;
  }

  #setPixels(share) {
    this.renderer.setPixelRatio(Math.min(devicePixelRatio, 2) * share);
    this.renderer.getDrawingBufferSize(this.size);
  }

  /** Pixels of the page that panels cover: the middle of the picture is the middle of what is left. */
  setInset({ top = 0, right = 0, bottom = 0, left = 0 }) {
    this.inset = { top, right, bottom, left };
    this.#centre();
  }

  #centre() {
    const { clientWidth, clientHeight } = this.canvas.parentElement;
    const { top, right, bottom, left } = this.inset;
    this.camera.setViewOffset(clientWidth, clientHeight, (right - left) / 2, (bottom - top) / 2, clientWidth, clientHeight);
    this.invalidate();
  }

  #resize() {
    const { clientWidth, clientHeight } = this.canvas.parentElement;
    if (clientWidth === 0 || clientHeight === 0) return;
    this.renderer.setPixelRatio(Math.min(devicePixelRatio, 2));
    this.renderer.setSize(clientWidth, clientHeight, false);
    this.renderer.getDrawingBufferSize(this.size);
    this.camera.aspect = clientWidth / clientHeight;
    this.#centre();
  }
}

/** Whether the browser draws without a graphics card. */
function usesSoftware() {
  const gl = document.createElement("canvas").getContext("webgl2");
  if (!gl) throw new Error("This browser cannot draw the map: it has no WebGL 2, or may not use it.");
  const names = gl.getExtension("WEBGL_debug_renderer_info");
  const name = gl.getParameter(names ? names.UNMASKED_RENDERER_WEBGL : gl.RENDERER);
  gl.getExtension("WEBGL_lose_context")?.loseContext();
  return /swiftshader|llvmpipe|software|basic render/i.test(name);
}
