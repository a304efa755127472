"""Builds the executable of a graph with CMake: one build folder for each graph and board."""

from __future__ import annotations

import shutil
import subprocess
import sys
from pathlib import Path

from stator.cli import make_plan
from stator.library import HOME


class BuildFailed(Exception):
    """CMake or the compiler failed; the message is what they said."""


TOOLCHAIN = HOME / "codegen" / "cmake" / "cortex_m4f.cmake"
INSTEAD = {"virtual": "./stator fly", "cortex_m": "./stator emulate"}


def build(graph: Path, board: str | None, *, executor: str = "", compiler: str = "",
          optimisation: str = "", preemption_points: bool = False, sleep: bool = False) -> Path:
    """The executable of the graph on this board (its own if None), built anew where needed.
    `executor`: the only one that will do. `preemption_points`: for runs in which activations take
    time. `sleep`: on bare metal, sleeps when idle.

    Raises `Failed` for an error in the graph, `BuildFailed` for one in the code.
    """
    plan = make_plan(str(graph), board)
    if executor and plan.board.executor != executor:
        raise BuildFailed(f"error: board '{plan.board.name}' runs on the executor "
                          f"{plan.board.executor}, not {executor}" + _instead(plan.board.executor))
    bare = plan.board.executor == "cortex_m"
    name = f"{plan.graph.name}-{plan.board.name}"
    parts = (compiler, optimisation.strip("-"), "preemption" if preemption_points else "",
             "sleep" if sleep else "")
    variant = "".join(f"-{part}" for part in parts if part)
    options = [f"-DSTATOR_GRAPH={plan.graph.file}", f"-DSTATOR_BOARD={plan.board.name}",
               "-DSTATOR_TESTS=OFF"]
    if bare:
        options.append(f"-DCMAKE_TOOLCHAIN_FILE={TOOLCHAIN}")
    if sleep:
        options.append("-DSTATOR_SLEEP=ON")
    if preemption_points:
        options.append("-DSTATOR_PREEMPTION_POINTS=ON")
    if compiler:
        options.append(f"-DCMAKE_CXX_COMPILER={compiler}")
    if optimisation:
        options.append(f"-DSTATOR_OPTIMIZE={optimisation}")
    _one_line(f"building {name}{variant} ...")
    folder = HOME / "build" / f"{name}{variant}"
    configure(folder, options, ["graph_program"])
    return folder / ("graph_program.elf" if bare else "graph_program")


def build_plant() -> Path:
    """The simulated world that emulated firmware flies in, as a program of this machine."""
    folder = HOME / "build" / "plant"
    configure(folder, ["-DSTATOR_TESTS=OFF"], ["plant_server"])
    return folder / "boards" / "qemu_f405" / "plant" / "plant_server"


def _instead(executor: str) -> str:
    return f"\nhint: {INSTEAD[executor]} flies it" if executor in INSTEAD else ""


def configure(folder: Path, options: list[str], targets: list[str]) -> None:
    """Configures a build folder where needed, and builds the targets. Raises `BuildFailed`."""
    # Written last: another graph of the same name, or an interrupted first configuration, which
    # leaves a folder that CMake would not try again, begins anew.
    stamp = folder / "options.txt"
    text = "\n".join([*options, f"-DSTATOR_PYTHON={sys.executable}"])
    if not stamp.is_file() or stamp.read_text(encoding="utf-8") != text:
        shutil.rmtree(folder, ignore_errors=True)
        _run(["cmake", "-S", str(HOME), "-B", str(folder), "-G", "Ninja", *text.split("\n")])
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
        raise BuildFailed(f"{shown}\nerror: the build failed\nhint: the whole output: "
                          + " ".join(f"'{part}'" if " " in part else part for part in command))
