// write_mcap.js IN.mcap OUT.mcap ros1|ros2 zstd|lz4|none: the recording of IN once more by @mcap/core, its messages put
// together anew by Foxglove's serializers, on the topics of a driver. NODE_PATH leads to the packages.
"use strict";
const { compressor, decompressHandlers, load, openFile } = require("./mcap_tools.js");

const topics = {
  "/camera/colour/image/compressed": "/head/color/image_raw/compressed",
  "/camera/colour/camera_info": "/head/color/camera_info",
  "/camera/depth/image": "/head/depth/image_raw",
  "/camera/depth/camera_info": "/head/depth/camera_info",
  "/odometry": "/base/odom",
  "/ground_truth": "/ground_truth",
  "/tf_static": "/tf_static",
};

// Members as ROS 1 names and counts them.
function toRos1(value) {
  if (ArrayBuffer.isView(value)) return value;
  if (Array.isArray(value)) return value.map(toRos1);
  if (value === null || typeof value !== "object") return value;
  const result = {};
  for (const [name, member] of Object.entries(value)) result[name] = toRos1(member);
  for (const name of ["d", "k", "r", "p"]) if (name in result && "distortion_model" in result) result[name.toUpperCase()] = result[name];
  if ("nanosec" in result) return { sec: result.sec, nsec: result.nanosec };
  if ("frame_id" in result && "stamp" in result) result.seq = 0;
  return result;
}

function definitionsOf(type, official) {
  const found = new Map();
  const visit = (name) => {
    if (found.has(name)) return;
    found.set(name, official[name]);
    for (const member of official[name].definitions) if (member.isComplex) visit(member.type.replace("/msg/", "/"));
  };
  visit(type);
  return [...found.values()];
}

async function main(input, output, version, compression) {
  const { core, rosmsg, rosmsg1, rosmsg2, common, fs } = load();
  const reader = await core.McapIndexedReader.Initialize({
    readable: await openFile(input),
    decompressHandlers: await decompressHandlers(),
  });
  const handle = fs.openSync(output, "w");
  let position = 0n;
  const writable = {
    position: () => position,
    write: async (bytes) => { fs.writeSync(handle, bytes); position += BigInt(bytes.length); },
  };
  const writer = new core.McapWriter({ writable, chunkSize: 200_000, compressChunk: await compressor(compression) });
  await writer.start({ profile: version, library: "tests/ros" });
  const isRos1 = version === "ros1";
  const official = isRos1 ? common.ros1 : common.ros2humble;
  const channels = new Map();
  for (const channel of reader.channelsById.values()) {
    if (!(channel.topic in topics)) continue;
    const schema = reader.schemasById.get(channel.schemaId);
    const parsed = rosmsg.parse(new TextDecoder().decode(schema.data), { ros2: true });
    const type = schema.name.replace("/msg/", "/");
    const definitions = definitionsOf(type, official);
    const schemaId = await writer.registerSchema({
      name: isRos1 ? type : schema.name,
      encoding: isRos1 ? "ros1msg" : "ros2msg",
      data: new TextEncoder().encode(rosmsg.stringify(definitions)),
    });
    channels.set(channel.id, {
      id: await writer.registerChannel({ schemaId, topic: topics[channel.topic], messageEncoding: isRos1 ? "ros1" : "cdr", metadata: new Map() }),
      reader: new rosmsg2.MessageReader(parsed),
      writer: isRos1 ? new rosmsg1.MessageWriter(definitions) : new rosmsg2.MessageWriter(definitions),
    });
  }
  for await (const message of reader.readMessages()) {
    const channel = channels.get(message.channelId);
    if (channel === undefined) continue;
    const value = channel.reader.readMessage(message.data);
    const data = channel.writer.writeMessage(isRos1 ? toRos1(value) : value);
    await writer.addMessage({ channelId: channel.id, sequence: 0, logTime: message.logTime, publishTime: message.publishTime, data });
  }
  await writer.end();
  fs.closeSync(handle);
}

main(...process.argv.slice(2)).catch((error) => {
  console.error(error.stack);
  process.exit(1);
});
