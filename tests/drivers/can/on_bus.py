"""Tests on a CAN bus of a real kernel. Run by test_on_bus.py inside tests/with-can, where time is
slow and uneven: what counts is function, order and number, never when.

The program under test is named by STATOR_LINK; its graph is graphs/link.yaml.
"""

from __future__ import annotations

import contextlib
import json
import math
import os
import signal
import socket
import subprocess
import threading
import time
from itertools import pairwise
from pathlib import Path
from typing import TYPE_CHECKING, Any

import can
import dronecan
import pytest
from dronecan import uavcan
from dronecan.app.node_monitor import NodeMonitor
from dronecan.node import Node
from dronecan.transport import Transfer
from pyulog import ULog
from tests.drivers.can.peers import (
    BUS,
    BUS_OFF,
    PATIENCE_S,
    RESTARTED,
    Driver,
    NeverCame,
    Part,
    next_frame,
    raw_socket,
    send,
)

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

PROGRAM = os.environ["STATOR_LINK"]
OUR_ID = 10
TOOL = 127
RESTART = 3  # the program's status: boards/linux/main.cpp
RAW_COMMAND = 0x0404060A  # priority 4, type 1030, from node 10
NODE_STATUS = 0x1001550A  # priority 16, type 341


class Link:
    """The program, on the bus until `stop`."""

    def __init__(self, log: Path, records: Path) -> None:
        self.log = log
        options = ["--nonvolatile", str(records)]
        command = [PROGRAM, "--can", BUS, "--log", str(log)]
        self.process = subprocess.Popen(
            [*command, "--duration", "1000", *options],
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
        )

    def stop(self) -> ULog:
        time.sleep(1)  # for the newest samples to reach the log
        self.process.send_signal(signal.SIGINT)
        _, errors = self.process.communicate(timeout=PATIENCE_S)
        assert self.process.returncode == 128 + signal.SIGINT, errors
        return ULog(str(self.log))


@pytest.fixture
def start(tmp_path: Path) -> Iterator[Callable[[], Link]]:
    """Starts the program, as often as it is called; all have one memory for records."""
    links: list[Link] = []

    def start() -> Link:
        links.append(Link(tmp_path / f"link-{len(links)}.ulg", tmp_path / "records"))
        return links[-1]

    yield start
    for link in links:
        if link.process.poll() is None:
            link.process.kill()
            link.process.communicate()


@pytest.fixture
def link(start: Callable[[], Link]) -> Link:
    return start()


def wait_for_us(bus: socket.socket) -> None:
    next_frame(bus, lambda identifier: identifier == RAW_COMMAND)


def newest(log: ULog, topic: str) -> dict[str, Any]:
    return {key: values[-1] for key, values in log.get_dataset(topic).data.items()}


@pytest.fixture
def peer() -> Iterator[Any]:
    node = Node(Driver(), node_id=TOOL)
    node.mode = uavcan.protocol.NodeStatus().MODE_OPERATIONAL
    yield node
    node.close()


def spin_until(node: Any, condition: Callable[[], bool]) -> None:
    end = time.monotonic() + PATIENCE_S
    while not condition():
        assert time.monotonic() < end, "it never happened"
        node.spin(0.05)


def ask(node: Any, request: Any) -> Any:
    """The response of our node. A request that is lost is repeated, as tools do."""
    for _ in range(10):
        answers: list[Any] = []
        node.request(request, OUR_ID, answers.append)
        spin_until(node, lambda answers=answers: bool(answers))
        if answers[0] is not None:
            return answers[0].response
    raise AssertionError(f"no answer to {request}")


# --- other programs see our frames, and we see theirs ---


def test_candump_and_python_can_see_our_frames_in_order(link: Link) -> None:
    with can.Bus(channel=BUS, interface="socketcan") as bus:
        dump = subprocess.Popen(
            ["candump", "-L", "-n", "400", "-T", "300000", BUS], stdout=subprocess.PIPE, text=True
        )
        seen = []
        while len(seen) < 60:
            message = bus.recv(PATIENCE_S)
            assert message is not None
            if message.arbitration_id == RAW_COMMAND:
                assert message.is_extended_id
                seen.append(bytes(message.data))
    # 0.25 of 8191 in four times 14 bits: 2048, low byte first.
    assert {data[:7] for data in seen if any(data[:7])} == {bytes.fromhex("00200080020008")}
    ids = [data[7] & 0x1F for data in seen]
    assert all((b - a) % 32 == 1 for a, b in pairwise(ids))
    text, _ = dump.communicate(timeout=PATIENCE_S)
    frames = {line.split()[2].split("#")[0] for line in text.splitlines()}
    assert {f"{RAW_COMMAND:08X}", f"{NODE_STATUS:08X}"} <= frames
    link.stop()


