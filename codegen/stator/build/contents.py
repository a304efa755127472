"""Content decides what is built. Ninja compares times, so it does not see a file that was restored
with its older time. Such a file gets the present time before the build."""

from __future__ import annotations

import contextlib
import hashlib
import json
import os
import re
import shutil
import subprocess
import time
from pathlib import Path
from typing import TYPE_CHECKING, TypeAlias

from stator.processes import environment

if TYPE_CHECKING:
    from collections.abc import Iterator

STAMP = "contents.json"
WORDS = re.compile(r"(?<!\$) ")  # of a line of ninja, which writes a space in a path as `$ `
UNKNOWN = ""  # the hash of a file that changed while it was built
# What identifies an unchanged file without reading it, and its hash.
State: TypeAlias = tuple[int, int, int]
Known: TypeAlias = dict[str, tuple[State, str]]


@contextlib.contextmanager
def by_content(folder: Path) -> Iterator[None]:
    """Around a build in the folder, also one that fails: what it has compiled counts."""
    known = _refresh(folder)
    begin_ns = time.time_ns()
    before = _log_time(folder)
    try:
        yield
    finally:
        if folder.is_dir() and (not (folder / STAMP).is_file() or _log_time(folder) != before):
            _keep(folder, known, begin_ns)


def _refresh(folder: Path) -> Known:
    """Finds files with other content than at the last build, and makes them look new."""
    stamp = folder / STAMP
    try:
        kept = json.loads(stamp.read_bytes())
        built_ns = kept["built_ns"]
        known: Known = {path: (tuple(state), text) for path, (state, text) in kept["files"].items()}
    except (OSError, ValueError, KeyError, TypeError):
        return {}
    changed = False
    for path, (state, text) in known.items():
        now = _state(path)
        if now is None or now == state:
            continue
        found = _hash(path)
        if found != text and now[0] <= built_ns and not _touch(path):
            shutil.rmtree(folder)  # of another user: build all of it
            return {}
        known[path] = (_state(path) or now, found)
        changed = True
    if changed:  # before the build: if it fails, some of it may be compiled
        _write(stamp, known, built_ns)
    return known


def _keep(folder: Path, known: Known, begin_ns: int) -> None:
    """Remembers what was built."""
    files: Known = {}
    for path in _inputs(folder):
        state = _state(path)
        if state is None:
            continue
        before = known.get(path)
        if before is not None and before[0] == state:
            files[path] = before
        else:
            files[path] = (state, UNKNOWN if state[0] > begin_ns else _hash(path))
    _write(folder / STAMP, files, time.time_ns())


def _inputs(folder: Path) -> Iterator[str]:
    """What the build read, except what it made and what came with the system."""
    inside = f"{folder}/"
    command = ["ninja", "-t", "deps"]
    listed = subprocess.run(
        command, cwd=folder, env=environment(), capture_output=True, text=True, check=False
    ).stdout
    paths = {line.strip() for line in listed.splitlines() if line.startswith("    ")}
    with contextlib.suppress(OSError):
        # Sources, and what CMake and generators read: graphs, interfaces, templates.
        for line in (folder / "build.ninja").read_text(errors="replace").splitlines():
            if line.startswith("build "):
                paths |= {word for word in WORDS.split(line) if word.startswith("/")}
    for path in sorted(paths):
        full = os.path.normpath(folder / re.sub(r"\$(.)", r"\1", path))
        if not full.startswith((inside, "/usr/")):
            yield full


def _state(path: str) -> State | None:
    try:
        found = Path(path).stat()
    except OSError:
        return None
    return found.st_mtime_ns, found.st_ctime_ns, found.st_size


def _hash(path: str) -> str:
    try:
        return hashlib.sha256(Path(path).read_bytes()).hexdigest()
    except OSError:
        return UNKNOWN


def _touch(path: str) -> bool:
    try:
        os.utime(path)
    except OSError:
        return False
    return True


def _log_time(folder: Path) -> int:
    """Ninja's own list of what it ran."""
    state = _state(str(folder / ".ninja_log"))
    return 0 if state is None else state[0]


def _write(stamp: Path, files: Known, built_ns: int) -> None:
    text = json.dumps({"built_ns": built_ns, "files": files}, separators=(",", ":"))
    try:
        stamp.write_text(text, encoding="utf-8")
    except OSError:  # a full disk: the build is good, and the next one goes by time
        with contextlib.suppress(OSError):
            stamp.unlink(missing_ok=True)
