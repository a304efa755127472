// Prints what @mcap/core and @foxglove/rosmsg2-serialization read of a file: its profile and the
// schemas, then a line for each message. 64-bit numbers as text, since JSON's numbers hold 53 bits.
import { parse } from "@foxglove/rosmsg";
import { MessageReader } from "@foxglove/rosmsg2-serialization";
import { McapIndexedReader } from "@mcap/core";
import { FileHandleReadable } from "@mcap/nodejs";
import { open } from "node:fs/promises";
import { decompress } from "fzstd";

const plain = (key, value) => {
    if (typeof value === "bigint") return value.toString();
    if (typeof value === "number" && !Number.isFinite(value)) return String(value);
    return ArrayBuffer.isView(value) ? Array.from(value) : value;
};
const mcap = await McapIndexedReader.Initialize({
    readable: new FileHandleReadable(await open(process.argv[2])),
    decompressHandlers: { zstd: (bytes) => decompress(bytes) },
});
const readers = new Map();
const schemas = {};
for (const [id, channel] of mcap.channelsById) {
    const schema = mcap.schemasById.get(channel.schemaId);
    const text = new TextDecoder().decode(schema.data);
    readers.set(id, new MessageReader(parse(text, { ros2: true })));
    schemas[channel.topic] = schema.name;
}
const lines = [JSON.stringify({ profile: mcap.header.profile, schemas })];
for await (const message of mcap.readMessages()) {
    const sample = readers.get(message.channelId).readMessage(message.data);
    const topic = mcap.channelsById.get(message.channelId).topic;
    lines.push(JSON.stringify([topic, message.logTime, sample], plain));
}
console.log(lines.join("\n"));
