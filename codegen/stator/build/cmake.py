"""Builds the executable of a graph with CMake: one build folder for each graph and board."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
from typing import TYPE_CHECKING

from stator import HOME
from stator.diagnostics import BuildFailed, shown_path
from stator.pipeline import make_buildable_plan

if TYPE_CHECKING:
    from collections.abc import Mapping
    from pathlib import Path

    from stator.plan.plan import Plan

PREEMPTION = {"STATOR_PREEMPTION_POINTS": "ON"}  # for runs in which activations take time
RECORDING = {"STATOR_RECORDING": "ON"}  # each flight is recorded in its log, for replay
PLAIN = {"STATOR_COUNTERS": "OFF"}  # nothing is timed of an activation
SLEEP = {"STATOR_SLEEP": "ON"}  # on bare metal: sleeps when idle, instead of spinning
TOOLCHAIN = HOME / "codegen" / "cmake" / "cortex_m4f.cmake"
INSTEAD = {"virtual": "./stator fly", "cortex_m": "./stator emulate", "pthread": "./stator run"}


def build(
    graph: Path,
    board: str | None,
    variant: Mapping[str, str] | None = None,
    *,
    executor: str = "",
) -> Path:
    """The executable of the graph on this board (its own if None), built anew where needed.
    `variant`: CMake variables that differ from the defaults, such as another compiler. `executor`:
    the only one that will do.

    Raises `Failed` for an error in the graph, `BuildFailed` for one in the code.
    """
    plan = make_buildable_plan(str(graph), board)
    variant = variant or {}
    bare = plan.board.executor == "cortex_m"
    if executor and plan.board.executor != executor:
        instead = INSTEAD.get(plan.board.executor)
        raise BuildFailed(
            f"error: board '{plan.board.name}' runs on the executor {plan.board.executor}, "
            f"not {executor}" + (f"\nhint: {instead} flies it" if instead else "")
        )
    if not any(plan.board.file.parent.glob("*.cpp")):
        raise BuildFailed(
            f"error: board '{plan.board.name}' has no code yet, only its description\n"
            f"hint: build for another one, such as qemu_f405, or write its board.cpp in "
            f"{shown_path(plan.board.file.parent)}"
        )
    names = [key if value == "ON" else f"{key}_{value}" for key, value in variant.items()]
    words = [plan.graph.name, plan.board.name, *(re.sub(r"\W+", "_", name) for name in names)]
    name = "-".join(word.strip("_") for word in words)
    options = [
        f"-DSTATOR_GRAPH={plan.graph.file}",
        f"-DSTATOR_BOARD={plan.board.name}",
        "-DSTATOR_TESTS=OFF",
        *([f"-DCMAKE_TOOLCHAIN_FILE={TOOLCHAIN}"] if bare else []),
        *(f"-D{key}={value}" for key, value in variant.items()),
    ]
    _one_line(f"building {name} ...")
    folder = HOME / "build" / name
    configure(folder, options, ["graph_program"])
    return folder / ("graph_program.elf" if bare else "graph_program")


def build_replay(plan: Plan) -> Path:
    """The program that replays recordings of the graph on this machine. Raises `BuildFailed`."""
    name = f"{plan.graph.name}-{plan.board.name}-replay"
    options = [
        f"-DSTATOR_GRAPH={plan.graph.file}",
        f"-DSTATOR_BOARD={plan.board.name}",
        "-DSTATOR_TESTS=OFF",
        "-DSTATOR_REPLAY=ON",
    ]
    _one_line(f"building {name} ...")
    folder = HOME / "build" / name
    configure(folder, options, ["graph_program"])
    return folder / "graph_program"


def build_plant() -> Path:
    """The simulated world that emulated firmware flies in, as a program of this machine."""
    folder = HOME / "build" / "plant"
    configure(folder, ["-DSTATOR_TESTS=OFF"], ["plant_server"])
    return folder / "boards" / "qemu_f405" / "plant" / "plant_server"


def configure(folder: Path, options: list[str], targets: list[str]) -> None:
    """Configures a build folder where needed, and builds the targets. Raises `BuildFailed`."""
    existing = next(path for path in (folder, *folder.parents) if path.exists())
    if not os.access(existing, os.W_OK):
        raise BuildFailed(
            f"error: cannot write in '{shown_path(existing)}', where the build goes\n"
            "hint: it belongs to somebody else; make a clone of your own"
        )
    # Written last: another graph of the same name, or an interrupted first configuration, which
    # leaves a folder that CMake would not try again, begins anew.
    stamp = folder / "options.txt"
    arguments = [*options, f"-DSTATOR_PYTHON={sys.executable}"]
    # CMake remembers what an earlier toolchain file said.
    text = "\n".join([*arguments, TOOLCHAIN.read_text(encoding="utf-8")])
    if not stamp.is_file() or stamp.read_text(encoding="utf-8") != text:
        shutil.rmtree(folder, ignore_errors=True)
        _run(["cmake", "-S", str(HOME), "-B", str(folder), "-G", "Ninja", *arguments])
        stamp.write_text(text, encoding="utf-8")
    _run(["cmake", "--build", str(folder), "--target", *targets])


def _one_line(text: str) -> None:
    if sys.stderr.isatty():
        print(f"\r{text}", end="\r", file=sys.stderr, flush=True)


def _run(command: list[str]) -> None:
    result = subprocess.run(command, check=False, capture_output=True, text=True)
    if result.returncode != 0:
        lines = (result.stdout + result.stderr).splitlines()
        first = next((i for i, line in enumerate(lines) if "error" in line.lower()), 0)
        shown = "\n".join(lines[max(0, first - 2) : first + 40])
        raise BuildFailed(
            f"{shown}\nerror: the build failed\nhint: the whole output: "
            + " ".join(f"'{part}'" if " " in part else part for part in command)
        )
