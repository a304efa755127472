"""The quad's firmware flies in QEMU: within the limits, the same bits each time, losing nothing."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import time
from pathlib import Path
from typing import Any

import pytest
from tests.emulation.firmware_tools import needs_emulator

from stator import HOME
from stator import __main__ as cli
from stator.build.cmake import RECORDING, build, build_plant
from stator.emulator.qemu import FIFOS, Emulator, fly
from stator.live.fault_record import in_words
from stator.pipeline import make_plan
from stator.prove.proof import prove

QUAD = HOME / "graph" / "quad.yaml"


@pytest.fixture
def emulator() -> Emulator:
    return needs_emulator()


def emulate(capsys: pytest.CaptureFixture[str], *arguments: str) -> tuple[int, dict[str, object]]:
    status = cli.main(["emulate", str(QUAD), "--json", *arguments])
    facts: dict[str, object] = json.loads(capsys.readouterr().out)
    return status, facts


CLOCK_NS = 1000


def responses_and_bounds(figures: Any) -> list[tuple[str, int, int]]:
    """Of the tasks whose response is measured. Budgets: what each task took in this flight."""
    plan = make_plan(str(QUAD), "qemu_f405")
    instruction_ns = plan.board.costs.instruction_ns if plan.board.costs else None
    assert instruction_ns is not None
    proof = prove(plan, {row["task"]: row["instructions"] * instruction_ns for row in figures})
    found = [
        (row["task"], row["response_us"], proof.task(row["task"]).response_ns)
        for row in figures
        if row["response_us"] is not None
    ]
    assert [name for name, _, _ in found] == ["rate_control", "motors"]
    return [(name, response, bound) for name, response, bound in found if bound is not None]


@pytest.mark.parametrize(
    "seed", [1, 2, *(pytest.param(n, marks=pytest.mark.long) for n in range(3, 11))]
)
def test_the_firmware_keeps_the_limits(
    emulator: Emulator, capsys: pytest.CaptureFixture[str], tmp_path: Path, seed: int
) -> None:
    log = str(tmp_path / "flight.ulg")
    status, facts = emulate(capsys, "--seed", str(seed), "-o", log, "--figures")
    assert (status, facts["success"]) == (0, True), facts
    assert (facts["lost_samples"], facts["missed_samples"]) == (0, 0)
    assert facts["emulator"] == emulator.version
    for name, response_us, bound_ns in responses_and_bounds(facts["figures"]):
        assert 0 < response_us * 1000 <= bound_ns + CLOCK_NS, name


def test_the_firmware_begins_a_mission(
    emulator: Emulator, capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    """Its items come from the memory of the mission device; it takes off at 5.8 s."""
    mission = HOME / "graph" / "missions" / "square.yaml"
    log = str(tmp_path / "flight.ulg")
    cli.main(["emulate", "--mission", str(mission), "--duration", "7", "-o", log, "--json"])
    facts = json.loads(capsys.readouterr().out)
    assert facts["emulator"] == emulator.version
    assert [mode["mode"] for mode in facts["modes"]] == ["hold", "mission"]
    assert facts["take_off_s"] < 6.5
    assert facts["items_total"] == 5


@pytest.mark.long
@pytest.mark.parametrize("seed", [2, 9])
def test_the_firmware_holds_its_place_in_wind(
    emulator: Emulator, capsys: pytest.CaptureFixture[str], tmp_path: Path, seed: int
) -> None:
    wind = ["--wind", "8", "--gusts", "moderate"]
    status, facts = emulate(capsys, *wind, "--seed", str(seed), "-o", str(tmp_path / "flight.ulg"))
    assert (status, facts["success"]) == (0, True), facts
    assert facts["emulator"] == emulator.version


@pytest.mark.parametrize("runs", [2, pytest.param(10, marks=pytest.mark.long)])
def test_a_flight_repeats_bit_for_bit(
    emulator: Emulator,
    capsys: pytest.CaptureFixture[str],
    tmp_path: Path,
    runs: int,
) -> None:
    log = tmp_path / "flight.ulg"
    duration = "10" if runs == 2 else "120"
    hashes = set()
    for _ in range(runs):
        _, facts = emulate(capsys, "--duration", duration, "-o", str(log))
        assert facts["activations"]
        hashes.add(facts["log_sha256"])
    assert len(hashes) == 1


def test_another_seed_flies_another_log(
    emulator: Emulator,
    capsys: pytest.CaptureFixture[str],
    tmp_path: Path,
) -> None:
    log = str(tmp_path / "flight.ulg")
    _, one = emulate(capsys, "--duration", "2", "-o", log)
    _, two = emulate(capsys, "--duration", "2", "-o", log, "--seed", "2")
    assert one["log_sha256"] != two["log_sha256"]


def test_sleeping_firmware_flies_as_well(
    emulator: Emulator,
    capsys: pytest.CaptureFixture[str],
    tmp_path: Path,
) -> None:
    status, facts = emulate(capsys, "--sleep", "-o", str(tmp_path / "flight.ulg"))
    assert (status, facts["success"]) == (0, True), facts
    assert facts["lost_samples"] == 0


def test_an_interrupted_flight_has_a_report_a_log_and_its_status(
    emulator: Emulator, tmp_path: Path
) -> None:
    """The whole group hears Ctrl-C."""
    build(QUAD, "qemu_f405", RECORDING, executor="cortex_m")
    log = tmp_path / "flight.ulg"
    command = [str(HOME / "stator"), "emulate", "--speed", "1", "-o", str(log)]
    pipe = subprocess.PIPE
    process = subprocess.Popen(command, stdout=pipe, stderr=pipe, text=True, process_group=0)
    truth = log.with_suffix(".truth")
    while process.poll() is None and not (truth.exists() and truth.stat().st_size > 0):
        time.sleep(0.02)
    os.killpg(process.pid, signal.SIGINT)
    output, errors = process.communicate()
    assert process.returncode == 128 + signal.SIGINT, errors
    assert "SIGINT ended the flight early\n" in output
    assert f"log       {log} (" in output
    facts = json.loads(log.with_suffix(".json").read_text())
    assert facts["success"] is False
    assert facts["emulator"] == emulator.version


def test_a_plant_that_ends_ends_the_flight(emulator: Emulator, tmp_path: Path) -> None:
    image = build(QUAD, "qemu_f405", executor="cortex_m")
    plant = ["sh", "-c", f"head -c 1000 {FIFOS[0]} >heard & sleep 0.2; : >{FIFOS[1]}; wait"]
    finished = fly(emulator, image, plant, tmp_path / "flight.ulg")
    assert finished.returncode != 0
    words = in_words(finished.stderr, make_plan(str(QUAD), "qemu_f405"), image)
    assert "the plant is gone" in words, words


def test_a_plant_that_never_starts_ends_the_flight(emulator: Emulator, tmp_path: Path) -> None:
    image = build(QUAD, "qemu_f405", executor="cortex_m")
    finished = fly(emulator, image, [str(build_plant()), "--seed", "x"], tmp_path / "flight.ulg")
    assert finished.returncode != 0
    assert "--seed: expected" in finished.stderr


def test_an_old_emulator_is_refused(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    old = tmp_path / "qemu"
    old.write_text("#!/bin/sh\necho QEMU emulator version 7.2.22; echo netduinoplus2 Netduino\n")
    old.chmod(0o755)
    monkeypatch.setenv("STATOR_QEMU", str(old))
    assert cli.main(["emulate", str(QUAD)]) == 2
    error = capsys.readouterr().err
    assert (
        "error: expected QEMU with the machine olimex-stm32-h405, found QEMU emulator version 7."
        in error
    )
    assert "hint: install QEMU 10 or newer" in error


def test_a_board_that_is_no_firmware_is_refused(
    emulator: Emulator,
    capsys: pytest.CaptureFixture[str],
) -> None:
    assert cli.main(["emulate", str(QUAD), "--board", "sitl"]) == 2
    error = capsys.readouterr().err
    assert "error: expected a board with executor cortex_m, found 'sitl' with virtual" in error
    assert "hint: use ./stator fly" in error
