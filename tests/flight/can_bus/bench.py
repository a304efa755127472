"""Plays the motor controllers and the receiver of a flight on a CAN bus of the kernel, with the
package dronecan, and what goes wrong there. Run by test_on_bus.py inside tests/with-can.

    bench.py PROGRAM LOG TRUTH SPEED SECONDS FAULT...

The vehicle's bus is vcan0. Behind vcan1 are the simulated motors and antenna, as the wires and the
sky would be: what the controllers want of their motors goes there, and what these do comes back. A
fault is NAME@SECONDS, in the vehicle's time since it was armed. Prints what happened as JSON.
"""

from __future__ import annotations

import fcntl
import json
import math
import select
import socket
import struct
import subprocess
import sys
import time
from dataclasses import dataclass
from typing import Any

from dronecan import uavcan
from dronecan.node import Node
from tests.drivers.can.peers import (
    BUS,
    BUS_OFF,
    RESTARTED,
    Driver,
    Filter,
    frames_of,
    raw_socket,
    send,
)

PLANT = "vcan1"
MOTORS = 4
FIRST_CONTROLLER, RECEIVER, STRANGER, RELAY = 20, 40, 99, 126
RAW_COMMAND, ESC_STATUS, ARMING = 1030, 1034, 1100
SIOCSIFFLAGS, IFF_UP = 0x8914, 1  # of linux/sockios.h, net/if.h
TICK_S = 0.1  # of the vehicle's time, between two messages that say whether it is armed
BUS_FRAMES_PER_S = 7700  # of 8 bytes and a long identifier, at 1 Mbit/s


def set_flags(bus: socket.socket, flags: int) -> None:
    """As `ip link set vcan0 up` does, but at once."""
    fcntl.ioctl(bus, SIOCSIFFLAGS, struct.pack("=16sh14x", BUS.encode(), flags))


def message(kind: int) -> Filter:
    """Of this type, from anybody."""
    return socket.CAN_EFF_FLAG | kind << 8, socket.CAN_EFF_FLAG | 0xFFFF80


def requests_to(node: int) -> Filter:
    return socket.CAN_EFF_FLAG | node << 8 | 0x80, socket.CAN_EFF_FLAG | 0x7F80


def make_node(node: int, name: str, filters: list[Filter], speed: float) -> Any:
    info = uavcan.protocol.GetNodeInfo.Response(name=name)
    return Node(
        Driver(BUS, filters), node, 1.0 / speed, uavcan.protocol.NodeStatus().MODE_OPERATIONAL, info
    )


class Controller:
    """One motor's: takes its part of each command, and reports at 20 Hz."""

    def __init__(self, index: int, bench: Bench) -> None:
        self.index = index
        self.bench = bench
        self.commands = 0
        self.reports = 0
        self.disordered = 0
        self.newest_id: int | None = None
        self.is_silent = False
        self.is_dead = False
        node = FIRST_CONTROLLER + index
        filters = [message(RAW_COMMAND), requests_to(node)]
        self.node = make_node(node, f"test.esc_{index}", filters, bench.speed)
        self.node.add_handler(uavcan.equipment.esc.RawCommand, self.obey)
        self.node.periodic(0.05 / bench.speed, self.report)

    def obey(self, event: Any) -> None:
        self.commands += 1
        number = event.transfer.transfer_id
        if self.newest_id is not None and number != (self.newest_id + 1) % 32:
            self.disordered += 1
        self.newest_id = number
        self.bench.turn(self.index, 0 if self.is_dead else event.message.cmd[self.index])

    def report(self) -> None:
        if self.is_silent or self.is_dead:
            return
        self.reports += 1
        motor = self.bench.measured[self.index]
        self.node.broadcast(
            uavcan.equipment.esc.Status(
                voltage=motor.voltage,
                current=motor.current,
                temperature=310.0 if self.index else math.nan,  # which it does not measure
                rpm=motor.rpm,
                power_rating_pct=motor.power_rating_pct,
                esc_index=self.index,
            )
        )


@dataclass
class Babbler:
    """Fills the bus: most urgent frames of a node, and broken ones of a controller."""

    bus: socket.socket
    speed: float
    node: int = 0
    until: float = 0.0
    sent: int = 0
    due: float = 0.0
    last: float = 0.0
    malformed: int = 0

    def begin(self, seconds: float, node: int) -> None:
        self.node = node
        self.last = time.monotonic()
        self.until = self.last + seconds / self.speed
        self.due = 0.0

    def serve(self) -> None:
        if self.until == 0.0:
            return
        now = time.monotonic()
        if now >= self.until:
            self.until = 0.0
            return
        self.due += (now - self.last) * self.speed * BUS_FRAMES_PER_S
        self.last = now
        most = min(int(self.due), 64)  # as the bench has more to do
        self.due = min(self.due - most, 64.0)
        for _ in range(most):
            send(self.bus, socket.CAN_EFF_FLAG | ESC_STATUS << 8 | self.node, bytes(8))
            self.sent += 1
            if self.sent % 100 == 0:
                self.send_malformed()

    def send_malformed(self) -> None:
        """In turn: a checksum that is wrong, a toggle bit that does not change, a middle without a
        beginning, nothing at all, and a sound one that speaks for another controller's motor."""
        kind = self.malformed % 5
        index = 2 if kind == 4 else 1
        status = uavcan.equipment.esc.Status(voltage=99.0, rpm=-1, esc_index=index)
        frames = frames_of(status, FIRST_CONTROLLER + 1, self.malformed % 32, 16)
        if kind == 0:
            identifier, data = frames[0]
            frames[0] = identifier, bytes([data[0] ^ 1]) + data[1:]
        elif kind == 1:
            identifier, data = frames[1]
            frames[1] = identifier, data[:-1] + bytes([data[-1] ^ 0x20])
        elif kind == 2:
            frames = frames[1:2]
        elif kind == 3:
            frames = [(frames[0][0], b"")]
        for identifier, data in frames:
            send(self.bus, identifier, data)
        self.malformed += 1


