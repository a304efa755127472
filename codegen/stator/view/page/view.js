// The page: a client of the Foxglove WebSocket protocol, as any other.
import {decode} from './cdr.js';
import {Plot} from './plot.js';

const PROTOCOLS = ['foxglove.websocket.v1', 'foxglove.sdk.v1'];
const STATE = '/stator/state';
const STILL_S = 3;  // a topic without a sample for so long is still
const AGAIN_MS = 1000;
const by = id => document.getElementById(id);
const scene = await (await fetch('scene.json')).json();
const channels = new Map();  // topic -> channel
const subscribed = new Map();  // number of a subscription -> topic
const plots = new Map();  // topic.field -> plot
let socket, next = 1, chosen = null, newest = null, at = 0, playing = true, dragged = false;

// --- the connection ---

function connect() {
    socket = new WebSocket(`${location.protocol === 'https:' ? 'wss' : 'ws'}://${location.host}/`, PROTOCOLS);
    socket.binaryType = 'arraybuffer';
    socket.onmessage = ({data}) => typeof data === 'string' ? hear(JSON.parse(data)) : take(new DataView(data));
    socket.onclose = () => {
        by('state').textContent = 'not connected';
        document.body.classList.add('gone');
        subscribed.clear();
        setTimeout(connect, AGAIN_MS);
    };
}

function hear(message) {
    if (message.op === 'advertise') {
        for (const channel of message.channels) channels.set(channel.topic, channel);
        subscribe(STATE);
        for (const topic of wanted()) subscribe(`/${topic}`);
    } else if (message.op === 'parameterValues') {
        showParameters(message.parameters);
    } else if (message.op === 'status') {
        by('params_note').textContent = message.message;
    }
}

const ask = request => socket.readyState === WebSocket.OPEN && socket.send(JSON.stringify(request));
const wanted = () => new Set([...(chosen ? [chosen] : []), ...[...plots.keys()].map(key => key.split('.')[0])]);

function subscribe(topic) {
    if ([...subscribed.values()].includes(topic) || !channels.has(topic)) return;
    subscribed.set(next, topic);
    ask({op: 'subscribe', subscriptions: [{id: next++, channelId: channels.get(topic).id}]});
}

function follow() {
    const topics = new Set([...wanted()].map(topic => `/${topic}`));
    for (const [id, topic] of subscribed) {
        if (topic === STATE || topics.has(topic)) continue;
        subscribed.delete(id);
        ask({op: 'unsubscribe', subscriptionIds: [id]});
    }
    topics.forEach(subscribe);
}

function take(view) {
    const topic = subscribed.get(view.getUint32(1, true));
    if (!topic) return;
    const time = Number(view.getBigUint64(5, true)) / 1e9;
    if (topic === STATE) {
        showState(JSON.parse(new TextDecoder().decode(new Uint8Array(view.buffer, 13))));
        return;
    }
    const name = topic.slice(1);
    const sample = decode(scene.topics[name].fields, view, 13);
    if (name === chosen) newest = sample;
    for (const [key, plot] of plots) {
        const [of, field, i] = key.split('.');
        if (of === name) plot.add(time, Number(i === undefined ? sample[field] : sample[field][i]));
    }
}

// --- what is shown ---

function cell(row, text, kind) {
    const made = row.insertCell();
    made.textContent = text;
    if (kind) made.className = kind;
    return made;
}

const number = (value, digits = 0) => value === null || value === undefined ? '-' : value.toFixed(digits);

function button(text, action) {
    const made = document.createElement('button');
    made.type = 'button';
    made.className = 'link';
    made.textContent = text;
    made.addEventListener('click', action);
    return made;
}

function topicKind(name, state) {
    const most = scene.topics[name].max_age_s;
    if (!state) return 'still';
    if (most !== null && state.age_s > most) return 'late';
    return state.age_s > STILL_S ? 'still' : 'good';
}

function showState(state) {
    document.body.classList.remove('gone');
    at = state.time_s;
    const load = state.tasks.reduce((sum, task) => sum + (task.load_pct ?? 0), 0);
    const what = scene.log ? 'log' : `running, load ${number(load, 1)} %`;
    by('state').textContent = `${scene.board}, ${at.toFixed(1)} s, ${what}`;
    if (scene.log && !dragged) {
        by('slider').value = at;
        by('at').textContent = `${at.toFixed(2)} s`;
    }
    for (const row of by('topics').rows) {
        const found = state.topics[row.dataset.topic];
        row.cells[1].textContent = found ? number(found.rate_hz, found.rate_hz < 10 ? 1 : 0) : '-';
        row.cells[2].textContent = !found ? '-' : found.age_s < 10 ? `${(1000 * found.age_s).toFixed(0)} ms` : `${found.age_s.toFixed(0)} s`;
        row.className = topicKind(row.dataset.topic, found);
    }
    showGraph(state);
    showTasks(state.tasks);
    showChains(state.chains);
}

