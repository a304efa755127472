"""Builds the executable of a graph with CMake: one build folder for each graph and board."""

from __future__ import annotations

import hashlib
import os
import re
import shutil
import signal
import subprocess
import sys
from pathlib import Path
from typing import TYPE_CHECKING

from stator import HOME
from stator.build.compile_errors import errors_in, kept
from stator.build.contents import by_content
from stator.build.paths import check_paths, input_paths
from stator.diagnostics import BuildFailed, shown_path
from stator.lock import Held, Line, held, held_if_free
from stator.pipeline import make_buildable_plan
from stator.processes import environment, start

if TYPE_CHECKING:
    from collections.abc import Mapping

    from stator.plan.plan import Plan

PREEMPTION = {"STATOR_PREEMPTION_POINTS": "ON"}  # activations take time, so others can preempt
RECORDING = {"STATOR_RECORDING": "ON"}  # the log of each flight contains a recording
DEBUG = {"STATOR_DEBUG": "ON"}  # for a debugger
SANITIZE = {"STATOR_SANITIZE": "address,undefined"}
PLAIN = {"STATOR_COUNTERS": "OFF"}  # activations are not timed
NO_WALLS = {"STATOR_WALLS": "OFF"}  # for tests whose nodes look outside
SLEEP = {"STATOR_SLEEP": "ON"}  # bare metal sleeps when idle (default: busy loop)
TOOLCHAIN = HOME / "codegen" / "cmake" / "cortex_m4f.cmake"
STEP = re.compile(r"\[(\d+)/(\d+)\] ")  # ninja's progress
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
    words = [short_name(plan.graph.file), plan.board.name]
    words += [re.sub(r"\W+", "_", name) for name in names]
    name = "-".join(word.strip("_") for word in words)
    options = [
        f"-DSTATOR_GRAPH={plan.graph.file}",
        f"-DSTATOR_BOARD={plan.board.name}",
        "-DSTATOR_TESTS=OFF",
        *([f"-DCMAKE_TOOLCHAIN_FILE={TOOLCHAIN}"] if bare else []),
        *(f"-D{key}={value}" for key, value in variant.items()),
    ]
    check_paths(input_paths(plan))
    folder = HOME / "build" / name
    configure(folder, options, ["graph_program"])
    return folder / ("graph_program.elf" if bare else "graph_program")


def build_replay(plan: Plan) -> Path:
    """Builds the program that replays recordings of the graph. Raises `BuildFailed`."""
    name = f"{short_name(plan.graph.file)}-{plan.board.name}-replay"
    options = [
        f"-DSTATOR_GRAPH={plan.graph.file}",
        f"-DSTATOR_BOARD={plan.board.name}",
        "-DSTATOR_TESTS=OFF",
        "-DSTATOR_REPLAY=ON",
    ]
    check_paths(input_paths(plan))
    folder = HOME / "build" / name
    configure(folder, options, ["graph_program"])
    return folder / "graph_program"


def build_plant() -> Path:
    """Builds the simulated world of emulated firmware, as a program of this machine."""
    folder = HOME / "build" / "plant"
    configure(folder, ["-DSTATOR_TESTS=OFF"], ["plant_server"])
    return folder / "boards" / "qemu_f405" / "plant" / "plant_server"


def build_pixhawk() -> Path:
    """Builds the Pixhawk around the emulated chip, as a program of this machine."""
    folder = HOME / "build" / "plant"
    configure(folder, ["-DSTATOR_TESTS=OFF"], ["pixhawk_server"])
    return folder / "boards" / "fmu_v2" / "plant" / "pixhawk_server"


def build_hil_simulator() -> Path:
    """Builds the simulated world of another autopilot."""
    folder = HOME / "build" / "plant"
    configure(folder, ["-DSTATOR_TESTS=OFF"], ["hil_simulator"])
    return folder / "boards" / "hil" / "hil_simulator"


def short_name(file: Path) -> str:
    """The name of a graph or mission; with a hash of its place if it is not one of Stator's own, as
    another project may have one of the same name."""
    if file.parent in (HOME / "graph", HOME / "graph" / "missions"):
        return file.stem
    return f"{file.stem}-{hashlib.sha256(os.fsencode(file)).hexdigest()[:8]}"


def lock_of(folder: Path) -> Path:
    """Who has this lock may configure and build in the folder."""
    return HOME / "build" / "locks" / folder.name


