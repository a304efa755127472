"""`./stator run`: the quad in real time, as threads. Nothing here depends on how fast the machine
is; a whole flight, which a busy machine may well spoil, is a long test."""

from __future__ import annotations

import json
import os
import pty
import signal
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import pytest
from pyulog import ULog

from stator import HOME
from stator.__main__ import main
from stator.build.cmake import RECORDING, build
from stator.flight.log import read_truth

QUAD = HOME / "graph" / "quad.yaml"
GRAPHS = Path(__file__).parent / "graph"
MAX_S = 600  # until a program that hangs is killed
LINK = f"/tmp/stator-run-{os.getpid()}"  # of its own, as other tests run beside these
SLOWLY = ("--speed", "0.2")  # where the log counts: a busy machine loses blocks of it
COMMAND = [sys.executable, "-I", "-X", "utf8", "-m", "stator", "run", "--link", LINK]


@pytest.fixture(scope="module")
def program() -> Path:
    return build(QUAD, "linux", RECORDING, executor="pthread")


def run(*arguments: str) -> tuple[int, dict[str, Any]]:
    finished = subprocess.run(
        [*COMMAND, *arguments, "--json"], capture_output=True, text=True, check=False
    )
    assert finished.stderr == ""
    return finished.returncode, json.loads(finished.stdout)


def test_a_mission_is_in_the_devices_memory(tmp_path: Path) -> None:
    mission = HOME / "graph" / "missions" / "square.yaml"
    log = tmp_path / "mission.ulg"
    _, facts = run("--mission", str(mission), "--duration", "2", *SLOWLY, "-o", str(log))
    assert (facts["graph"], facts["mission"]) == ("quad_outdoor", "square")
    result = next(d.data for d in ULog(str(log)).data_list if d.name == "mission_result")
    assert result["seq_total"][-1] == 6
    assert result["mission_id"][-1] != 0


@pytest.mark.usefixtures("program")
def test_a_short_run_is_told_in_full(tmp_path: Path) -> None:
    log = tmp_path / "short.ulg"
    status, facts = run("--duration", "1.5", *SLOWLY, "-o", str(log))
    assert status == 1
    cut, why = facts["reason"].split("; ")[-2:]  # a busy machine may miss life signs, too
    assert cut == "--duration 1.5 s ended the flight early"
    assert why.startswith("no take-off")
    assert facts["board"] == "linux"
    assert facts["duration_s"] > 1.0  # the world may be some of its steps behind
    assert facts["activations"] > 100
    assert len(facts["levels"]) == 13
    assert all(level["cpu_s"] > 0 for level in facts["levels"])
    topics = {data.name for data in ULog(str(log)).data_list}
    assert {"vehicle_attitude", "vehicle_status"} <= topics


@pytest.mark.usefixtures("program")
def test_what_is_not_allowed_is_told(tmp_path: Path) -> None:
    """Without the capabilities that it needs for real time."""
    without = ["setpriv", "--bounding-set", "-all", "--inh-caps", "-all", "prlimit", "--rtprio=0"]
    finished = subprocess.run(
        [*without, *COMMAND, "--duration", "0.5", "--json", "-o", str(tmp_path / "run.ulg")],
        capture_output=True,
        text=True,
        check=False,
    )
    if finished.stdout == "":
        pytest.skip(f"NOT TESTED: capabilities cannot be dropped here: {finished.stderr}")
    status, facts = finished.returncode, json.loads(finished.stdout)
    assert status == 1
    assert facts["real_time"] is False
    first = facts["not_allowed"][0]
    assert first["what"] == "SCHED_FIFO"
    assert first["why"] == "Operation not permitted"
    assert "ulimit -r" in first["remedy"]


@pytest.mark.usefixtures("program")
def test_a_log_that_finds_no_room_costs_the_log_and_not_the_flight(tmp_path: Path) -> None:
    """As on a full disk. The system's own answer to a file at its size limit is SIGXFSZ."""
    limited = ["prlimit", "--fsize=65536"]
    log = tmp_path / "limited.ulg"
    finished = subprocess.run(
        [*limited, *COMMAND, "--duration", "2", "--json", "-o", str(log)],
        capture_output=True,
        text=True,
        check=False,
    )
    assert (finished.returncode, finished.stderr) == (1, "")
    facts = json.loads(finished.stdout)
    assert facts["reason"].startswith(
        f"cannot judge the flight: cannot write all data to '{log}': File too large"
    )
    assert facts["duration_s"] > 1.0
    assert log.stat().st_size <= 65536


@pytest.mark.usefixtures("program")
def test_a_slower_clock_is_told(tmp_path: Path) -> None:
    """What the clock does is tests/runtime/pthread/level_test.cpp's."""
    _, facts = run("--duration", "0.5", "--speed", "0.25", "-o", str(tmp_path / "slow.ulg"))
    assert facts["speed"] == 0.25
    assert 0.2 < facts["speed_vs_real_time"] <= 0.25
    assert facts["duration_s"] >= 0.5