def test_what_cansend_and_cangen_send_arrives_in_order_or_is_counted(link: Link) -> None:
    with raw_socket() as bus:
        wait_for_us(bus)
        for number in range(20):
            subprocess.run(["cansend", BUS, f"1ABC{number:04X}#{number:02X}"], check=True)
        subprocess.run(["cansend", BUS, "123#AB"], check=True)
        subprocess.run(["cansend", BUS, "123#R"], check=True)
        subprocess.run(["cangen", BUS, "-e", "-L", "8", "-g", "2", "-n", "300"], check=True)
        wait_for_us(bus)
    status = newest(link.stop(), "can_interface_status")
    # 20 and 1 of cansend, 300 of cangen; the remote frame does not pass the filter.
    assert status["frames_rx"] + status["rx_lost"] == 321
    assert status["frames_tx"] > 0
    assert status["tx_lost"] == 0


# --- the package dronecan as a peer ---


def test_a_node_monitor_knows_us(link: Link, peer: Any) -> None:
    monitor = NodeMonitor(peer)
    spin_until(peer, lambda: monitor.exists(OUR_ID) and monitor.get(OUR_ID).info is not None)
    info = monitor.get(OUR_ID).info
    assert info.name.decode() == "org.stator.vehicle"
    assert bytes(info.hardware_version.unique_id.to_bytes()) == b"\x01" + bytes(15)
    assert monitor.get(OUR_ID).status.health == info.status.HEALTH_OK
    link.stop()


def allocate(bus: socket.socket, unique_id: bytes, preferred: int = 0) -> int:
    """Plays a part without an id, which asks until it is heard."""
    for _ in range(10):
        with contextlib.suppress(NeverCame):
            return ask_for_id(bus, unique_id, preferred)
    raise NeverCame


def ask_for_id(bus: socket.socket, unique_id: bytes, preferred: int) -> int:
    """Three pieces, each after the answer to the one before."""
    pieces = [unique_id[:6], unique_id[6:12], unique_id[12:]]
    known = b""
    for number, piece in enumerate(pieces):
        request = uavcan.protocol.dynamic_node_id.Allocation()
        request.node_id = preferred
        request.first_part_of_unique_id = number == 0
        request.unique_id.from_bytes(piece)
        transfer = Transfer(payload=request, source_node_id=0, discriminator=77 + number)
        for frame in transfer.to_frames():
            send(bus, frame.message_id | socket.CAN_EFF_FLAG, bytes(frame.bytes))
        known += piece
        answer = receive_allocation(bus)
        assert bytes(answer.unique_id.to_bytes()) == known
    return int(answer.node_id)


def receive_allocation(bus: socket.socket) -> Any:
    payload = []
    while True:
        _, data = next_frame(bus, lambda i: i & 0xFFFFFF == 0x00010A, patience_s=3.0)
        payload.append(data)
        if data[-1] & 0x40:
            break
    transfer = Transfer()
    frames = [dronecan.transport.Frame(0x1E00010A, data) for data in payload]
    transfer.from_frames(frames)
    return transfer.payload


@pytest.mark.usefixtures("link")
def test_parts_are_given_ids_and_the_same_again() -> None:
    with raw_socket() as bus:
        wait_for_us(bus)
        one = allocate(bus, bytes(range(16)))
        two = allocate(bus, bytes(range(1, 17)))
        three = allocate(bus, bytes(range(2, 18)), preferred=55)
        assert len({one, two, three}) == 3
        assert three == 55
        assert all(50 <= node <= 125 for node in (one, two, three))
        assert allocate(bus, bytes(range(16))) == one


def test_a_part_gets_its_id_again_after_a_restart(start: Callable[[], Link]) -> None:
    """An id that does not follow from the part's own: it is the one that it prefers at first."""
    one, two = bytes(range(16)), bytes(range(1, 17))
    link = start()
    with raw_socket() as bus:
        wait_for_us(bus)
        assert allocate(bus, one, preferred=120) == 120
    first = newest(link.stop(), "nonvolatile_status")
    assert (first["state"], first["records"], first["refused"]) == (1, 1, 0)
    link = start()
    with raw_socket() as bus:
        wait_for_us(bus)
        assert allocate(bus, two, preferred=120) != 120
        assert allocate(bus, one) == 120
    second = newest(link.stop(), "nonvolatile_status")
    assert (second["state"], second["records"], second["mended"]) == (1, 2, 0)


