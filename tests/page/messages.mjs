// Messages of docs/LIVE_PAGE.md as the server writes them.

/** One message: header length, header padded so that the payload begins at a multiple of 4, payload. */
export function encode(header, payload = Buffer.alloc(0)) {
  let text = Buffer.from(JSON.stringify(header));
  text = Buffer.concat([text, Buffer.alloc((4 - (text.length % 4)) % 4, " ")]);
  const length = Buffer.alloc(4);
  length.writeUInt32LE(text.length);
  return Buffer.concat([length, text, payload]);
}

/** A message as it comes when it is long. */
export function inParts(message, most = 20_000) {
  if (message.length <= most) return [message];
  const parts = [];
  for (let at = 0; at < message.length; at += most)
    parts.push(encode({ channel: "part", key: "bulk", at, of: message.length }, message.subarray(at, at + most)));
  return parts;
}

export function floats(values) {
  return Buffer.from(new Float32Array(values).buffer);
}

/** A file's messages one after the other, each with its length before it, in base64. */
export function carried(messages) {
  return Buffer.concat(messages.flatMap((message) => {
    const length = Buffer.alloc(4);
    length.writeUInt32LE(message.length);
    return [length, message];
  })).toString("base64");
}

/** Numbers from 0 to 1 that are the same at each run (mulberry32). */
export function randomNumbers(seed) {
  let state = seed;
  return () => {
    state = (state + 0x6d2b79f5) | 0;
    let t = Math.imul(state ^ (state >>> 15), 1 | state);
    t = (t + Math.imul(t ^ (t >>> 7), 61 | t)) ^ t;
    return ((t ^ (t >>> 14)) >>> 0) / 4294967296;
  };
}
