"""A user looks at firmware while it flies: top, perf and listener, by their command lines."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import time
from typing import TYPE_CHECKING

import pytest
from tests.emulation.firmware_tools import needs_emulator

from stator import HOME
from stator import __main__ as cli

if TYPE_CHECKING:
    from collections.abc import Iterator
    from pathlib import Path

START_S = 1800.0  # until the firmware is there, on a busy machine


@pytest.fixture(scope="module")
def link(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Path]:
    """The socket of a flight that lasts until the tests are over."""
    needs_emulator()
    folder = tmp_path_factory.mktemp("link")
    socket = folder / "s"
    command = [sys.executable, "-m", "stator", "emulate", "--link", str(socket), "--speed", "1"]
    command += ["--duration", "600", "-o", str(folder / "flight.ulg")]
    environment = os.environ | {"PYTHONPATH": str(HOME / "codegen")}
    process = subprocess.Popen(command, env=environment, stderr=subprocess.PIPE, text=True)
    end = time.monotonic() + START_S
    while not socket.exists() and process.poll() is None and time.monotonic() < end:
        time.sleep(0.1)
    if not socket.exists():
        process.kill()
        pytest.fail(f"no firmware: {process.communicate()[1]}")
    yield socket
    process.terminate()
    process.communicate()


def ask(capsys: pytest.CaptureFixture[str], *words: str) -> str:
    capsys.readouterr()
    assert cli.main([*words]) == 0, capsys.readouterr().err
    return capsys.readouterr().out


def test_top_shows_every_task(link: Path, capsys: pytest.CaptureFixture[str]) -> None:
    facts = json.loads(ask(capsys, "top", "--link", str(link), "--once", "--json"))
    assert (facts["graph"], facts["board"]) == ("quad", "qemu_f405")
    assert facts["measured_in"] == "instructions"
    tasks = {row["task"]: row for row in facts["tasks"]}
    assert tasks["rate_control"]["level"] == 13
    # In the firmware's own time: an IMU sample each millisecond, the sequence each 20.
    assert tasks["rate_control"]["per_s"] == pytest.approx(1000, rel=0.1)
    assert tasks["sequence"]["per_s"] == pytest.approx(50, rel=0.1)
    for row in tasks.values():
        assert 0 < row["last_us"] <= row["max_us"], row
        assert row["load_pct"] == pytest.approx(row["mean_us"] * row["per_s"] * 1e-4, rel=0.01)


def test_top_fits_a_terminal(link: Path, capsys: pytest.CaptureFixture[str]) -> None:
    table = ask(capsys, "top", "--link", str(link), "--once", "--interval", "0.3")
    assert all(len(line) <= 80 for line in table.splitlines())
    assert " position_estimate " in table


def test_perf_sets_bounds_beside_figures(link: Path, capsys: pytest.CaptureFixture[str]) -> None:
    facts = json.loads(ask(capsys, "perf", "--link", str(link), "--json"))
    (chain,) = facts["chains"]
    assert (chain["chain"], chain["deadline_us"]) == ("gyro_to_motor", 500)
    responses = {row["task"]: row["response_max_us"] for row in facts["tasks"]}
    assert chain["latency_max_us"] is None  # the status wakes the allocation, too
    assert responses["imu0"] is None  # nothing in the graph is about its end
    assert 0 < responses["rate_control"] < responses["motors"] < 500
    text = ask(capsys, "perf", "--link", str(link))
    assert "gyro_to_motor" in text
    assert "500" in text


def test_listener_decodes_samples(link: Path, capsys: pytest.CaptureFixture[str]) -> None:
    words = ["listener", "vehicle_attitude", "--link", str(link), "--count", "3"]
    samples = [json.loads(line) for line in ask(capsys, *words, "--json").splitlines()]
    assert [sample["number"] for sample in samples] == sorted({s["number"] for s in samples})
    assert len(samples) == 3
    for sample in samples:
        q = sample["fields"]["q"]
        assert sum(part * part for part in q) == pytest.approx(1.0, abs=1e-5)
    # One each millisecond, as the gyro's.
    assert samples[2]["rate_hz"] == pytest.approx(1000, rel=0.01)
    text = ask(capsys, "listener", "vehicle_status", "--link", str(link), "--count", "1")
    assert "arming_state" in text


def test_an_unknown_topic_is_refused(link: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.main(["listener", "vehicle_atitude", "--link", str(link)]) == 2
    assert "vehicle_attitude" in capsys.readouterr().err


def test_another_graph_is_refused(
    link: Path, capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    other = tmp_path / "higher.yaml"
    other.write_text(
        "include: [{file: quad.yaml}]\nboard: fmu_v2\nnodes: {sequence: {params: {height: 3 m}}}\n"
    )
    assert cli.main(["top", "--once", "--link", str(link), "--graph", str(other)]) == 2
    assert "another version" in capsys.readouterr().err


def test_nobody_there(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    assert cli.main(["top", "--link", str(tmp_path / "none")]) == 2
    error = capsys.readouterr().err
    assert "error: cannot connect to" in error
    assert "./stator emulate --link" in error
