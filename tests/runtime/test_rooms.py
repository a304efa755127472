"""The rooms of the runtime: each includes only what its row allows, and no header hides another."""

import json
import re
import shlex
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
RUNTIME = ROOT / "runtime"
# What a room may include, besides itself. The README of each says the same.
MAY_USE = {
    "bytes": (),
    "math": (),
    "dronecan": (),
    "mavlink": (),
    "recording": ("bytes",),
    "core": ("host",),
    "testing": ("core",),
    "watch": ("core",),
    "host": (),
    "parameters": ("core", "bytes"),
    "link": ("core", "watch", "bytes"),
    "log": ("core", "watch", "parameters", "recording", "bytes"),
    "machines": ("core", "link", "bytes"),
    "virtual": ("core", "watch", "host"),
    "pthread": ("core", "watch", "link", "host"),
    "cortex_m": ("core", "watch", "link", "bytes"),
    "replay": ("parameters", "bytes", "host"),
}
# Each build has one of each on its path: of its executor, and of what it is built for.
SUPPLIED = {f"stator/{name}.hpp" for name in ("executor", "topic", "activation", "tap", "port")}
BUILDS = {
    "virtual": ("quad", "sitl", ""),
    "recorded": ("quad", "sitl", "-DSTATOR_RECORDING=ON"),
    "pthread": ("quad", "linux", ""),
    "replay": ("quad", "sitl", "-DSTATOR_REPLAY=ON"),
    "playback": ("attitude_recording", "playback", "-DSTATOR_RECORDING=ON"),
}


def files(room: str) -> list[Path]:
    return [file for suffix in ("hpp", "cpp") for file in (RUNTIME / room).rglob(f"*.{suffix}")]


def includes() -> Iterator[tuple[Path, str, str]]:
    """File, its room, and what it includes of Stator's."""
    for room in MAY_USE:
        for file in files(room):
            for name in re.findall(r'^#include "(stator/.+)"', file.read_text(), re.MULTILINE):
                yield file.relative_to(RUNTIME), room, name


def test_each_room_has_a_row() -> None:
    assert {folder.name for folder in RUNTIME.iterdir() if folder.is_dir()} == set(MAY_USE)


def test_no_room_includes_what_it_may_not() -> None:
    homes: dict[str, set[str]] = {}
    for room in MAY_USE:
        for file in files(room):
            name = file.as_posix().rpartition("/stator/")[2]
            homes.setdefault(f"stator/{name}", set()).add(room)
    wrong = [
        f"{file} includes {name}"
        for file, room, name in includes()
        if name not in SUPPLIED and not homes.get(name, set()) & {room, *MAY_USE[room]}
    ]
    assert wrong == []


@pytest.mark.parametrize("build", BUILDS)
def test_no_header_hides_another(build: str, tmp_path: Path) -> None:
    """Of each translation unit: no name below two folders of its path."""
    graph, board, option = BUILDS[build]
    command = ["cmake", "-S", ROOT, "-B", tmp_path, "-G", "Ninja", f"-DSTATOR_BOARD={board}"]
    command += [f"-DSTATOR_GRAPH={ROOT / 'graph' / graph}.yaml", "-DSTATOR_TESTS=OFF"]
    command += [f"-DSTATOR_PYTHON={sys.executable}"]
    finished = subprocess.run(
        [*command, *filter(None, [option])], check=False, capture_output=True, text=True
    )
    assert finished.returncode == 0, finished.stderr
    hidden = set()
    for row in json.loads((tmp_path / "compile_commands.json").read_text()):
        words = shlex.split(row["command"])
        ways = [re.match("-(?:I|iquote)(.+)", word) for word in words]
        folders = {Path(way[1]).resolve() for way in ways if way}
        found: dict[Path, Path] = {}
        for folder in sorted(folders):
            # The root is there for apps/ and drivers/ only; what is built below it comes and goes.
            tops = [ROOT / "apps", ROOT / "drivers"] if folder == ROOT else [folder]
            for header in (file for top in tops for file in top.rglob("*.hpp")):
                name = header.relative_to(folder)
                if name in found:
                    hidden.add(f"{name} in {found[name]} and {folder}")
                found[name] = folder
    assert hidden == set()
