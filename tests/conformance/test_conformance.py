"""The same graphs, and one expected trace, on all executors."""

from __future__ import annotations

import functools
import re
import subprocess

import pytest
from tests.conformance.expected import SCENARIOS
from tests.emulation.firmware_tools import needs_emulator

from stator import HOME
from stator.build.cmake import NO_WALLS, build
from stator.emulator.qemu import qemu_command
from stator.pipeline import make_plan

GRAPH = HOME / "tests" / "conformance" / "graphs" / "conformance.yaml"
BOARDS = ("virtual", "threads", "qemu")
LIMIT_S = 600  # of a program that takes half a second; on a hang
LATE = 3  # status of boards/threads: the machine held up a level, and the trace says nothing
MAX_RUNS = 40


@pytest.mark.parametrize("scenario", SCENARIOS)
@pytest.mark.parametrize("board", BOARDS)
def test_every_executor_does_the_same(board: str, scenario: str) -> None:
    wanted = SCENARIOS[scenario]
    seen = [line for line in _trace(board) if _node(line) in wanted.nodes]
    expected = _expanded(wanted.trace)
    if board == "threads":
        # Levels run at once: nothing is said about the order of lines of different levels.
        level = _levels()
        for one in sorted({level[name] for name in wanted.nodes}):
            assert _of_level(seen, level, one) == _of_level(expected, level, one)
    else:
        assert seen == expected


@functools.cache
def _trace(board: str) -> list[str]:
    """Of one run; lines with the names of nodes for their numbers."""
    finished = _run(board)
    text = finished.stdout + finished.stderr  # the emulator's console
    if finished.returncode == LATE:
        pytest.fail(
            f"in each of {MAX_RUNS} runs a level was late, or still busy when the next step "
            "began: the machine is overloaded, or a wake-up got lost"
        )
    assert finished.returncode == 0, text
    nodes = make_plan(str(GRAPH), board).graph.nodes.values()
    name_of = {str(node.params["id"]): node.name for node in nodes}
    return re.sub(r"#(\d+)", lambda number: name_of[number[1]], text).splitlines()


@functools.cache
def _run(board: str) -> subprocess.CompletedProcess[str]:
    """The first run that was not late, or else the last one."""
    emulator = needs_emulator() if board == "qemu" else None
    program = build(GRAPH, board, NO_WALLS)
    command = qemu_command(emulator, program) if emulator else [str(program)]
    for _ in range(MAX_RUNS):
        finished = subprocess.run(
            command, capture_output=True, text=True, timeout=LIMIT_S, check=False
        )
        if finished.returncode != LATE:
            break
    return finished


@functools.cache
def _levels() -> dict[str, int]:
    plan = make_plan(str(GRAPH), "threads")
    return {task.node.name: task.level for task in plan.tasks}


def _node(line: str) -> str:
    """Of "40 +low 2 c=high.1*"."""
    return line.split(" ")[1].lstrip("+-")


def _of_level(lines: list[str], level: dict[str, int], one: int) -> list[str]:
    return [line for line in lines if level[_node(line)] == one]


def _expanded(text: str) -> list[str]:
    """A line without a sign is an activation that nothing interrupts: its begin and its end."""
    lines: list[str] = []
    for line in text.splitlines():
        time, what = line.split(" ", 1)
        if what[0] in "+-":
            lines.append(line)
        else:
            lines += [f"{time} +{what}", f"{time} -{_node(line)}"]
    return lines
