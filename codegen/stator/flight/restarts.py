"""Runs a program, and starts it again after an authorised restart request."""

from __future__ import annotations

import json
import os
import select
import signal
import subprocess
import sys
import time
from typing import TYPE_CHECKING, Any

from stator.build.cpp_source import constant
from stator.diagnostics import SIGNALLED
from stator.processes import read_shown, start

if TYPE_CHECKING:
    from collections.abc import Callable
    from pathlib import Path
    from types import FrameType

RESTART = constant("boards/linux/main.cpp", "kRestart")
# The shortest length that counts for one life: a program that restarts at once must end, too.
MIN_LIFE_S = 0.1
# What comes sooner is the same Ctrl-C: `timeout` signals the process, and then its whole group.
SAME_S = 0.5
ENDING = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)


def run_lives(
    command_of: Callable[[float], list[str]], log: Path, duration_s: float
) -> tuple[subprocess.CompletedProcess[str], list[Path]]:
    """Runs the program, and again after each restart request, until the whole duration is over.
    Returns the last life, and the numbered logs of the earlier ones."""
    earlier: list[Path] = []
    left_s = duration_s
    with Endings() as endings:
        while True:
            finished = endings.run(command_of(left_s))
            if finished.returncode != RESTART:
                return finished, earlier
            print(finished.stderr, end="", file=sys.stderr)  # such as a log that is not whole
            left_s -= max(json.loads(finished.stdout)["simulated_s"], MIN_LIFE_S)
            if endings.heard != 0:
                finished.returncode = SIGNALLED + endings.heard
                return finished, earlier
            if left_s < MIN_LIFE_S:
                return finished, earlier
            kept = log.with_name(f"{log.name.removesuffix('.ulg')}.{len(earlier) + 1}.ulg")
            earlier.append(log.rename(kept))


class Endings:
    """A signal ends the running life in order, with its report, and then the whole run. No signal
    is lost: a program starts with them blocked, and unblocks them when it can handle them."""

    def __init__(self) -> None:
        self.heard = 0
        self._heard_s = 0.0
        self._process: subprocess.Popen[str] | None = None

    def __enter__(self) -> Endings:
        # nohup ignores SIGHUP, and so does what it runs.
        heard = [n for n in ENDING if n != signal.SIGHUP or signal.getsignal(n) != signal.SIG_IGN]
        self._before = {number: signal.signal(number, self._hear) for number in heard}
        return self

    def __exit__(self, *_: object) -> None:
        for number, handler in self._before.items():
            signal.signal(number, handler)

    def run(self, command: list[str]) -> subprocess.CompletedProcess[str]:
        with self.start(command) as process:
            output, errors = read_shown(process)
        self._process = None
        return subprocess.CompletedProcess(command, process.returncode, output, errors)

    def start(self, command: list[str], **options: Any) -> subprocess.Popen[str]:
        """The process that signals end from now on."""
        pipe = subprocess.PIPE
        before = signal.pthread_sigmask(signal.SIG_BLOCK, ENDING)
        try:
            process = start(command, stdout=pipe, stderr=pipe, **options)
            self._process = process
        finally:
            signal.pthread_sigmask(signal.SIG_SETMASK, before)
        if self.heard != 0:  # while there was no process
            process.send_signal(self.heard)
        return process

    def _hear(self, number: int, _: FrameType | None) -> None:
        now_s = time.monotonic()
        again = self.heard != 0 and number == signal.SIGINT and now_s - self._heard_s > SAME_S
        if self.heard == 0:
            self._heard_s = now_s
        self.heard = number
        if number == signal.SIGHUP:
            _leave_closed_terminal()
        if self._process is not None:
            # Ctrl-C once more: it does not end by itself.
            self._process.send_signal(signal.SIGKILL if again else number)


def _leave_closed_terminal() -> None:
    """A report that cannot be shown must not fail: what is kept beside the log counts."""
    watch = select.poll()
    for descriptor in (1, 2):
        watch.register(descriptor, 0)
    for descriptor, event in watch.poll(0):
        if event & (select.POLLHUP | select.POLLERR):
            nowhere = os.open(os.devnull, os.O_WRONLY)
            os.dup2(nowhere, descriptor)
            os.close(nowhere)