def configure(folder: Path, options: list[str], targets: list[str]) -> None:
    """Configures the build folder if needed, and builds the targets. Waits while another command
    does that. Raises `BuildFailed`."""
    check_paths([HOME])
    existing = next(path for path in (folder, *folder.parents) if path.exists())
    if not os.access(existing, os.W_OK):
        raise BuildFailed(
            f"error: cannot write to the build folder '{shown_path(existing)}'\n"
            "hint: the folder belongs to another user; work in your own clone"
        )
    with held(lock_of(folder), f"builds {folder.name}") as lock:
        # Written last. CMake does not repeat an interrupted first configuration, so the folder is
        # removed if the stamp is missing or has other options.
        stamp = folder / "options.txt"
        arguments = [*options, f"-DSTATOR_PYTHON={sys.executable}"]
        # CMake keeps the settings of an earlier toolchain file, and the programs that it found.
        text = "\n".join([*arguments, *_tools(options), TOOLCHAIN.read_text(encoding="utf-8")])
        content = os.fsencode(text)
        with by_content(folder):
            if not stamp.is_file() or stamp.read_bytes() != content:
                shutil.rmtree(folder, ignore_errors=True)
                _remove_orphans()
                _run(["cmake", "-S", str(HOME), "-B", str(folder), "-G", "Ninja", *arguments], lock)
                stamp.write_bytes(content)
            if targets:
                _run(["cmake", "--build", str(folder), "--target", *targets], lock)


def _remove_orphans() -> None:
    """Build folders of graphs that are there no more, such as those of projects that moved."""
    for stamp in (HOME / "build").glob("*/options.txt"):
        first = os.fsdecode(stamp.read_bytes()).partition("\n")[0]
        if (
            first.startswith(("-DSTATOR_GRAPH=", "-DSTATOR_PROJECT="))
            and not Path(first.partition("=")[2]).exists()
        ):
            with held_if_free(lock_of(stamp.parent)) as is_free:
                if is_free:
                    shutil.rmtree(stamp.parent, ignore_errors=True)


def _tools(options: list[str]) -> list[str]:
    """The paths of the programs that a build takes from PATH; of compilers also size and time."""
    named = [o.partition("=")[2] for o in options if o.startswith("-DCMAKE_CXX_COMPILER=")]
    compilers = [*named, "c++", "g++", "arm-none-eabi-g++"]
    lines = [f"{name}: {shutil.which(name)}" for name in ("cmake", "ninja", "ccache")]
    for name in compilers:
        found = shutil.which(name)
        if found is not None:
            state = Path(found).stat()
            lines.append(f"{os.path.realpath(found)}: {state.st_size} {state.st_mtime_ns}")
    return lines


def _run(command: list[str], lock: Held) -> None:
    """In a group of processes of its own, which inherits the lock and ends with this one."""
    folder = Path(command[command.index("--build" if "--build" in command else "-B") + 1])
    verbose = os.environ.get("STATOR_VERBOSE") == "on"
    if verbose and "--build" in command:
        command = [*command, "--verbose"]
    line = Line()
    output: list[str] = []
    with start(
        command,
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        errors="replace",
        env=environment(),
        pass_fds=(lock.fileno(),),
        process_group=0,
    ) as process:
        try:
            for text in process.stdout or ():
                if verbose:
                    print(text, end="", file=sys.stderr)
                step = STEP.match(text)
                if step is None:
                    output.append(text.rstrip("\n"))
                    continue
                progress = f"step {step[1]} of {step[2]}"
                if not verbose:
                    line.show(f"building {folder.name}: {progress}")
                lock.tell(progress)
        except BaseException:
            os.killpg(process.pid, signal.SIGTERM)
            raise
    line.clear()
    if process.returncode != 0:
        text = "\n".join(output)
        shown = errors_in(text, folder) or _first_error(text)
        raise BuildFailed(f"{shown}\n\nerror: the build failed{kept(text, folder)}")


def _first_error(output: str) -> str:
    """Of CMake or the linker, for example; without the long command that ninja repeats."""
    text = re.sub(r"^FAILED: .*\n.*\n", "", output, flags=re.MULTILINE)
    lines = text.replace(f"{Path.cwd()}/", "").splitlines()
    first = next((i for i, line in enumerate(lines) if "error" in line.lower()), 0)
    return "\n".join(lines[max(0, first - 2) : first + 40])
