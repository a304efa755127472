"""Each way in which firmware fails in flight: the next start tells what it was, and who did it."""

from __future__ import annotations

from pathlib import Path

import pytest
from tests.emulation.firmware_tools import needs_emulator

from stator import HOME
from stator.build.cmake import NO_WALLS, build, build_plant
from stator.emulator.qemu import fly
from stator.live.fault_record import FaultRecord, active_tasks, explain, records_in
from stator.pipeline import make_plan
from stator.plan.plan import Plan

GRAPH = HOME / "tests" / "emulation" / "faults" / "faults.yaml"
MEM_MANAGE, BUS_FAULT, USAGE_FAULT = 4, 5, 6
BEGIN_US = 10_000  # of the wrecker


@pytest.fixture(scope="module")
def image() -> Path:
    needs_emulator()
    return build(GRAPH, None, NO_WALLS, executor="cortex_m")


@pytest.fixture(scope="module")
def plan() -> Plan:
    return make_plan(str(GRAPH), None)


def run(image: Path, folder: Path, told: str) -> list[FaultRecord]:
    """What each start of the firmware told of the run before."""
    plant = [str(build_plant()), "--duration", "2"]
    finished = fly(needs_emulator(), image, plant, folder / "flight.ulg", argument=told)
    return records_in(finished.stderr)


# Status bits: DDI 0403E, B3.2.15.
@pytest.mark.parametrize(
    ("told", "exception", "status", "words"),
    [
        ("null", MEM_MANAGE, 0x82, "accessed 0x00000004 through a null pointer"),
        ("code", MEM_MANAGE, 0x82, "wrote to 0x08001000, which is code"),
        ("data", MEM_MANAGE, 0x01, "executed data that is not code"),
        ("divide", USAGE_FAULT, 0x02000000, "divided by zero"),
    ],
)
def test_a_fault_is_told_by_the_next_start(
    image: Path, plan: Plan, tmp_path: Path, told: str, exception: int, status: int, words: str
) -> None:
    records = run(image, tmp_path, told)
    assert len(records) == 1
    record = records[0]
    assert (record.exception, record.status) == (exception, status)
    assert [task.node.name for task in active_tasks(record, plan)] == ["wrecker"]
    assert BEGIN_US <= record.uptime_us < BEGIN_US + 1_000
    lines = explain(record, plan, image)
    assert lines[0] == f"error: the firmware ended in task wrecker: {words}"


def test_the_last_activations_are_told(image: Path, plan: Plan, tmp_path: Path) -> None:
    (record,) = run(image, tmp_path, "divide")
    names = [plan.tasks[task].node.name for _, task in record.activations]
    # At 10 ms, from the newest on; the milliseconds before had a beat only.
    assert names == ["wrecker", *["heart", "source"] * 11]


def test_a_full_stack_is_told(image: Path, plan: Plan, tmp_path: Path) -> None:
    (record,) = run(image, tmp_path, "stack")
    assert record.exception == MEM_MANAGE
    assert "stack overflow" in explain(record, plan, image)[0]
    assert [task.node.name for task in active_tasks(record, plan)] == ["wrecker"]


def test_a_failed_assertion_is_told(image: Path, plan: Plan, tmp_path: Path) -> None:
    (record,) = run(image, tmp_path, "assertion")
    assert record.what == "the wrecker was told to fail"
    assert explain(record, plan, image)[0].endswith("wrecker: the wrecker was told to fail")


def test_a_task_that_never_ends_is_reset_and_told(image: Path, plan: Plan, tmp_path: Path) -> None:
    (record,) = run(image, tmp_path, "endless")
    lines = explain(record, plan, image)
    assert (
        lines[0] == "error: the firmware ended in task wrecker: the watchdog was not reset in time"
    )
    assert any("never_end" in line for line in lines)
    assert record.silent_task is None  # the monitor had no more turn
    assert record.uptime_us < 201_000  # two periods of the watchdog


def test_a_task_that_is_no_longer_released_is_told(image: Path, plan: Plan, tmp_path: Path) -> None:
    (record,) = run(image, tmp_path, "silence")
    lines = explain(record, plan, image)
    assert lines[0] == "error: the firmware ended outside tasks: the watchdog was not reset in time"
    assert lines[1] == "  missing life sign of task heart"
    assert 70_000 < record.uptime_us <= 300_000  # silent from 50 ms on, noticed 20 ms later


def test_firmware_that_does_nothing_wrong_flies_on(image: Path, tmp_path: Path) -> None:
    assert run(image, tmp_path, "nothing") == []


def test_three_resets_in_a_row_end_in_safe_mode(image: Path, tmp_path: Path) -> None:
    """After which the firmware runs no task, and the board of the emulator ends."""
    records = run(image, tmp_path, "divide restart")
    assert [record.resets for record in records] == [1, 2, 3]


def test_the_record_names_its_build(image: Path, tmp_path: Path) -> None:
    (record,) = run(image, tmp_path, "divide")
    note = image.read_bytes()
    assert bytes.fromhex(record.build_id) in note
    assert len(set(record.build_id)) > 1
