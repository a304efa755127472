"""Dispatchers of shared lines, timers and modes on bare metal: what runs, when, in which order."""

from __future__ import annotations

import subprocess

from tests.emulation.firmware_tools import needs_emulator

from stator import HOME
from stator.build.cmake import NO_WALLS, build
from stator.emulator.qemu import qemu_command

GRAPH = HOME / "tests" / "emulation" / "graphs" / "order.yaml"
LIMIT_S = 600  # of a program that takes milliseconds; on a hang
# A blank is a whole millisecond of the board, whose clock starts a little after the graph. Letters
# are nodes (graphs/order.yaml); ^ and _ are lines, a point the timer, M a switch of modes.
EXPECTED = [
    "e",  # at 0 ms: mode one
    "",
    "a^;cd",  # one line; readers in the order of their level
    "a^_;cde",  # both lines in one activation; at 4 ms `before`
    "a.;cd",  # at 5 ms the timer of the same task
    "",
    "b^;M",  # the other task of the vector; its reader switches
    "f",  # at 8 ms the node of mode two, and not the other
    "",
    "",
    "a^;cdb^;M",  # both tasks of one vector: the more urgent one, its readers, then the other
    "e",  # at 12 ms mode one again
    "",
    "",
    "a.;cd",
    "e",
    "",
    "",
]


def test_what_runs_and_in_which_order() -> None:
    emulator = needs_emulator()
    image = build(GRAPH, None, NO_WALLS, executor="cortex_m")
    finished = subprocess.run(
        qemu_command(emulator, image), capture_output=True, text=True, timeout=LIMIT_S, check=False
    )
    assert finished.returncode == 0
    assert (finished.stdout + finished.stderr).split(" ") == EXPECTED