@contextlib.contextmanager
def intruder(bus: socket.socket, node: int) -> Iterator[None]:
    """A node that says how it is, under an id that may be another's."""
    part, is_over = Part(bus, node), threading.Event()

    def run() -> None:
        while not is_over.wait(0.2):
            part.send(uavcan.protocol.NodeStatus(uptime_sec=100))

    thread = threading.Thread(target=run)
    thread.start()
    try:
        yield
    finally:
        is_over.set()
        thread.join()


def test_a_part_whose_id_another_node_uses_gets_another_and_that_is_told(link: Link) -> None:
    part = bytes(range(16))
    with raw_socket() as bus:
        wait_for_us(bus)
        given = allocate(bus, part)
        with intruder(bus, given):
            commands(bus, 50)
            other = allocate(bus, part)
        assert other != given
        assert allocate(bus, part) == other
        with intruder(bus, OUR_ID):
            commands(bus, 50)
    conflicts = link.stop().get_dataset("can_node_conflict").data
    rows = zip(conflicts["node_id"], conflicts["kind"], conflicts["new_node_id"], strict=True)
    part_of_id, own_id = 1, 2  # CanNodeConflict
    assert list(rows) == [(given, part_of_id, other), (OUR_ID, own_id, 0)]


GetSet = uavcan.protocol.param.GetSet


def write(peer: Any, name: str, **value: Any) -> Any:
    request = GetSet.Request()
    request.name = name
    request.value = uavcan.protocol.param.Value(**value)
    return ask(peer, request)


def test_parameters_of_all_nodes_are_listed(link: Link, peer: Any) -> None:
    names: list[str] = []
    while True:
        response = ask(peer, GetSet.Request(index=len(names)))
        if not response.name.decode():
            break
        names.append(response.name.decode())
    log = link.stop()
    assert sorted(names) == sorted(log.initial_parameters)
    assert {name.split(".")[0] for name in names} == {
        *("can_esc", "can_gnss", "dronecan_node", "throttle")
    }


def test_parameters_are_read_and_written(link: Link, peer: Any) -> None:
    assert write(peer, "dronecan_node.last_given", integer_value=100).value.integer_value == 100
    refused = write(peer, "dronecan_node.last_given", integer_value=126)  # out of range
    assert refused.value.integer_value == 100
    assert refused.max_value.integer_value == 125
    assert refused.default_value.integer_value == 125
    again = ask(peer, GetSet.Request(name="dronecan_node.last_given"))
    assert again.value.integer_value == 100
    # What others know us by does not change, and a name is not cut to one that there is.
    assert write(peer, "dronecan_node.node_id", integer_value=11).value.integer_value == OUR_ID
    assert not write(peer, "throttle.controls", real_value=0.5).name.decode()
    timeout = write(peer, "can_esc.offline_timeout", real_value=0.5)
    assert (timeout.value.real_value, timeout.max_value.real_value) == (0.5, 10.0)
    assert link.stop().changed_parameters[-1][1:] == ("can_esc.offline_timeout", 0.5)


def test_a_written_parameter_acts_at_once_until_the_vehicle_is_armed(link: Link, peer: Any) -> None:
    """The motors' command doubles on the bus."""
    assert write(peer, "throttle.control", real_value=0.5).value.real_value == 0.5
    # 0.5 of 8191 in four times 14 bits: 4096, low byte first. An old command means none at all.
    doubled = bytes.fromhex("00400100040010")
    with raw_socket() as bus:
        is_command = RAW_COMMAND.__eq__
        assert any(next_frame(bus, is_command)[1][:7] == doubled for _ in range(200))
    assert write(peer, "throttle.armed", boolean_value=True).value.boolean_value
    assert write(peer, "throttle.control", real_value=0.75).value.real_value == 0.5
    log = link.stop()
    names = [name for _, name, _ in log.changed_parameters]
    assert names == ["throttle.control", "throttle.armed"]
    controls = log.get_dataset("actuator_motors").data["control[0]"]
    assert (controls[0], controls[-1]) == (0.25, 0.5)


