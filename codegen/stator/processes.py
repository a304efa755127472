"""Processes that commands start: what they get of the environment, and how they end."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
import threading
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from collections.abc import Sequence
    from pathlib import Path

# What of the user's environment a build and its tests get; all else (CXXFLAGS, CPATH, CMAKE_*,
# CCACHE_*, PYTHON*, ...) could change what is built, without a trace in the build folder.
PASSED = {
    *("PATH", "HOME", "USER", "LOGNAME", "SHELL", "TERM", "TZ", "TMPDIR"),
    *("DISPLAY", "WAYLAND_DISPLAY", "XAUTHORITY", "XDG_RUNTIME_DIR"),
    *("CMAKE_BUILD_PARALLEL_LEVEL", "CTEST_PARALLEL_LEVEL"),  # how fast, not what
    # How tests reach the network: without, their downloads try for minutes.
    *("HTTP_PROXY", "HTTPS_PROXY", "NO_PROXY", "http_proxy", "https_proxy", "no_proxy"),
    *("SSL_CERT_FILE", "SSL_CERT_DIR", "NODE_EXTRA_CA_CERTS"),
}
PASSED_PREFIX = "STATOR_"
# Messages that are read by a program are in English, and names of files are UTF-8.
FIXED = {"LC_ALL": "C.UTF-8"}


def environment() -> dict[str, str]:
    """The environment of a process that builds or tests."""
    passed = {
        name: value
        for name, value in os.environ.items()
        if name in PASSED or name.startswith(PASSED_PREFIX)
    }
    return passed | FIXED


def start(command: Sequence[str | Path], **options: Any) -> subprocess.Popen[str]:
    """As `subprocess.Popen`, with text. What is started gets SIGTERM when this process has been
    killed, so that nothing is left behind."""
    return subprocess.Popen([*_ending_with_parent(), *command], text=True, **options)


def run(command: Sequence[str | Path], **options: Any) -> subprocess.CompletedProcess[str]:
    """As `subprocess.run`, with text; ends as what `start` starts."""
    return subprocess.run([*_ending_with_parent(), *command], text=True, **options)


# What a program says itself; other lines on its standard error are for the person at the terminal.
OWN_LINE = re.compile(r"(error|hint): |(\[[ .\d]+ s\] \S+: )?stator: ")


def run_shown(command: Sequence[str | Path]) -> subprocess.CompletedProcess[str]:
    """As `run` with its output captured, but what nodes print on standard error is shown at once.
    The result has the program's own lines."""
    pipe = subprocess.PIPE
    with start(command, stdout=pipe, stderr=pipe, errors="replace") as process:
        output, errors = read_shown(process)
    return subprocess.CompletedProcess(command, process.returncode, output, errors)


def read_shown(process: subprocess.Popen[str]) -> tuple[str, str]:
    """All of a process's output, and its own lines on standard error."""
    errors: list[str] = []

    def show() -> None:
        for line in process.stderr or ():
            if OWN_LINE.match(line):
                errors.append(line)
            elif line.strip():
                print(line, end="", file=sys.stderr, flush=True)

    reader = threading.Thread(target=show, daemon=True)
    reader.start()
    output = process.stdout.read() if process.stdout is not None else ""
    process.wait()
    reader.join()
    return output, "".join(errors)


def _ending_with_parent() -> list[str]:
    """What a command begins with for that. The shell ends it if the parent was killed before the
    system was asked for the signal."""
    setpriv = shutil.which("setpriv")
    if setpriv is None:
        return []
    check = 'test "$PPID" = "$0" && exec "$@"'
    return [setpriv, "--pdeathsig", "TERM", "--", "sh", "-c", check, str(os.getpid())]