@pytest.mark.parametrize("speed", ["2", "0", "1e-9", "nan", "fast"])
def test_a_clock_faster_than_real_time_is_refused(
    speed: str, capsys: pytest.CaptureFixture[str]
) -> None:
    with pytest.raises(SystemExit) as ended:
        main(["run", "--speed", speed])
    assert ended.value.code == 2
    assert f"expected a factor from 0.001 to 1, found '{speed}'" in capsys.readouterr().err


def test_parts_of_a_bus_need_a_bus(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["run", "--can-parts", "vcan1"]) == 2
    assert "hint: add --can vcan0" in capsys.readouterr().err


def wait_for_log(log: Path) -> None:
    """Until it has more than its definitions, and what is recorded meanwhile: samples."""
    while not log.is_file() or log.stat().st_size < 100_000:
        time.sleep(0.05)


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM, signal.SIGHUP])
def test_a_signal_ends_it_in_order(program: Path, tmp_path: Path, number: int) -> None:
    log = tmp_path / "ended.ulg"
    heard = ["env", "--default-signal=HUP"]  # also where these tests run under nohup
    with subprocess.Popen(
        [*heard, *COMMAND, "--duration", "100", "--json", "-o", str(log)],
        stdout=subprocess.PIPE,
        text=True,
    ) as process:
        wait_for_log(log)
        process.send_signal(number)
        facts = json.loads(process.communicate()[0])
    assert process.returncode == 128 + number
    assert facts["reason"].startswith(f"{signal.Signals(number).name} after")
    assert facts["activations"] > 0
    assert ULog(str(log)).data_list
    running = subprocess.run(["pgrep", "-f", str(log)], capture_output=True, check=False)
    assert running.returncode == 1, "something was left"
    assert os.access(program, os.X_OK)


def test_the_threads_stay_on_the_processors_that_were_given(tmp_path: Path) -> None:
    """All but the main one, which only waits."""
    command = [*COMMAND, str(GRAPHS / "no_logger.yaml"), "--duration", "100", "--cpus", "0"]
    with subprocess.Popen([*command, "-o", str(tmp_path / "log")]) as process:
        threads: list[str] = []
        while len(threads) < 4:  # main, a level, lines, the world
            time.sleep(0.05)
            found = subprocess.run(
                ["pgrep", "-P", str(process.pid)], capture_output=True, text=True, check=False
            )
            tasks = [Path(f"/proc/{pid}/task") for pid in found.stdout.split()]
            threads = [str(thread) for task in tasks for thread in task.glob("*")]
        allowed = [Path(f"{thread}/status").read_text(encoding="ascii") for thread in threads]
        process.send_signal(signal.SIGINT)
    assert ["Cpus_allowed_list:\t0\n" in text for text in allowed].count(False) <= 1


@pytest.mark.parametrize("cpus", ["", "0-", "a", "1,,2", "64", "3-1", "-1"])
def test_what_is_no_list_of_processors_is_refused(
    cpus: str, capsys: pytest.CaptureFixture[str]
) -> None:
    with pytest.raises(SystemExit) as refused:
        main(["run", "--cpus", cpus])
    assert refused.value.code == 2
    assert "processor" in capsys.readouterr().err


def test_a_task_that_does_not_end_is_named_and_left(tmp_path: Path) -> None:
    endless = build(GRAPHS / "endless.yaml", "linux", executor="pthread")
    log, truth = tmp_path / "endless.ulg", tmp_path / "endless.truth"
    finished = subprocess.run(
        [endless, "--duration", "1", "--log", log, "--truth", truth],
        capture_output=True,
        text=True,
        check=False,
        timeout=MAX_S,
    )
    assert finished.returncode == 1
    assert finished.stderr == "error: task 'endless' of level 5 does not end\n"
    facts = json.loads(finished.stdout)
    assert facts["activations"] > 3
    assert [level["cpu_s"] > 0 for level in facts["levels"]] == [False, True, True]
    counts = ULog(str(log)).get_dataset("count").data["value"]
    assert list(counts)[:1] == [1]
    assert read_truth(truth).time_s[-1] > 0.5


def test_a_graph_without_a_logger_runs_to_its_end(tmp_path: Path) -> None:
    for more in ([], ["--no-record"]):
        status, facts = run(
            str(GRAPHS / "no_logger.yaml"), "--duration", "0.5", "-o", str(tmp_path / "log"), *more
        )
        # Also on a machine that is too busy for the life signs of a task.
        assert (status == 0) == facts["success"] == (facts["missed_life_signs"] == 0)
        assert facts["reason"].endswith("ran to its end")
        assert facts["recording"] is None


