"""Recorded flights replay equal, whoever executed them; differences, gaps and damage are found."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import zlib
from pathlib import Path
from typing import Any

import pytest
from pyulog import ULog
from tests.emulation.firmware_tools import needs_emulator

from stator import HOME
from stator import __main__ as cli
from stator.build.cmake import PREEMPTION, RECORDING, build

QUAD = HOME / "graph" / "quad.yaml"
MIXED = Path(__file__).parent / "graph" / "mixed.yaml"


def flown(graph: Path, log: Path, *options: str, variant: dict[str, str]) -> dict[str, Any]:
    program = build(graph, "sitl", variant)
    command = [program, "--log", log, "--duration", "4", *options]
    result = subprocess.run(command, check=True, capture_output=True, text=True)
    facts: dict[str, Any] = json.loads(result.stdout)
    return facts


def replay(capsys: pytest.CaptureFixture[str], log: Path, *options: str) -> dict[str, Any]:
    """The facts; that the exit status agrees with them is checked here."""
    capsys.readouterr()
    status = cli.main(["replay", str(log), "--json", *options])
    facts: dict[str, Any] = json.loads(capsys.readouterr().out)
    assert status == (0 if facts["equal"] else 1)
    return facts


def refusal(capsys: pytest.CaptureFixture[str], log: Path, *options: str) -> str:
    capsys.readouterr()
    assert cli.main(["replay", str(log), *options]) == 2
    output = capsys.readouterr()
    assert output.out == ""
    return output.err


@pytest.fixture(scope="module")
def mixed(tmp_path_factory: pytest.TempPathFactory) -> Path:
    log = tmp_path_factory.mktemp("flight") / "mixed.ulg"
    facts = flown(MIXED, log, "--times", "random", variant=PREEMPTION | RECORDING)
    assert facts["preemptions"] > 100
    assert facts["refused_output"] == "gather.sum"
    assert 100 < facts["refused_publications"] <= 200  # one each 20 ms, in two modes of three
    return log


def test_a_virtual_flight_with_random_times_replays_equal(
    capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    log = tmp_path / "flight.ulg"
    facts = flown(QUAD, log, "--times", "random", variant=PREEMPTION | RECORDING)
    assert facts["preemptions"] >= 1000
    replayed = replay(capsys, log)
    assert replayed["equal"], replayed
    assert {"vehicle_attitude", "actuator_motors", "rate_control_params"} <= set(replayed["topics"])
    assert all(replayed["topics"].values())
    assert replayed["replayed_until_s"] > 3.8  # the log is flushed each 0.1 s


def test_a_flight_of_the_firmware_replays_equal(
    capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    needs_emulator()
    log = tmp_path / "flight.ulg"
    cli.main(["emulate", str(QUAD), "--duration", "8", "--json", "-o", str(log)])
    facts = json.loads(capsys.readouterr().out)
    assert facts["preemptions"] >= 1000
    assert facts["recording"] == str(log)
    assert (facts["unrecorded_activations"], facts["lost_samples"]) == (0, 0)
    replayed = replay(capsys, log)
    assert replayed["equal"], replayed
    assert replayed["board"] == "qemu_f405"
    assert len(replayed["topics"]) == 18
    assert replayed["samples"] > 30_000


@pytest.mark.long
def test_a_whole_flight_of_the_firmware_replays_equal(
    capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    needs_emulator()
    log = tmp_path / "flight.ulg"
    assert cli.main(["emulate", str(QUAD), "-o", str(log)]) == 0
    replayed = replay(capsys, log)
    assert replayed["equal"], replayed


def test_every_kind_of_input_and_mode_replays_equal(
    capsys: pytest.CaptureFixture[str], mixed: Path
) -> None:
    replayed = replay(capsys, mixed)
    assert replayed["equal"], replayed
    assert set(replayed["topics"]) == {
        *("mode", "count", "sum", "smooth", "careful_params", "bold_params")
    }


def test_recording_changes_nothing_of_a_flight(tmp_path: Path) -> None:
    plain, recorded = tmp_path / "plain.ulg", tmp_path / "recorded.ulg"
    flown(QUAD, plain, variant={})
    flown(QUAD, recorded, variant=RECORDING)
    logs = [ULog(str(log)) for log in (plain, recorded)]
    assert not logs[1].file_corruption
    assert logs[0].initial_parameters == logs[1].initial_parameters
    assert [d.name for d in logs[0].data_list] == [d.name for d in logs[1].data_list]
    for one, other in zip(logs[0].data_list, logs[1].data_list, strict=True):
        # A log begins behind its definitions, with the newest samples, and ends with what was
        # flushed: both depend on how much there is to write.
        begin = max(side.data["timestamp"][:2][-1] for side in (one, other))
        skip, skip_other = (int((side.data["timestamp"] < begin).sum()) for side in (one, other))
        count = min(len(one.data["timestamp"]) - skip, len(other.data["timestamp"]) - skip_other)
        assert count > 0.9 * len(one.data["timestamp"])
        for name, values in one.data.items():
            found = other.data[name][skip_other : skip_other + count]
            assert values[skip : skip + count].tobytes() == found.tobytes(), name


# --- differences ---


def changed_graph(folder: Path, name: str, *changes: tuple[str, str, str]) -> Path:
    """A copy of the graph, of another name as each has a build of its own."""
    shutil.copytree(MIXED.parent, folder, dirs_exist_ok=True)
    graph = folder / f"{name}.yaml"
    (folder / MIXED.name).rename(graph)
    for file, old, new in changes:
        path = folder / file.replace(MIXED.name, graph.name)
        text = path.read_text(encoding="utf-8")
        assert text.count(old) == 1
        path.write_text(text.replace(old, new), encoding="utf-8")
    return graph


def test_changed_code_is_found_at_its_first_sample(
    capsys: pytest.CaptureFixture[str], mixed: Path, tmp_path: Path
) -> None:
    change = ("apps/gather/gather.hpp", "4 * ports.fired.timers", "5 * ports.fired.timers")
    graph = changed_graph(tmp_path, "changed_code", change)
    replayed = replay(capsys, mixed, "--graph", str(graph))
    # Every sample of `sum` is in the log, so that its rows say where and what.
    logged = next(d for d in ULog(str(mixed)).data_list if d.name == "sum").data
    rows = logged["seen"]
    first = next(i for i, seen in enumerate(rows) if seen >= 4)
    found = replayed["first_difference"]
    assert (found["topic"], found["sequence_number"], found["field"]) == ("sum", first + 1, "seen")
    assert (found["recorded"], found["replayed"]) == (rows[first], rows[first] + 1)
    assert replayed["topics"] == {
        **dict.fromkeys(("mode", "count", "smooth", "careful_params", "bold_params"), True),
        "sum": False,
    }
    assert replayed["same_hash"]  # the hash is of the graph, not of code
    # The log has samples of its last activations, but not their records.
    is_replayed = logged["timestamp"] <= round(replayed["replayed_until_s"] * 1e6)
    assert replayed["different_samples"] == sum(rows[is_replayed] >= 4)

    source = graph.parent / "apps" / "gather" / "gather.hpp"
    shutil.copy2(MIXED.parent / "apps" / "gather" / "gather.hpp", source)
    os.utime(source, ns=(10**18, 10**18))  # older than what was built
    assert replay(capsys, mixed, "--graph", str(graph))["equal"]


def test_a_changed_parameter_is_named_and_the_recorded_one_is_used(
    capsys: pytest.CaptureFixture[str], mixed: Path, tmp_path: Path
) -> None:
    graph = changed_graph(
        tmp_path,
        "changed_parameter",
        (MIXED.name, "params: {stride: 10}", "params: {stride: 11}"),
        ("apps/smooth/smooth.hpp", "kGain = 0.125F", "kGain = 0.25F"),
    )
    replayed = replay(capsys, mixed, "--graph", str(graph))
    found = replayed["first_difference"]
    assert (found["topic"], found["field"]) == ("bold_params", "stride")
    assert (found["recorded"], found["replayed"]) == (10, 11)
    assert not replayed["same_hash"]
    assert replayed["topics"]["count"]
    assert not replayed["topics"]["smooth"]
    assert not replayed["topics"]["sum"]  # a difference travels on
    cli.main(["replay", str(mixed), "--graph", str(graph)])
    text = capsys.readouterr().out
    assert "NOT EQUAL" in text
    assert "stride: recorded 10, replayed 11" in text
    assert "it has changed since" in text


def test_a_graph_that_does_not_fit_is_refused(
    capsys: pytest.CaptureFixture[str], mixed: Path
) -> None:
    error = refusal(capsys, mixed, "--graph", str(QUAD))
    assert "expected graph 'mixed' with hash" in error
    assert "topic smooth" in error
    assert "replay with the graph that flew: --graph FILE" in error


def test_a_graph_that_is_gone_is_asked_for(
    capsys: pytest.CaptureFixture[str], mixed: Path, tmp_path: Path
) -> None:
    data = mixed.read_bytes().replace(b"replay/graph/mixed.yaml", b"replay/graph/moved.yaml")
    log = tmp_path / "moved.ulg"
    log.write_bytes(sealed(data))
    error = refusal(capsys, log)
    assert "missing graph 'tests/codegen/replay/graph/moved.yaml' of this recording" in error
    assert "hint: add --graph FILE" in error


# --- logs that are not whole ---


def messages(data: bytes) -> list[tuple[int, int]]:
    """Begin and end of each message."""
    found, at = [], 16
    while at < len(data):
        end = at + 3 + int.from_bytes(data[at : at + 2], "little")
        found.append((at, end))
        at = end
    return found


def is_check(data: bytes, begin: int) -> bool:
    return data[begin + 2] == ord("X") and data[begin + 3] == 0x30


def sealed(data: bytes) -> bytes:
    """With the checks that belong to what the log says now."""
    result, covered_from = bytearray(data), 0
    for begin, end in messages(data):
        if is_check(data, begin):
            result[begin + 4 : end] = zlib.crc32(result[covered_from : begin + 4]).to_bytes(
                4, "little"
            )
            covered_from = end
    return bytes(result)


def test_a_gap_ends_the_replay_and_is_reported(
    capsys: pytest.CaptureFixture[str], mixed: Path, tmp_path: Path
) -> None:
    data = mixed.read_bytes()
    middle = len(data) // 2
    begin = next(b for b, _ in messages(data) if b > middle and is_check(data, b))
    gap = bytes([5, 0, ord("X"), 0x20 | 5, 17, 0, 0, 0])
    # From the gap on, the level is silent.
    rest = b"".join(
        data[b:e] for b, e in messages(data) if b >= begin and data[b + 2 : b + 4] != b"X\x05"
    )
    log = tmp_path / "gap.ulg"
    log.write_bytes(sealed(data[:begin] + gap + rest))
    replayed = replay(capsys, log)
    assert not replayed["equal"]
    assert "the recording has a gap: level 5 lost 17 activations" in replayed["reason"]
    assert all(replayed["topics"].values())  # nothing differs up to there
    assert replayed["ends_early"]
    assert 1.5 < replayed["replayed_until_s"] < 2.5


@pytest.mark.parametrize("part", [0.0003, 0.2, 0.5, 0.9])
def test_a_flipped_byte_is_reported(
    capsys: pytest.CaptureFixture[str], mixed: Path, tmp_path: Path, part: float
) -> None:
    data = bytearray(mixed.read_bytes())
    data[int(part * len(data))] ^= 0x10
    log = tmp_path / "flipped.ulg"
    log.write_bytes(data)
    if part < 0.01:  # among the definitions, which come first
        assert "error: cannot replay" in refusal(capsys, log)
        return
    replayed = replay(capsys, log)
    assert not replayed["equal"]
    assert "the log is damaged: it is" in replayed["reason"]
    assert all(replayed["topics"].values())
    assert replayed["replayed_until_s"] < 4.0 * part + 0.5


def test_a_torn_log_is_reported(
    capsys: pytest.CaptureFixture[str], mixed: Path, tmp_path: Path
) -> None:
    data = mixed.read_bytes()
    begin, end = next((b, e) for b, e in messages(data) if b > len(data) // 2 and e - b > 20)
    log = tmp_path / "torn.ulg"
    log.write_bytes(data[: (begin + end) // 2])
    replayed = replay(capsys, log)
    assert not replayed["equal"]
    assert f"it is incomplete or damaged at byte {begin}" in replayed["reason"]


def test_a_log_without_recording_is_refused(
    capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    log = tmp_path / "plain.ulg"
    flown(QUAD, log, variant={})
    error = refusal(capsys, log)
    assert "missing recording in" in error
    assert "--no-record" in error


def test_other_files_are_refused(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    assert "cannot read" in refusal(capsys, tmp_path / "nothing.ulg")
    assert "expected a flight log (ULog)" in refusal(capsys, MIXED)
