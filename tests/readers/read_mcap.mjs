// SPDX-License-Identifier: BSD-3-Clause
// Usage: node read_mcap.mjs NODE_MODULES FILE. Reads an MCAP file twice, by its index and as a stream with all checksums,
// and prints what it finds as JSON lines: first one about the file, then one a message, in the order of the log time.
import { createRequire } from "node:module";
import { open, readFile } from "node:fs/promises";
import path from "node:path";

const [modules, file] = process.argv.slice(2);
const require = createRequire(path.join(path.resolve(modules), "package.json"));
const { McapIndexedReader, McapStreamReader } = require("@mcap/core");
const { parse } = require("@foxglove/rosmsg");
const { MessageReader } = require("@foxglove/rosmsg2-serialization");
const fzstd = require("fzstd");

const decompressHandlers = { zstd: (buffer, size) => fzstd.decompress(buffer, new Uint8Array(Number(size))) };
const plain = (key, value) => {
  if (typeof value === "bigint") return value.toString();
  if (value instanceof Uint8Array) return Buffer.from(value).toString("base64");
  if (ArrayBuffer.isView(value)) return Array.from(value);
  return value;
};
const print = (value) => process.stdout.write(JSON.stringify(value, plain) + "\n");

// As a stream: every checksum is verified.
const stream = new McapStreamReader({ includeChunks: true, decompressHandlers, validateCrcs: true });
const bytes = await readFile(file);
stream.append(bytes);
const records = {};
for (let record; (record = stream.nextRecord()); ) {
  records[record.type] = (records[record.type] ?? 0) + 1;
}

// By its index.
const handle = await open(file);
const reader = await McapIndexedReader.Initialize({
  readable: {
    size: async () => BigInt((await handle.stat()).size),
    read: async (offset, length) => {
      const buffer = new Uint8Array(Number(length));
      await handle.read(buffer, 0, buffer.length, Number(offset));
      return buffer;
    },
  },
  decompressHandlers,
});
const channels = [...reader.channelsById.values()].map((channel) => ({
  topic: channel.topic,
  encoding: channel.messageEncoding,
  qos: channel.metadata.get("offered_qos_profiles"),
  schema: reader.schemasById.get(channel.schemaId).name,
  schemaEncoding: reader.schemasById.get(channel.schemaId).encoding,
}));
const { messageCount, channelMessageCounts, messageStartTime, messageEndTime, chunkCount } = reader.statistics;
print({
  header: reader.header,
  complete: stream.done(),
  records,
  channels,
  chunks: reader.chunkIndexes.map(({ compression, messageStartTime, messageEndTime }) => ({
    compression, messageStartTime, messageEndTime })),
  statistics: { messageCount, messageStartTime, messageEndTime, chunkCount,
    counts: Object.fromEntries([...channelMessageCounts].map(([id, n]) => [reader.channelsById.get(id).topic, n])) },
  summaryOffsets: [...reader.summaryOffsetsByOpcode.keys()],
});
const decoders = new Map();
for await (const message of reader.readMessages()) {
  const channel = reader.channelsById.get(message.channelId);
  const schema = reader.schemasById.get(channel.schemaId);
  if (!decoders.has(schema.id)) {
    decoders.set(schema.id, new MessageReader(parse(new TextDecoder().decode(schema.data), { ros2: true })));
  }
  print({ topic: channel.topic, type: schema.name, logTime: message.logTime, sequence: message.sequence,
    message: decoders.get(schema.id).readMessage(message.data) });
}
await handle.close();
