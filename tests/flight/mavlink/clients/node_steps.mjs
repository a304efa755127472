// node-mavlink, which shares no code with the other clients. Argument: the port.
import assert from 'node:assert/strict'
import dgram from 'node:dgram'
import { PassThrough } from 'node:stream'
import mavlink from 'node-mavlink'

const { common, minimal, standard } = mavlink
// Releases differ in which of these a message is.
const types = { ...common, ...minimal, ...standard }
const registry = { ...minimal.REGISTRY, ...standard?.REGISTRY, ...common.REGISTRY }
const HANGS_MS = 600000

const socket = dgram.createSocket('udp4')
const stream = new PassThrough()
const splitter = new mavlink.MavLinkPacketSplitter({}, { onCrcError: () => damaged++ })
const protocol = new mavlink.MavLinkProtocolV2(249, 190)
const waiting = new Set()
let damaged = 0
let sequence = 0
let vehicle

socket.on('message', (bytes, sender) => {
    vehicle = sender
    stream.write(bytes)
})
stream.pipe(splitter).pipe(new mavlink.MavLinkPacketParser()).on('data', (packet) => {
    const type = registry[packet.header.msgid]
    if (type === undefined) return
    const message = packet.protocol.data(packet.payload, type)
    for (const one of waiting) {
        if (one.type !== type || !one.wanted(message)) continue
        waiting.delete(one)
        one.found(message)
    }
})
setTimeout(() => {
    console.error('missing:', [...waiting].map((one) => one.type.MSG_NAME))
    process.exit(1)
}, HANGS_MS).unref()

function next(type, wanted = () => true) {
    return new Promise((found) => waiting.add({ type, wanted, found }))
}

function send(type, fields) {
    const message = Object.assign(new type(), fields)
    const bytes = protocol.serialize(message, sequence++ & 255)
    socket.send(bytes, vehicle.port, vehicle.address)
}

// Sends to the vehicle, and waits for the answer.
function ask(type, fields, answer, wanted) {
    const answered = next(answer, wanted)
    send(type, { targetSystem: 1, targetComponent: 1, ...fields })
    return answered
}

async function knowsIt() {
    const told = next(types.AutopilotVersion)
    const fields = { command: 512, _param1: 148 }
    const ack = await ask(types.CommandLong, fields, types.CommandAck, (a) => a.command === 512)
    assert.equal(ack.result, 0)
    assert.notEqual((await told).capabilities & 0x2000n, 0n)  // MAVLink 2
}

async function listsParameters() {
    const values = new Map()
    let count = 1
    const all = new Promise((done) => {
        const type = types.ParamValue
        const take = (value) => {
            if (value.paramIndex === 65535) return false  // the hash of all
            values.set(value.paramId, value.paramIndex)
            count = value.paramCount
            return values.size === count
        }
        waiting.add({ type, wanted: take, found: done })
    })
    send(types.ParamRequestList, { targetSystem: 1, targetComponent: 1 })
    await all
    assert.deepEqual([...values.values()].sort((a, b) => a - b), [...values.keys()].map((_, i) => i))
}

async function keepsAMission() {
    const latitudes = [473977420, 473978320, 473979220]
    const count = latitudes.length
    const { MissionRequestInt, MissionAck, MissionItemInt } = types
    let asked = ask(types.MissionCount, { count }, MissionRequestInt)
    let ack
    for (const [seq, x] of latitudes.entries()) {
        assert.equal((await asked).seq, seq)
        const isLast = seq === count - 1
        const item = {
            seq, x, y: 85455940, z: 6, frame: 3, command: isLast ? 21 : 16,
            current: seq === 0 ? 1 : 0, autocontinue: 1, param4: NaN
        }
        const answer = ask(MissionItemInt, item, isLast ? MissionAck : MissionRequestInt)
        if (isLast) ack = answer
        else asked = answer
    }
    assert.equal((await ack).type, 0)
    const back = await ask(types.MissionRequestList, {}, types.MissionCount)
    assert.equal(back.count, count)
    for (const [seq, x] of latitudes.entries()) {
        const item = await ask(MissionRequestInt, { seq }, MissionItemInt, (i) => i.seq === seq)
        assert.equal(item.x, x)
    }
    assert.equal((await ask(types.MissionClearAll, {}, MissionAck)).type, 0)
}

async function agreesOnTime() {
    const ts1 = process.hrtime.bigint()
    const time = { tc1: 0n, ts1, targetSystem: 0, targetComponent: 0 }
    const answer = await ask(types.TimeSync, time, types.TimeSync, (t) => t.ts1 === ts1)
    assert(answer.tc1 > 0n)
}

socket.bind(Number(process.argv[2]), '127.0.0.1')
const beat = await next(types.Heartbeat)
assert.equal(beat.mavlinkVersion, 3)
for (const step of [knowsIt, listsParameters, keepsAMission, agreesOnTime]) {
    console.log(step.name)
    await step()
}
assert.equal(damaged, 0)
process.exit(0)