function showGraph(state) {
    const tasks = new Map(state.tasks.map(task => [task.task, task]));
    for (const group of document.querySelectorAll('#graph g.node')) {
        const name = group.querySelector('title').textContent, node = scene.nodes[name];
        if (!node) continue;
        const task = tasks.get(name);
        let kind = 'good';
        if (task) {
            const isLate = task.bound_us !== null && task.response_max_us > task.bound_us;
            const isLong = task.budget_us !== null && task.max_us > task.budget_us;
            kind = task.lost_samples || task.missed_life_signs || isLate ? 'bad' : isLong ? 'late' : task.per_s > 0 ? 'good' : 'still';
        } else {
            const kinds = node.outputs.map(topic => topicKind(topic, state.topics[topic]));
            if (!kinds.length) continue;  // a log does not say what it did
            kind = kinds.includes('good') ? 'good' : kinds.includes('late') ? 'late' : 'still';
        }
        group.classList.remove('good', 'late', 'bad', 'still');
        group.classList.add(kind);
        group.classList.toggle('chosen', chosen !== null && node.outputs.includes(chosen));
    }
    for (const group of document.querySelectorAll('#graph g.edge')) {
        const from = group.querySelector('title').textContent.split('->')[0];
        const kinds = (scene.nodes[from]?.outputs ?? []).map(topic => topicKind(topic, state.topics[topic]));
        group.classList.toggle('late', kinds.includes('late'));
        group.classList.toggle('still', kinds.length > 0 && kinds.every(kind => kind === 'still'));
    }
}

function showTasks(tasks) {
    by('tasks').hidden = tasks.length === 0;
    by('task_rows').replaceChildren();
    for (const task of tasks) {
        const row = by('task_rows').insertRow();
        const isLong = task.budget_us !== null && task.max_us > task.budget_us;
        const isLate = task.bound_us !== null && task.response_max_us > task.bound_us;
        cell(row, task.level);
        cell(row, task.task);
        cell(row, number(task.per_s));
        cell(row, number(task.load_pct, 1));
        cell(row, number(task.max_us, 1) + (task.budget_us === null ? '' : ` of ${task.budget_us}`), isLong ? 'bad' : '');
        cell(row, number(task.response_max_us) + (task.bound_us === null ? '' : ` of ${task.bound_us}`), isLate ? 'bad' : '');
        cell(row, task.lost_samples, task.lost_samples ? 'bad' : '');
        cell(row, task.missed_life_signs, task.missed_life_signs ? 'bad' : '');
    }
}

function showChains(chains) {
    by('chains').hidden = chains.length === 0;
    by('chain_rows').replaceChildren();
    for (const chain of chains) {
        const label = document.createElement('div'), bar = document.createElement('div'), full = document.createElement('div');
        label.textContent = `${chain.name}: ${number(chain.worst_us)} of ${chain.deadline_us} us`;
        bar.className = chain.worst_us > chain.deadline_us ? 'bar bad' : 'bar';
        full.style.width = `${Math.min(100 * (chain.worst_us ?? 0) / chain.deadline_us, 100)}%`;
        bar.append(full);
        by('chain_rows').append(label, bar);
    }
}

function choose(topic) {
    chosen = topic;
    newest = null;
    by('topic').hidden = false;
    by('topic_name').textContent = topic;
    const about = scene.topics[topic];
    by('topic_doc').textContent = `${about.message}: ${about.publishers.join(', ')} to ${about.readers.join(', ') || 'no reader'}`;
    by('fields').replaceChildren();
    for (const field of about.fields) {
        const row = by('fields').insertRow();
        row.title = field.doc;
        const name = cell(row, '');
        cell(row, '-');
        cell(row, field.unit === '1' ? '' : field.unit);
        if (field.count === null) {
            name.append(button(field.name, () => plot(topic, field.name, field.unit)));
        } else {
            name.append(`${field.name} `);
            for (let i = 0; i < Math.min(field.count, 32); ++i) name.append(button(`[${i}]`, () => plot(topic, `${field.name}.${i}`, field.unit)), ' ');
        }
    }
    follow();
}

