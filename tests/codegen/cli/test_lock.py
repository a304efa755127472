"""Two commands at once: the second waits, and says for whom."""

import os
import re
import signal
import subprocess
import sys
from pathlib import Path

import pytest

from stator import HOME
from stator.build.cmake import short_name
from stator.diagnostics import UserError
from stator.flight.facts import alone
from stator.flight.kept import default_log

# Takes the lock, says so, and keeps it until its input ends; `child` inherits it.
HOLDER = """
import subprocess, sys
from pathlib import Path
from stator.lock import held
with held(Path(sys.argv[1]), "builds quad-sitl", "./stator fly a.yaml") as lock:
    lock.tell("step 3 of 7")
    if sys.argv[2:]:
        child = subprocess.Popen(["cat"], pass_fds=(lock.fileno(),))
        print(child.pid, flush=True)
    print("mine", flush=True)
    sys.stdin.read()
"""
PIPE = subprocess.PIPE


def start(lock: Path, *words: str) -> subprocess.Popen[str]:
    command = [sys.executable, "-I", "-c", HOLDER, str(lock), *words]
    shown = os.environ | {"STATOR_PROGRESS": "on"}
    return subprocess.Popen(command, stdin=PIPE, stdout=PIPE, stderr=PIPE, text=True, env=shown)


def read(process: subprocess.Popen[str], stream: str) -> str:
    line: str = getattr(process, stream).readline()
    return line


def test_the_second_waits_and_says_for_whom(tmp_path: Path) -> None:
    with start(tmp_path / "lock") as first:
        assert read(first, "stdout") == "mine\n"
        with start(tmp_path / "lock") as second:
            assert read(second, "stderr") == (
                f"stator: waiting for './stator fly a.yaml' (process {first.pid}, step 3 of 7), "
                "which builds quad-sitl: 0 s\n"
            )
            first.kill()
            assert read(second, "stdout") == "mine\n"
            second.communicate()


def test_what_a_killed_holder_started_still_has_the_lock(tmp_path: Path) -> None:
    with start(tmp_path / "lock", "child") as first:
        child = int(read(first, "stdout"))
        assert read(first, "stdout") == "mine\n"
        os.kill(child, signal.SIGSTOP)  # its input ends with its parent
        first.kill()
        first.wait()
        with start(tmp_path / "lock") as second:
            assert re.match(
                r"stator: waiting for what './stator fly a.yaml' started \(process \d+ itself has "
                "ended",
                read(second, "stderr"),
            )
            os.kill(child, signal.SIGKILL)
            assert read(second, "stdout") == "mine\n"
            second.communicate()


def test_graphs_of_one_name_share_nothing(tmp_path: Path) -> None:
    own, other = HOME / "graph" / "quad.yaml", tmp_path / "quad.yaml"
    assert short_name(own) == "quad"
    assert re.fullmatch("quad-[0-9a-f]{8}", short_name(other))
    assert short_name(other) != short_name(tmp_path / "b" / "quad.yaml")
    assert default_log(own, 3).name == "quad-seed3.ulg"
    assert default_log(own, 3) != default_log(other, 3)


def test_one_log_is_of_one_flight(tmp_path: Path) -> None:
    log = tmp_path / "flight.ulg"
    with alone(log), pytest.raises(UserError, match="another flight is writing"), alone(log):
        pass
    with alone(log), alone(Path(os.devnull)), alone(Path(os.devnull)):
        pass
    with alone(tmp_path / "absent" / "flight.ulg"):  # what flies says what is wrong
        pass
    new = tmp_path / "new.ulg"
    with pytest.raises(UserError), alone(new):
        raise UserError("error: it did not fly")
    assert not new.exists()