# The n-th thread of the process is refused, as by a machine that has no more of them.
REFUSING = """
#define _GNU_SOURCE
#include <dlfcn.h>
#include <errno.h>
#include <pthread.h>
#include <stdlib.h>
int pthread_create(pthread_t* thread, const pthread_attr_t* attributes, void* (*run)(void*),
                   void* argument) {
    static int count = 0;
    if (++count == atoi(getenv("REFUSED_THREAD"))) return errno = EAGAIN;
    int (*create)(pthread_t*, const pthread_attr_t*, void* (*)(void*), void*) =
        dlsym(RTLD_NEXT, "pthread_create");
    return create(thread, attributes, run, argument);
}
"""


@pytest.mark.parametrize(
    ("number", "what"),
    [
        (1, "the thread of a level: "),
        (2, "the thread of lines: "),
        (3, "a thread for the simulated world\nhint: "),
    ],
)
def test_threads_that_are_missing_are_told(tmp_path: Path, number: int, what: str) -> None:
    """Of a graph with one level."""
    program = build(GRAPHS / "no_logger.yaml", "linux", executor="pthread")
    source, refusing = tmp_path / "refusing.c", tmp_path / "refusing.so"
    source.write_text(REFUSING, encoding="utf-8")
    subprocess.run(["cc", "-shared", "-fPIC", source, "-o", refusing], check=True)
    finished = subprocess.run(
        [program, "--duration", "1"],
        env={**os.environ, "LD_PRELOAD": str(refusing), "REFUSED_THREAD": str(number)},
        capture_output=True,
        text=True,
        check=False,
        timeout=MAX_S,
    )
    assert (finished.returncode, finished.stdout) == (2, "")
    assert finished.stderr.startswith(f"error: cannot start: {what}")


def test_a_board_of_another_executor_is_refused(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["run", str(QUAD), "--board", "sitl"]) == 2
    error = capsys.readouterr().err
    assert "expected a board with executor pthread" in error
    assert "hint: use ./stator fly" in error


def test_a_log_that_cannot_be_opened_is_told(
    program: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert program.is_file()
    assert main(["run", "-o", "/nowhere/run.ulg"]) == 2
    assert "error: cannot open '/nowhere/run.ulg'" in capsys.readouterr().err


def test_the_log_of_another_run_is_left_to_it(
    program: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    log = tmp_path / "one.ulg"
    with subprocess.Popen([program, "--duration", "3600", "--log", log]) as other:
        wait_for_log(log)
        assert main(["run", "--link", LINK, "-o", str(log)]) == 2
        assert f"another run writes to '{log}'\nhint: " in capsys.readouterr().err
        other.terminate()
    assert ULog(str(log)).data_list


@pytest.mark.usefixtures("program")
def test_what_was_in_a_log_before_is_gone(tmp_path: Path) -> None:
    log = tmp_path / "again.ulg"
    log.write_bytes(bytes(10_000_000))
    run("--duration", "0.5", "-o", str(log))
    assert log.stat().st_size < 10_000_000
    assert ULog(str(log)).data_list


@pytest.mark.long
@pytest.mark.usefixtures("program")
def test_the_quad_flies(tmp_path: Path) -> None:
    status, facts = run("-o", str(tmp_path / "flight.ulg"))
    assert facts["reason"] == "landed and disarmed, within all limits"
    assert status == 0


def wait_until_none_has(log: Path) -> None:
    while subprocess.run(["pgrep", "-f", str(log)], capture_output=True, check=False).stdout:
        time.sleep(0.05)


@pytest.mark.usefixtures("program")
def test_a_killed_front_takes_its_program_along(tmp_path: Path) -> None:
    """Which ends in order, so that the log is whole."""
    log = tmp_path / "killed.ulg"
    with subprocess.Popen([*COMMAND, "--duration", "3600", "-o", str(log)]) as front:
        wait_for_log(log)
        front.kill()
    wait_until_none_has(log)
    assert not ULog(str(log)).file_corruption


@pytest.mark.usefixtures("program")
def test_a_closed_terminal_ends_it_in_order(tmp_path: Path) -> None:
    """The report is kept beside the log."""
    log = tmp_path / "closed.ulg"
    pid, terminal = pty.fork()
    if pid == 0:
        signal.signal(signal.SIGHUP, signal.SIG_DFL)
        command = [*COMMAND, "--duration", "3600", "-o", str(log)]
        os.execv(command[0], command)
    wait_for_log(log)
    os.close(terminal)
    assert os.waitstatus_to_exitcode(os.waitpid(pid, 0)[1]) == 128 + signal.SIGHUP
    wait_until_none_has(log)
    assert not ULog(str(log)).file_corruption
    facts = json.loads(log.with_suffix(".json").read_text(encoding="utf-8"))
    assert facts["reason"].startswith("SIGHUP after")