def test_a_restart_is_answered_and_then_done(link: Link, peer: Any) -> None:
    request = uavcan.protocol.RestartNode.Request()
    stranger = Node(Driver(), node_id=99)
    try:
        request.magic_number = request.MAGIC_NUMBER
        assert not ask(stranger, request).ok
    finally:
        stranger.close()
    request.magic_number = 1
    assert not ask(peer, request).ok
    request.magic_number = request.MAGIC_NUMBER
    assert ask(peer, request).ok
    output, errors = link.process.communicate(timeout=PATIENCE_S)
    assert link.process.returncode == RESTART, errors
    assert json.loads(output)["ended"] == "restart"
    asked = newest(ULog(str(link.log)), "restart_request")
    assert asked["source"] == TOOL


# --- motor controllers and a receiver ---


def esc_status(index: int) -> Any:
    return uavcan.equipment.esc.Status(
        error_count=index, voltage=12.0, current=3.0, temperature=300.0, rpm=1000 * index,
        power_rating_pct=25, esc_index=index,
    )  # fmt: skip


def send_and_wait(bus: socket.socket, part: Part, payload: Any) -> None:
    """Until our node has had the time to read it, however slow it is: its queue of frames is
    short. Its newest command may be older than what is sent here, the one after that is not."""
    part.send(payload)
    with contextlib.suppress(BlockingIOError):
        bus.setblocking(False)
        while True:
            bus.recv(16)
    bus.settimeout(PATIENCE_S)
    commands(bus, 2)


def test_what_controllers_and_a_receiver_do_not_know_is_nan_and_the_rest_counts(link: Link) -> None:
    fields = ["voltage", "current", "temperature"]
    with raw_socket() as bus:
        escs = [Part(bus, 20 + index) for index in range(3)]
        receiver = Part(bus, 40)
        fix = uavcan.equipment.gnss.Fix2(
            longitude_deg_1e8=854559400, latitude_deg_1e8=4739774200, height_msl_mm=488000,
            ned_velocity=[1.0, -2.0, math.nan], sats_used=14, status=3,
        )  # fmt: skip
        for _ in range(6):
            wait_for_us(bus)
            for index, esc in enumerate(escs):
                status = esc_status(index)
                setattr(status, fields[index], math.nan)
                send_and_wait(bus, esc, status)
            geometry = uavcan.equipment.gnss.Auxiliary(hdop=0.8, vdop=math.nan)
            send_and_wait(bus, receiver, geometry)
            send_and_wait(bus, receiver, fix)
    log = link.stop()
    status = newest(log, "esc_status")
    assert (status["esc_online_flags"], status["rejected"]) == (0b0111, 0)
    assert [status[f"esc_rpm[{i}]"] for i in range(3)] == [0, 1000, 2000]
    for index, field in enumerate(fields):
        unknown = [i for i in range(3) if math.isnan(status[f"esc_{field}[{i}]"])]
        assert unknown == [index], field
    gps = newest(log, "sensor_gps")
    assert gps["latitude_deg"] == 47.397742
    assert gps["eph"] == pytest.approx(0.8 * 2.5, abs=0.01)
    assert math.isnan(gps["epv"])
    assert math.isnan(gps["vel_d_m_s"])
    assert not gps["vel_ned_valid"]


def commands(bus: socket.socket, count: int) -> None:
    for _ in range(count):
        wait_for_us(bus)


def test_four_controllers_and_a_receiver_are_heard(link: Link) -> None:
    with raw_socket() as bus:
        escs = [Part(bus, 20 + index) for index in range(4)]
        receiver = Part(bus, 40)
        fix = uavcan.equipment.gnss.Fix2(
            longitude_deg_1e8=854559400, latitude_deg_1e8=4739774200, height_msl_mm=488000,
            height_ellipsoid_mm=535600, ned_velocity=[1.0, -2.0, 0.5], sats_used=14, status=3,
            covariance=[4.0, 4.0, 9.0, 0.25, 0.25, 0.25],
        )  # fmt: skip
        for _ in range(6):
            wait_for_us(bus)
            for index, esc in enumerate(escs):
                send_and_wait(bus, esc, esc_status(index))
            send_and_wait(bus, receiver, fix)
            send_and_wait(bus, receiver, uavcan.equipment.gnss.Auxiliary(hdop=0.8, vdop=1.2))
    log = link.stop()
    status = newest(log, "esc_status")
    assert status["esc_online_flags"] == 0b1111
    assert [status[f"esc_rpm[{i}]"] for i in range(4)] == [0, 1000, 2000, 3000]
    assert [status[f"esc_address[{i}]"] for i in range(4)] == [20, 21, 22, 23]
    gps = newest(log, "sensor_gps")
    assert gps["latitude_deg"] == 47.397742
    assert gps["longitude_deg"] == 8.545594
    assert (gps["eph"], gps["epv"], gps["s_variance_m_s"]) == (2.0, 3.0, 0.5)
    assert gps["fix_type"] == 3


