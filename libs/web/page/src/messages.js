// The bytes of docs/LIVE_PAGE.md. Typed arrays look into the message's own buffer: nothing is copied.

const text = new TextDecoder();

/**
 * One message: header length (u32), header (JSON padded with spaces), payload.
 * @param {ArrayBuffer} buffer
 * @returns {{channel: string, key: string, header: object, buffer: ArrayBuffer, at: number}} `at`: where the payload begins
 */
export function decode(buffer) {
  if (buffer.byteLength < 4) throw new Error(`a message of ${buffer.byteLength} bytes, must be 4 at least`);
  const length = new DataView(buffer).getUint32(0, true);
  if (4 + length > buffer.byteLength)
    throw new Error(`a header of ${length} bytes in a message of ${buffer.byteLength}`);
  const header = JSON.parse(text.decode(new Uint8Array(buffer, 4, length)));
  return { channel: header.channel, key: header.key ?? "", header, buffer, at: 4 + length };
}

/** Puts messages together that come in parts. What else comes in between goes its way. */
export class Parts {
  #begun = new Map(); // by stream

  /** @returns the message itself, the whole one with its last part, or null before that. */
  join(item) {
    if (item.channel !== "part") return item;
    const { at, of } = item.header;
    const part = bytes(item);
    if (at === 0) this.#begun.set(item.key, { whole: new Uint8Array(of), end: 0 });
    const begun = this.#begun.get(item.key);
    if (begun?.end !== at || at + part.length > begun.whole.length)
      throw new Error(`a part from ${at} to ${at + part.length} of ${of} bytes, must go on from ${begun?.end ?? 0}`);
    begun.whole.set(part, at);
    begun.end += part.length;
    if (begun.end < begun.whole.length) return null;
    this.#begun.delete(item.key);
    return decode(begun.whole.buffer);
  }
}

/** @returns {Float32Array} `n` numbers, all that follow when it is left out */
export function floats(item, n = (item.buffer.byteLength - item.at) >> 2) {
  return new Float32Array(item.buffer, item.at, n);
}

/** @returns {Uint8Array} the whole payload */
export function bytes(item) {
  return new Uint8Array(item.buffer, item.at);
}

/** points: positions (i16 x 3, units of the header, camera frame) and colours (u8 x 3). */
export function pointArrays(item) {
  const n = item.header.n;
  return {
    positions: new Int16Array(item.buffer, item.at, 3 * n),
    colours: new Uint8Array(item.buffer, item.at + 6 * n, 3 * n),
  };
}

/** mesh: packed positions, octahedral normals, colours, triangles. */
export function meshArrays(item) {
  const { n_vertices: n, n_triangles: triangles } = item.header;
  const normals = item.at + 4 * n;
  const colours = normals + 2 * n;
  const wide = n > 65536;
  const size = wide ? 4 : 2;
  const indices = item.at + Math.ceil((9 * n) / size) * size;
  return {
    packed: new Uint32Array(item.buffer, item.at, n),
    normals: new Int8Array(item.buffer, normals, 2 * n),
    colours: new Uint8Array(item.buffer, colours, 3 * n),
    triangles: new (wide ? Uint32Array : Uint16Array)(item.buffer, indices, 3 * triangles),
  };
}

/** Bytes of one landmark: mean, covariance, id, colour, observations. */
export const landmarkBytes = 44;

/** graph: nodes {keyframe, T} and edges {from, to, kind, error}. */
export function graphArrays(item) {
  const view = new DataView(item.buffer, item.at);
  const { n_nodes: n, n_edges: m } = item.header;
  const nodes = Array.from({ length: n }, (_, i) => ({
    keyframe: view.getInt32(32 * i, true),
    T: Array.from({ length: 7 }, (_, k) => view.getFloat32(32 * i + 4 + 4 * k, true)),
  }));
  const begin = 32 * n;
  const edges = Array.from({ length: m }, (_, i) => ({
    from: view.getInt32(begin + 16 * i, true),
    to: view.getInt32(begin + 16 * i + 4, true),
    kind: view.getInt32(begin + 16 * i + 8, true),
    error: view.getFloat32(begin + 16 * i + 12, true),
  }));
  return { nodes, edges };
}

/** The messages of a file that was written by `export --html`: a length (u32) before each. */
export function* splitItems(data) {
  const view = new DataView(data.buffer, data.byteOffset, data.byteLength);
  for (let at = 0; at < data.byteLength; ) {
    const length = at + 4 <= data.byteLength ? view.getUint32(at, true) : Infinity;
    if (at + 4 + length > data.byteLength) throw new Error(`the page's data is cut off at byte ${at}`);
    yield data.buffer.slice(data.byteOffset + at + 4, data.byteOffset + at + 4 + length);
    at += 4 + length;
  }
}