function plot(topic, field, unit) {
    const key = `${topic}.${field}`;
    if (plots.has(key)) return;
    const label = `${topic}.${field.replace(/\.(\d+)$/, '[$1]')}${unit && unit !== '1' ? ` (${unit})` : ''}`;
    plots.set(key, new Plot(by('plots'), label, () => { plots.delete(key); follow(); }));
    for (const [id, of] of subscribed) {  // again: a log sends what was before
        if (of !== `/${topic}` || !scene.log) continue;
        subscribed.delete(id);
        ask({op: 'unsubscribe', subscriptionIds: [id]});
    }
    follow();
}

const shown = (field, value) => typeof value === 'number' ? field.values[value] ?? (Number.isInteger(value) ? String(value) : value.toPrecision(5)) : String(value);

function refresh() {
    if (newest !== null) {
        scene.topics[chosen].fields.forEach((field, i) => {
            const value = newest[field.name];
            by('fields').rows[i].cells[1].textContent = Array.isArray(value) ? value.slice(0, 12).map(one => shown(field, one)).join('  ') : shown(field, value);
        });
    }
    for (const each of plots.values()) each.draw();
}

function showParameters(values) {
    by('params').replaceChildren();
    by('params_note').textContent = `${values.length} parameters, read-only`;
    for (const {name, value} of values.sort((a, b) => a.name < b.name ? -1 : 1)) {
        const row = by('params').insertRow(), about = scene.parameters[name];
        row.title = about.doc;
        const differs = value !== about.graph_value;
        cell(row, name);
        cell(row, String(typeof value === 'number' ? Number(value.toPrecision(6)) : value), differs ? 'bad' : '');
        cell(row, about.unit === '1' ? '' : about.unit);
        cell(row, about.least === null || about.most === null ? '' : `${about.least} to ${about.most}`);
    }
}

// --- at the start ---

function drawGraph() {
    const theme = matchMedia('(prefers-color-scheme: dark)').matches ? 'dark' : 'light';
    const drawn = new DOMParser().parseFromString(scene.svg[theme], 'image/svg+xml').documentElement;
    drawn.removeAttribute('width');
    drawn.removeAttribute('height');
    by('graph').replaceChildren(document.importNode(drawn, true));
    for (const group of document.querySelectorAll('#graph g.node')) {
        const node = scene.nodes[group.querySelector('title').textContent];
        const topic = node?.outputs.find(name => scene.topics[name].is_known);
        if (!topic) continue;
        group.setAttribute('tabindex', '0');
        group.setAttribute('role', 'button');
        group.addEventListener('click', () => choose(topic));
        group.addEventListener('keydown', event => { if (event.key === 'Enter') choose(topic); });
    }
}

function seek() {
    const time = Number(by('slider').value);
    by('at').textContent = `${time.toFixed(2)} s`;
    ask({op: 'statorSeek', time, speed: playing ? Number(by('speed').value) : 0});
}

document.title = `${scene.graph} - Stator`;
by('title').textContent = scene.graph;
drawGraph();
matchMedia('(prefers-color-scheme: dark)').addEventListener('change', drawGraph);
for (const [name, about] of Object.entries(scene.topics)) {
    if (!about.is_known) continue;
    const row = by('topics').insertRow();
    row.dataset.topic = name;
    cell(row, '').append(button(name, () => choose(name)));
    cell(row, '-');
    cell(row, '-');
}
by('find').addEventListener('input', () => {
    for (const row of by('topics').rows) row.hidden = !row.dataset.topic.includes(by('find').value);
});
by('read').addEventListener('click', () => ask({op: 'getParameters', parameterNames: [], id: 'page'}));
if (scene.log) {
    by('player').hidden = false;
    by('slider').min = scene.log.begin_s;
    by('slider').max = scene.log.end_s;
    by('slider').addEventListener('input', () => { dragged = true; seek(); });
    by('slider').addEventListener('change', () => { dragged = false; });
    by('speed').addEventListener('change', () => seek());
    by('play').addEventListener('click', () => {
        playing = !playing;
        by('play').textContent = playing ? 'pause' : 'play';
        by('slider').value = at;
        seek();
    });
    by('lines').hidden = scene.log.lines.length === 0;
    for (const line of scene.log.lines) {
        const item = document.createElement('li');
        item.textContent = `${line.time_s.toFixed(2)} s ${line.level}: ${line.text}`;
        by('line_rows').append(item);
    }
}
connect();
setInterval(refresh, 100);