def test_a_controller_that_falls_silent_goes_offline(link: Link) -> None:
    with raw_socket() as bus:
        escs = [Part(bus, 20 + index) for index in range(4)]
        for number in range(60):
            for index, esc in enumerate(escs):
                if index != 2 or number < 5:
                    esc.send(esc_status(index))
            commands(bus, 5)
    flags = list(link.stop().get_dataset("esc_status").data["esc_online_flags"])
    assert 0b1111 in flags, "all were online"
    assert flags[-1] == 0b1011, "and one is no longer"


def test_a_babbling_node_costs_counts_only(link: Link) -> None:
    """Of its allowed rate what is beyond is dropped; others are heard, and commands go on."""
    with raw_socket() as bus:
        good, babbler, stranger = Part(bus, 20), Part(bus, 21), Part(bus, 99)
        wait_for_us(bus)  # else the first one that is heard may be the babbler
        for _ in range(30):
            good.send(esc_status(0))
            for _ in range(15):
                babbler.send(esc_status(1))
                time.sleep(0.002)  # a bus has no room for more
            stranger.send(esc_status(2))
            babbler.send(esc_status(0))  # which is another's
            wait_for_us(bus)
    log = link.stop()
    status = newest(log, "esc_status")
    assert status["esc_online_flags"] & 1
    assert status["esc_address[0]"] == 20
    assert status["rejected"] > 0
    assert not status["esc_online_flags"] & 0b100
    assert newest(log, "can_interface_status")["frames_tx"] > 30


# --- the interface ---


def test_bus_off_is_told_and_survived(link: Link) -> None:
    with raw_socket() as bus:
        wait_for_us(bus)
        send(bus, socket.CAN_ERR_FLAG | BUS_OFF, bytes(8))
        time.sleep(1)
        send(bus, socket.CAN_ERR_FLAG | RESTARTED, bytes(8))
        commands(bus, 3)
    log = link.stop()
    states = list(log.get_dataset("can_interface_status").data["state"])
    assert 3 in states, "bus-off"
    assert states[-1] == 0
    status = newest(log, "can_interface_status")
    assert status["bus_off_count"] == 1
    assert status["tx_lost"] > 0, "what was to be sent meanwhile is lost, and counted"


def ip(*arguments: str) -> None:
    subprocess.run(["ip", "link", *arguments], check=True)


def test_a_transmit_queue_that_is_full_holds_frames_up_or_costs_them_and_is_told(
    link: Link,
) -> None:
    """The kernel says ENOBUFS where an interface's queue is full. A virtual one has no queue but
    for a shaper: here of three frames, emptied at a quarter of the rate of the commands alone."""
    with raw_socket() as bus:
        commands(bus, 5)
        shaper = ["tc", "qdisc", "add", "dev", BUS, "root", "tbf"]
        subprocess.run([*shaper, "rate", "1600bit", "burst", "32", "limit", "48"], check=True)
        commands(bus, 20)
        queue = subprocess.run(
            ["tc", "-s", "-j", "qdisc", "show", "dev", BUS], check=True, capture_output=True
        )
        subprocess.run(["tc", "qdisc", "del", "dev", BUS, "root"], check=True)
        commands(bus, 20)
    log = link.stop()
    assert json.loads(queue.stdout)[0]["drops"] > 0, "it was full"
    status = log.get_dataset("can_interface_status").data
    assert status["state"][-1] == 0
    assert status["io_errors"][-1] == 0, "the bus is well, and stays open"
    lost = status["tx_lost"]
    assert 0 < lost[-1] < status["frames_tx"][-1]
    assert lost[-1] == lost[-20], "no more, once there is room again"


def test_an_interface_that_goes_away_and_comes_back(link: Link) -> None:
    with raw_socket() as bus:
        wait_for_us(bus)
    ip("set", BUS, "down")
    time.sleep(0.5)
    ip("set", BUS, "up")
    with raw_socket() as bus:
        wait_for_us(bus)
    ip("del", BUS)
    time.sleep(0.5)
    ip("add", BUS, "type", "vcan")
    ip("set", BUS, "up")
    with raw_socket() as bus:
        commands(bus, 3)
    states = list(link.stop().get_dataset("can_interface_status").data["state"])
    assert 4 in states, "down"
    assert states[-1] == 0
