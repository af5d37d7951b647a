// read_export.js FILE.mcap: what viewers do with our export: the index by @mcap/core, messages by the schemas in the file,
// which must be ROS 2's own (@foxglove/rosmsg-msgs-common). Prints what it found as JSON. NODE_PATH leads to the packages.
"use strict";
const { decompressHandlers, load, openFile } = require("./mcap_tools.js");

async function main(file) {
  const { core, rosmsg, rosmsg2, common } = load();
  const readable = await openFile(file);
  const reader = await core.McapIndexedReader.Initialize({ readable, decompressHandlers: await decompressHandlers() });
  const readers = new Map();
  for (const channel of reader.channelsById.values()) {
    const schema = reader.schemasById.get(channel.schemaId);
    if (schema.encoding !== "ros2msg" || channel.messageEncoding !== "cdr")
      throw new Error(`${channel.topic}: ${schema.encoding}, ${channel.messageEncoding}`);
    const definitions = rosmsg.parse(new TextDecoder().decode(schema.data), { ros2: true });
    definitions[0].name ??= schema.name.replace("/msg/", "/");
    check(definitions, common.ros2humble, rosmsg);
    readers.set(channel.id, new rosmsg2.MessageReader(definitions));
  }
  const topics = {};
  let last = 0n;
  for await (const message of reader.readMessages()) {
    if (message.logTime < last) throw new Error("messages are out of order");
    last = message.logTime;
    const channel = reader.channelsById.get(message.channelId);
    const value = readers.get(message.channelId).readMessage(message.data);
    const of = (topics[channel.topic] ??= { type: reader.schemasById.get(channel.schemaId).name, count: 0 });
    of.count += 1;
    of.last = summary(value);
  }
  const expected = Number(reader.statistics.messageCount);
  const read = Object.values(topics).reduce((sum, topic) => sum + topic.count, 0);
  if (read !== expected) throw new Error(`${read} messages by the index, ${expected} by the statistics`);
  await streamed(file, expected);
  console.log(JSON.stringify({ topics, chunks: reader.chunkIndexes.length, compression: reader.chunkIndexes[0].compression }));
}

// The types and members are those that ROS defines, but for constants and default values, which viewers do not need.
function check(definitions, official, rosmsg) {
  for (const { name, definitions: written } of definitions) {
    const ours = rosmsg.stringify([{ name, definitions: written }]);
    const theirs = official[name.replace("/msg/", "/")];
    const members = theirs.definitions.filter((member) => member.isConstant !== true);
    const plain = { name, definitions: members.map((member) => ({ ...member, defaultValue: undefined })) };
    if (ours.replaceAll("/msg/", "/") !== rosmsg.stringify([plain]).replaceAll("/msg/", "/"))
      throw new Error(`${name} is not ROS's:\n${ours}\n--\n${rosmsg.stringify([plain])}`);
  }
}

// From the front, with every CRC checked.
async function streamed(file, expected) {
  const { core, fs } = load();
  const reader = new core.McapStreamReader({ validateCrcs: true, decompressHandlers: await decompressHandlers() });
  reader.append(fs.readFileSync(file));
  let messages = 0;
  for (let record; (record = reader.nextRecord()) !== undefined; ) messages += record.type === "Message" ? 1 : 0;
  if (!reader.done() || messages !== expected) throw new Error(`${messages} messages from the front, ${expected} there`);
}

// Numbers and texts as they are, of arrays the length.
function summary(value) {
  if (ArrayBuffer.isView(value)) return { length: value.length, first: Number(value[0]) };
  if (Array.isArray(value)) return value.map(summary);
  if (value === null || typeof value !== "object") return typeof value === "bigint" ? Number(value) : value;
  return Object.fromEntries(Object.entries(value).map(([name, member]) => [name, summary(member)]));
}

main(process.argv[2]).catch((error) => {
  console.error(error.message);
  process.exit(1);
});
