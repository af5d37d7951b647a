// The map as it was drawn last, with its depth: while nothing of it changes and nobody moves the view, what moves in front of
// it is drawn over this picture. A robot that drives through a large map then costs what a robot costs.
import { AlwaysDepth, DepthTexture, Mesh, NearestFilter, OrthographicCamera, PlaneGeometry, Scene, ShaderMaterial, UnsignedIntType, WebGLRenderTarget } from "three";

const vertexShader = `
  varying vec2 at;
  void main() {
    at = uv;
    gl_Position = vec4(position.xy, 0.0, 1.0);
  }`;
const fragmentShader = `
  uniform sampler2D colour, depth;
  varying vec2 at;
  void main() {
    gl_FragColor = vec4(texture2D(colour, at).rgb, 1.0);
    gl_FragDepth = texture2D(depth, at).r;
  }`;

export class MapCache {
  #target = null;
  #isFilled = false;

  constructor(renderer, samples) {
    Object.assign(this, { renderer, samples });
    this.camera = new OrthographicCamera();
    const uniforms = { colour: { value: null }, depth: { value: null } };
    this.material = new ShaderMaterial({ vertexShader, fragmentShader, uniforms, depthFunc: AlwaysDepth });
    this.quad = new Scene();
    const plane = new Mesh(new PlaneGeometry(2, 2), this.material);
    plane.frustumCulled = false;
    this.quad.add(plane);
  }

  /** The map has changed. */
  forget() {
    this.#isFilled = false;
  }

  /** Draws the map into the cleared canvas; into the picture first where that is old. */
  draw(map, camera, { x: width, y: height }) {
    this.#fit(width, height);
    if (!this.#isFilled) {
      this.renderer.setRenderTarget(this.#target);
      this.renderer.clear();
      this.renderer.render(map, camera);
      this.renderer.setRenderTarget(null);
      this.#isFilled = true;
    }
    this.renderer.render(this.quad, this.camera);
  }

  #fit(width, height) {
    if (this.#target?.width === width && this.#target?.height === height) return;
    this.#target?.depthTexture.dispose();
    this.#target?.dispose();
    const depthTexture = new DepthTexture(width, height, UnsignedIntType);
    this.#target = new WebGLRenderTarget(width, height, { depthTexture, samples: this.samples, minFilter: NearestFilter, magFilter: NearestFilter });
    this.material.uniforms.colour.value = this.#target.texture;
    this.material.uniforms.depth.value = depthTexture;
    this.#isFilled = false;
  }
}
