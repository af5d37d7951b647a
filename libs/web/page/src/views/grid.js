// Where the robot can drive: free, in the way, unknown.
import { DataTexture, Mesh, NearestFilter, PlaneGeometry, RedFormat, ShaderMaterial } from "three";
import { bytes } from "../messages.js";

const vertexShader = `
  varying vec2 at;
  void main() {
    at = uv;
    gl_Position = projectionMatrix * modelViewMatrix * vec4(position, 1.0);
  }`;
const fragmentShader = `
  uniform sampler2D cells;
  uniform vec3 open, blocked;
  varying vec2 at;
  void main() {
    float state = floor(texture2D(cells, at).r * 255.0 + 0.5);
    if (state < 0.5) discard;
    gl_FragColor = state < 1.5 ? vec4(open, 0.22) : vec4(blocked, 0.62);
  }`;

export class GridView {
  constructor(stage, board, switches, onTheme) {
    const uniforms = { cells: { value: null }, open: { value: null }, blocked: { value: null } };
    const material = new ShaderMaterial({ vertexShader, fragmentShader, uniforms, transparent: true, depthWrite: false, side: 2 });
    const mesh = new Mesh(new PlaneGeometry(1, 1), material);
    mesh.renderOrder = -1;
    let any = false;
    const show = () => {
      mesh.visible = any && switches.is("grid");
      stage.invalidate();
    };
    stage.map.add(mesh);
    onTheme(({ truth, bad }) => {
      uniforms.open.value = truth.clone();
      uniforms.blocked.value = bad.clone();
    });
    board.on("grid", (item) => {
      any = Boolean(item) && item.header.width > 0 && item.header.height > 0;
      uniforms.cells.value?.dispose();
      if (any) this.#take(item, mesh, uniforms);
      show();
    });
    switches.on(["grid"], show);
  }

  #take(item, mesh, uniforms) {
    const { origin, cell, width, height } = item.header;
    const texture = new DataTexture(bytes(item).slice(0, width * height), width, height, RedFormat);
    texture.unpackAlignment = 1;
    texture.magFilter = texture.minFilter = NearestFilter;
    texture.needsUpdate = true;
    uniforms.cells.value = texture;
    mesh.scale.set(width * cell, height * cell, 1);
    mesh.position.set(origin[0] + (width * cell) / 2, origin[1] + (height * cell) / 2, (origin[2] ?? 0) + 0.006);
  }
}
