"""Format and static checks, for `./stator lint` and for the tests, which run each one."""

import importlib.util
import json
import os
import re
import subprocess
import sys
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path

from stator.build.cmake import lock_of
from stator.lock import held
from stator.processes import environment

# Not formatted: build output, and the expected output of the generator.
SKIPPED_FOLDERS = {"build", "golden", "__pycache__"}
TIDY_FOLDER = Path("build") / "lint"
# Graph and board of programs that together contain all code for this machine, and a replay program.
# Not bare metal: clang has no C++ library for it here.
TIDY_PROGRAMS = {
    "quad": ("quad", "sitl"),
    "outdoor": ("quad_outdoor", "sitl"),
    "can": ("quad_can", "linux"),
    "attitude": ("attitude_recording", "playback"),
    "navigation": ("navigation_recording", "playback"),
    "replay": ("quad", "sitl", "-DSTATOR_REPLAY=ON"),
}


@dataclass(frozen=True)
class Check:
    """`run` returns the problems as text; `fixer` is the command that repairs them, if any."""

    run: Callable[[Path], str]
    fixer: Callable[[Path], list[str]] | None = None
    long: bool = False


def cpp_files(root: Path) -> Iterator[Path]:
    for folder, folders, files in os.walk(root):
        folders[:] = sorted(f for f in folders if f not in SKIPPED_FOLDERS and f[0] != ".")
        yield from (Path(folder) / f for f in sorted(files) if f.endswith((".cpp", ".hpp")))


def output(command: list[str], root: Path) -> str:
    """The output of a command that failed; empty if it succeeded."""
    finished = subprocess.run(
        command,
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        errors="replace",
        cwd=root,
        env=environment(),
        check=False,
    )
    failed = finished.returncode != 0
    return (finished.stdout.strip() or f"{command[0]} failed") if failed else ""


def _module(*arguments: str) -> list[str]:
    return [sys.executable, "-I", "-X", "utf8", "-m", *arguments]


def _clang_format(*arguments: str) -> Callable[[Path], list[str]]:
    def command(root: Path) -> list[str]:
        package = importlib.util.find_spec("clang_format")
        assert package is not None and package.origin is not None  # pinned in requirements.txt
        program = Path(package.origin).parent / "data" / "bin" / "clang-format"
        return [str(program), *arguments, *(str(p.relative_to(root)) for p in cpp_files(root))]

    return command


def _run(command: Callable[[Path], list[str]]) -> Callable[[Path], str]:
    return lambda root: output(command(root), root)


def clang_format(root: Path) -> str:
    """One line for each file, without positions, because one command repairs all of them."""
    found = output(_clang_format("--dry-run", "--Werror")(root), root)
    files = re.findall(r"^(\S.*?):\d+:\d+: ", found, flags=re.M)
    return "\n".join(f"would reformat: {file}" for file in dict.fromkeys(files)) or found


def _python(*arguments: str) -> Callable[[Path], list[str]]:
    return lambda _: _module(*arguments)


def clang_tidy(root: Path) -> str:
    """Checks all code except tests, which the compilers' warnings check."""
    with held(lock_of(root / TIDY_FOLDER), "runs clang-tidy"):
        return _clang_tidy(root)


def _clang_tidy(root: Path) -> str:
    own = set(cpp_files(root))
    folder_of: dict[Path, Path] = {}
    for name, (graph, board, *options) in TIDY_PROGRAMS.items():
        folder = root / TIDY_FOLDER / name
        problem = _configure_tidy(root, folder, graph, board, options)
        database = folder / "compile_commands.json"
        if not database.exists():
            return problem
        for entry in json.loads(database.read_text(encoding="utf-8")):
            file = (Path(entry["directory"]) / entry["file"]).resolve()
            if file in own:
                folder_of.setdefault(file, folder)

    def check(file: Path) -> str:
        command = ["clang-tidy", "--quiet", "-p", str(folder_of[file]), str(file)]
        return output([*command, "--warnings-as-errors=*"], root)

    with ThreadPoolExecutor(os.cpu_count()) as pool:
        found = list(pool.map(check, sorted(folder_of)))
    return re.sub(r"^\d+ warnings? generated\.\n", "", "\n".join(filter(None, found)), flags=re.M)


def _configure_tidy(root: Path, folder: Path, graph: str, board: str, options: list[str]) -> str:
    """A build folder for clang-tidy alone: it cannot read gcc's precompiled headers."""
    command = ["cmake", "-S", ".", "-B", str(folder), "-G", "Ninja", "-DSTATOR_TESTS=OFF"]
    command += ["-DCMAKE_DISABLE_PRECOMPILE_HEADERS=ON", f"-DSTATOR_BOARD={board}", *options]
    command += [f"-DSTATOR_GRAPH={root / 'graph' / graph}.yaml"]
    return output(command, root) or output(
        [
            "cmake",
            "--build",
            str(folder),
            "--target",
            "stator_dronecan_codecs",
            "stator_mavlink_codecs",
            "plant_devices",
        ],
        root,
    )


CHECKS = {
    "clang-format": Check(clang_format, fixer=_clang_format("-i")),
    "ruff check": Check(
        _run(_python("ruff", "check", "--quiet", "--output-format", "concise", ".")),
        fixer=_python("ruff", "check", "--quiet", "--fix", "."),
    ),
    "ruff format": Check(
        _run(_python("ruff", "format", "--check", "--output-format", "concise", ".")),
        fixer=_python("ruff", "format", "--quiet", "."),
    ),
    "mypy": Check(
        _run(_python("mypy", "--no-error-summary", "codegen/stator", "codegen/bootstrap.py"))
    ),
    "clang-tidy": Check(clang_tidy, long=True),
}
