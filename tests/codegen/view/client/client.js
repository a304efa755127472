// Foxglove's own client: what it sees of a view, as lines of JSON.
// node client.js ADDRESS PROTOCOL TOPIC TIME_S TIME_NS: the last is that of the sample it waits for.
import {createRequire} from 'node:module';
import {parse} from '@foxglove/rosmsg';
import {MessageReader} from '@foxglove/rosmsg2-serialization';

const {FoxgloveClient} = createRequire(import.meta.url)('@foxglove/ws-protocol');
const [address, protocol, topic, time, awaited] = process.argv.slice(2);
const socket = new WebSocket(address, [protocol]);
const client = new FoxgloveClient({ws: socket});
const print = (what, value) => console.log(JSON.stringify([what, value], (_, v) => typeof v === 'bigint' ? Number(v) : ArrayBuffer.isView(v) ? Array.from(v) : v));
const channels = new Map(), readers = new Map();

client.on('error', error => { throw error; });
client.on('serverInfo', info => print('info', {protocol: socket.protocol, name: info.name, capabilities: info.capabilities}));
client.on('advertise', found => {
    for (const channel of found) {
        channels.set(channel.topic, channel);
        if (channel.encoding === 'cdr') readers.set(channel.topic, new MessageReader(parse(channel.schema, {ros2: true})));
    }
    print('topics', [...channels.keys()]);
    client.getParameters([], 'all');
    client.subscribeConnectionGraph();
});
client.on('parameterValues', ({parameters}) => {
    print('parameters', parameters);
    client.setParameters([{name: parameters[0].name, value: 1}], 'set');
});
client.on('connectionGraphUpdate', graph => print('published', graph.publishedTopics));
client.on('status', ({level, message}) => {
    print('status', {level, message});
    socket.send(JSON.stringify({op: 'statorSeek', time: Number(time), speed: 0}));
    client.subscribe(channels.get(topic).id);
});
client.on('message', ({timestamp, data}) => {
    if (timestamp !== BigInt(awaited)) return;
    print('sample', readers.get(topic).readMessage(data));
    client.close();
});
