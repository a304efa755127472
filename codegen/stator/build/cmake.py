"""Builds the executable of a graph with CMake: one build folder for each graph and board."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
from pathlib import Path
from typing import TYPE_CHECKING

from stator import HOME
from stator.diagnostics import BuildFailed, shown_path
from stator.pipeline import make_buildable_plan

if TYPE_CHECKING:
    from collections.abc import Mapping

    from stator.plan.plan import Plan

PREEMPTION = {"STATOR_PREEMPTION_POINTS": "ON"}  # activations take time, so others can preempt
RECORDING = {"STATOR_RECORDING": "ON"}  # the log of each flight contains a recording
PLAIN = {"STATOR_COUNTERS": "OFF"}  # activations are not timed
NO_WALLS = {"STATOR_WALLS": "OFF"}  # for tests whose nodes look outside
SLEEP = {"STATOR_SLEEP": "ON"}  # bare metal sleeps when idle (default: busy loop)
TOOLCHAIN = HOME / "codegen" / "cmake" / "cortex_m4f.cmake"
INSTEAD = {"virtual": "./stator fly", "cortex_m": "./stator emulate", "pthread": "./stator run"}


def build(
    graph: Path,
    board: str | None,
    variant: Mapping[str, str] | None = None,
    *,
    executor: str = "",
) -> Path:
    """Builds the executable of the graph for this board (None: the graph's own).
    `variant`: CMake variables that differ from the defaults, such as another compiler. `executor`:
    the required one; empty: any.

    Raises `Failed` for an error in the graph, `BuildFailed` for one in the code.
    """
    plan = make_buildable_plan(str(graph), board)
    variant = variant or {}
    bare = plan.board.executor == "cortex_m"
    if executor and plan.board.executor != executor:
        instead = INSTEAD.get(plan.board.executor)
        raise BuildFailed(
            f"error: expected a board with executor {executor}, found '{plan.board.name}' with "
            f"{plan.board.executor}" + (f"\nhint: use {instead}" if instead else "")
        )
    if not any(plan.board.file.parent.glob("*.cpp")):
        raise BuildFailed(
            f"error: missing file 'board.cpp' of board '{plan.board.name}'\n"
            f"hint: write it in {shown_path(plan.board.file.parent)}, or build for another board, "
            "for example --board qemu_f405"
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
    """Builds the program that replays recordings of the graph. Raises `BuildFailed`."""
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
    """Builds the simulated world of emulated firmware, as a program of this machine."""
    folder = HOME / "build" / "plant"
    configure(folder, ["-DSTATOR_TESTS=OFF"], ["plant_server"])
    return folder / "boards" / "qemu_f405" / "plant" / "plant_server"


def configure(folder: Path, options: list[str], targets: list[str]) -> None:
    """Configures the build folder if needed, and builds the targets. Raises `BuildFailed`."""
    existing = next(path for path in (folder, *folder.parents) if path.exists())
    if not os.access(existing, os.W_OK):
        raise BuildFailed(
            f"error: cannot write to the build folder '{shown_path(existing)}'\n"
            "hint: the folder belongs to another user; work in your own clone"
        )
    # Written last. CMake does not repeat an interrupted first configuration, so the folder is
    # removed if the stamp is missing, or is that of another graph of the same name.
    stamp = folder / "options.txt"
    arguments = [*options, f"-DSTATOR_PYTHON={sys.executable}"]
    # CMake keeps the settings of an earlier toolchain file, so its text is part of the stamp.
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
        output = (result.stdout + result.stderr).replace(f"{Path.cwd()}/", "")
        # Without the long command that ninja repeats.
        lines = re.sub(r"^FAILED: .*\n.*\n", "", output, flags=re.MULTILINE).splitlines()
        first = next((i for i, line in enumerate(lines) if "error" in line.lower()), 0)
        shown = "\n".join(lines[max(0, first - 2) : first + 40])
        raise BuildFailed(
            f"{shown}\nerror: the build failed\nhint: to see the whole output, run: "
            + " ".join(f"'{part}'" if " " in part else part for part in command)
        )
