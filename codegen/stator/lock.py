"""A lock on what several commands share, which names its holder. Standard library only: set-up,
before anything is installed, uses it too."""

from __future__ import annotations

import contextlib
import fcntl
import json
import os
import shlex
import shutil
import sys
import time
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Iterator

LOOK_S = 0.1
LINE_S = 10.0  # between two lines where there is no terminal
MOST_BYTES = 4096


class Line:
    """Progress on standard error: one line that is refreshed; without a terminal a line from time
    to time, the first one after `quiet_s`. None with STATOR_PROGRESS=off, for programs that read
    standard error."""

    def __init__(self, quiet_s: float = LINE_S) -> None:
        self._has_terminal = sys.stderr.isatty()
        self._due_s = time.monotonic() + quiet_s
        self._is_shown = False

    def show(self, text: str) -> None:
        if os.environ.get("STATOR_PROGRESS") == "off":
            return
        if self._has_terminal:
            shown = text[: shutil.get_terminal_size().columns - 1]
            print(f"\r\033[K{shown}", end="", file=sys.stderr, flush=True)
            self._is_shown = True
        elif time.monotonic() >= self._due_s:
            print(text, file=sys.stderr, flush=True)
            self._due_s = time.monotonic() + LINE_S

    def clear(self) -> None:
        if self._is_shown:
            print("\r\033[K", end="", file=sys.stderr, flush=True)
            self._is_shown = False


class Held:
    """A lock that this process has."""

    def __init__(self, descriptor: int, command: str) -> None:
        self._descriptor = descriptor
        self._command = command

    def fileno(self) -> int:
        """For what is started: who inherits it has the lock, too."""
        return self._descriptor

    def tell(self, progress: str) -> None:
        """How far it is, for those who wait."""
        holder = {"process": os.getpid(), "command": self._command, "progress": progress}
        text = json.dumps(holder).encode()
        os.ftruncate(self._descriptor, 0)
        os.pwrite(self._descriptor, text, 0)


@contextlib.contextmanager
def held(file: Path, what: str, command: str | None = None) -> Iterator[Held]:
    """Waits for the lock, and says for whom. `what`: the verb and object of those who have it, such
    as "builds quad-sitl". The system opens it once its holder and what that started have ended."""
    file.parent.mkdir(parents=True, exist_ok=True)
    descriptor = os.open(file, os.O_RDWR | os.O_CREAT | os.O_CLOEXEC, 0o666)
    try:
        if not _take(descriptor):
            _wait(descriptor, what)
        lock = Held(descriptor, command or _own_command())
        lock.tell("")
        yield lock
    finally:
        os.close(descriptor)


@contextlib.contextmanager
def held_if_free(file: Path) -> Iterator[bool]:
    """Does not wait: whether the lock was free, and is now this process's."""
    descriptor = os.open(file, os.O_RDWR | os.O_CREAT | os.O_CLOEXEC, 0o666)
    try:
        yield _take(descriptor)
    finally:
        os.close(descriptor)


def _take(descriptor: int) -> bool:
    try:
        fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        return False
    return True


def _wait(descriptor: int, what: str) -> None:
    line = Line(quiet_s=0.0)
    begin_s = time.monotonic()
    while not _take(descriptor):
        waited = f"{time.monotonic() - begin_s:.0f} s"
        line.show(f"stator: waiting for {_holder(descriptor)}, which {what}: {waited}")
        time.sleep(LOOK_S)
    line.clear()


def _holder(descriptor: int) -> str:
    """Who has the lock, in words, and how far it is."""
    try:
        holder = json.loads(os.pread(descriptor, MOST_BYTES, 0))
        process, command, progress = (
            holder["process"],
            holder["command"],
            holder["progress"],
        )
    except (ValueError, KeyError, TypeError):  # it is writing right now
        return "another command"
    if not Path(f"/proc/{process}").exists():
        return f"what '{command}' started (process {process} itself has ended)"
    return f"'{command}' (process {process}{', ' if progress else ''}{progress})"


def _own_command() -> str:
    return shlex.join(["./stator", *sys.argv[1:]])