class Bench:
    def __init__(self, speed: float) -> None:
        self.speed = speed
        self.measured = [uavcan.equipment.esc.Status() for _ in range(MOTORS)]
        self.wanted = [0] * MOTORS
        self.is_told = False
        self.relay = Node(Driver(PLANT), RELAY)
        self.relay.add_handler(uavcan.equipment.esc.Status, self.measure)
        self.relay.add_handler(uavcan.equipment.gnss.Fix2, self.forward)
        self.relay.add_handler(uavcan.equipment.gnss.Auxiliary, self.forward)
        self.controllers = [Controller(index, self) for index in range(MOTORS)]
        self.receiver = make_node(
            RECEIVER, "test.gnss", [requests_to(RECEIVER), message(ARMING)], speed
        )
        self.receiver.add_handler(uavcan.equipment.safety.ArmingStatus, self.tick)
        nodes = [self.relay, self.receiver, *(c.node for c in self.controllers)]
        self.nodes = {node.can_driver.bus: node for node in nodes}
        self.bus = raw_socket(filters=[])
        self.babbler = Babbler(raw_socket(filters=[]), speed)
        self.armed_ticks = 0
        self.fixes = 0
        self.later: list[tuple[float, Any]] = []

    # --- between the two buses ---

    def turn(self, motor: int, command: int) -> None:
        self.wanted[motor] = command
        self.is_told = True

    def give(self) -> None:
        """One frame for all motors, when all controllers had their turn."""
        if self.is_told:
            self.relay.broadcast(uavcan.equipment.esc.RawCommand(cmd=self.wanted), priority=4)
        self.is_told = False

    def measure(self, event: Any) -> None:
        self.measured[event.message.esc_index] = event.message

    def forward(self, event: Any) -> None:
        self.fixes += 1
        self.receiver.broadcast(event.message)

    # --- time ---

    def tick(self, event: Any) -> None:
        armed = uavcan.equipment.safety.ArmingStatus().STATUS_FULLY_ARMED
        if event.message.status == armed:
            self.armed_ticks += 1

    @property
    def armed_s(self) -> float:
        return TICK_S * self.armed_ticks

    def after(self, seconds: float, action: Any) -> None:
        self.later.append((time.monotonic() + seconds / self.speed, action))

    def serve(self) -> None:
        for _ in range(10):
            ready, _, _ = select.select(self.nodes, [], [], 0.005)
            for bus in ready:
                self.nodes[bus].spin(0)
            self.give()
            self.babbler.serve()
        for node in self.nodes.values():
            node.spin(0)
        now = time.monotonic()
        for row in [row for row in self.later if row[0] <= now]:
            self.later.remove(row)
            row[1]()

    # --- what goes wrong ---

    def silence(self) -> None:
        """Its motor turns, but nothing is heard of it."""
        self.controllers[2].is_silent = True

    def die(self) -> None:
        """Its motor stops, too."""
        self.controllers[2].is_dead = True

    def babble(self) -> None:
        self.babbler.begin(1.0, STRANGER)

    def babble_of_controller(self) -> None:
        self.babbler.begin(2.0, FIRST_CONTROLLER + 1)

    def bus_off(self) -> None:
        send(self.bus, socket.CAN_ERR_FLAG | BUS_OFF, bytes(8))
        self.after(0.1, lambda: send(self.bus, socket.CAN_ERR_FLAG | RESTARTED, bytes(8)))

    def down(self) -> None:
        set_flags(self.bus, 0)
        self.after(0.05, lambda: set_flags(self.bus, IFF_UP))


def main(program: str, log: str, truth: str, speed: str, seconds: str, *faults: str) -> None:
    bench = Bench(float(speed))
    waiting = [(float(when), name) for name, when in (fault.split("@") for fault in faults)]
    command = [program, "--can", BUS, "--can-parts", PLANT, "--speed", speed]
    command += ["--nonvolatile", log + ".records"]  # as `run` does: no arming without records
    with subprocess.Popen(
        [*command, "--log", log, "--truth", truth, "--duration", seconds],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    ) as process:
        while process.poll() is None:
            bench.serve()
            for row in [row for row in waiting if row[0] <= bench.armed_s]:
                waiting.remove(row)
                getattr(bench, row[1])()
        output, errors = process.communicate()
    print(
        json.dumps(
            {
                "returncode": process.returncode,
                "stdout": output,
                "stderr": errors,
                "commands": [c.commands for c in bench.controllers],
                "disordered": [c.disordered for c in bench.controllers],
                "reports": [c.reports for c in bench.controllers],
                "fixes": bench.fixes,
                "babbled": bench.babbler.sent,
                "malformed": bench.babbler.malformed,
                "not_done": [name for _, name in waiting],
                "bench_cpu_s": time.process_time(),
            }
        )
    )


if __name__ == "__main__":
    main(*sys.argv[1:])
