// Prints what @foxglove/ulog reads of a log: its information and parameters, then a line for each
// sample. 64-bit numbers as text, since JSON's numbers hold 53 bits.
import { MessageType, ULog } from "@foxglove/ulog";
import { FileReader } from "@foxglove/ulog/node.js";

const plain = (key, value) => {
    if (typeof value === "bigint") return value.toString();
    if (typeof value === "number" && !Number.isFinite(value)) return String(value);
    return ArrayBuffer.isView(value) ? Array.from(value) : value;
};
const log = new ULog(new FileReader(process.argv[2]));
await log.open();
const header = log.header;
const map = (of) => Object.fromEntries([...of].map(([key, value]) => [key, value?.value ?? value]));
console.log(JSON.stringify({
    information: map(header.information),
    parameters: map(header.parameters),
}, plain));
const lines = [];
for await (const message of log.readMessages()) {
    if (message.type !== MessageType.Data) continue;
    lines.push(JSON.stringify([log.subscriptions.get(message.msgId).name, message.value], plain));
}
console.log(lines.join("\n"));
