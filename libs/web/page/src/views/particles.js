// The filter's particles: where they stand, larger the more they weigh.
import { BufferGeometry, InterleavedBuffer, InterleavedBufferAttribute, Points, ShaderMaterial } from "three";
import { floats } from "../messages.js";

const vertexShader = `
  attribute float weight;
  uniform float scale, heaviest;
  void main() {
    vec4 p = modelViewMatrix * vec4(position, 1.0);
    gl_Position = projectionMatrix * p;
    gl_PointSize = clamp((0.01 + 0.03 * sqrt(weight / heaviest)) * scale / -p.z, 2.0, 18.0);
  }`;
const fragmentShader = `
  uniform vec3 colour;
  void main() {
    vec2 q = 2.0 * gl_PointCoord - 1.0;
    if (dot(q, q) > 1.0) discard;
    gl_FragColor = vec4(colour, 0.75);
  }`;

export class ParticlesView {
  constructor(stage, board, switches, onTheme) {
    const uniforms = { scale: { value: 1 }, heaviest: { value: 1 }, colour: { value: null } };
    this.points = new Points(new BufferGeometry(), new ShaderMaterial({ vertexShader, fragmentShader, uniforms, transparent: true, depthTest: false }));
    this.points.frustumCulled = false;
    this.points.renderOrder = 5;
    this.points.visible = false;
    stage.front.add(this.points);
    onTheme(({ fastslam }) => (uniforms.colour.value = fastslam.clone()));
    let any = false;
    const show = () => {
      this.points.visible = any && switches.is("particles");
      stage.refresh();
    };
    board.on("particles", (item) => {
      const values = item ? floats(item) : new Float32Array();
      any = values.length >= 4;
      if (any) this.#take(values, uniforms);
      show();
    });
    switches.on(["particles"], show);
    stage.beforeFrame(() => {
      uniforms.scale.value = (stage.size.y / 2) * stage.camera.projectionMatrix.elements[5];
    });
  }

  #take(values, uniforms) {
    const buffer = new InterleavedBuffer(values, 4);
    this.points.geometry.dispose();
    this.points.geometry = new BufferGeometry();
    this.points.geometry.setAttribute("position", new InterleavedBufferAttribute(buffer, 3, 0));
    this.points.geometry.setAttribute("weight", new InterleavedBufferAttribute(buffer, 1, 3));
    let heaviest = 1e-9;
    for (let i = 3; i < values.length; i += 4) heaviest = Math.max(heaviest, values[i]);
    uniforms.heaviest.value = heaviest;
  }
}
