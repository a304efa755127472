"""`./stator bench latency`: the time from publication to reception between two threads, beside two
bare threads with a futex, and beside LCM, iceoryx and ROS 1 if they are installed.

The programs run in turns, round by round, at 1 kHz with 64 bytes. Figures are medians of rounds.
"""

from __future__ import annotations

import contextlib
import json
import os
import shutil
import subprocess
import sys
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, TypeAlias

import numpy as np
from numpy.typing import NDArray

from stator import HOME
from stator.bench.figure import Figure, google_benchmark
from stator.build.cmake import configure
from stator.processes import environment, start

if TYPE_CHECKING:
    from collections.abc import Iterator

Rows: TypeAlias = NDArray[np.int64]  # call_ns and latency_ns of each sample; 0: lost

ROUNDS = 20
OTHER_ROUNDS = 5  # of programs that appear in the picture only
SAMPLES = 1000  # of a round
TASKS_S = 60.0
FOLDER = HOME / "build" / "bench"
SOURCES = HOME / "tests" / "bench" / "latency"
PICTURE = FOLDER / "latency.png"
ROS_PORT = 11923
ONE_CPU = "Stator on one processor"  # both levels
BARE_ONE_CPU = "bare threads on one processor"


@dataclass(frozen=True)
class Peer:
    """Other software between two processes: an optional installation."""

    name: str
    source: str
    header: str
    flags: str
    package: str
    daemon: list[str] = field(default_factory=list)  # beside every round; its log is not shown


ICEORYX_HEADERS = "/usr/include/iceoryx/v2.0.3"
PEERS = [
    Peer("LCM", "lcm", "/usr/include/lcm/lcm.h", "-std=c++20 -llcm", "liblcm-dev"),
    Peer(
        "iceoryx",
        "iceoryx",
        f"{ICEORYX_HEADERS}/iceoryx_posh/popo/publisher.hpp",
        f"-std=c++20 -I{ICEORYX_HEADERS} -liceoryx_posh -liceoryx_hoofs -liceoryx_platform",
        "libiceoryx-posh-dev iceoryx",
        ["iox-roudi", "-l", "off"],
    ),
    Peer(
        "ROS 1",
        "ros",
        "/usr/include/ros/ros.h",
        "-std=c++17 -lroscpp -lroscpp_serialization -lrosconsole -lrostime -lboost_system "
        "-lcpp_common",
        "libroscpp-dev libstd-msgs-dev python3-rosmaster",
        ["rosmaster", "--core", "-p", str(ROS_PORT)],
    ),
]


def measure() -> list[Figure]:
    programs = _programs()
    with _daemons(programs):
        rounds = _in_turns(programs)
    picture = _draw(programs, rounds)
    print(f"latency: histograms: {picture}", file=sys.stderr)
    return [*_handover(rounds), *_calls(), *_tasks(programs["tasks"])]


def _programs() -> dict[str, Path]:
    """The programs that can run here. Prints which cannot, and what to install."""
    targets = ["stator_handover", "futex_handover", "many_tasks", "calls"]
    configure(FOLDER, ["-DSTATOR_TESTS=ON"], targets)
    built = FOLDER / "tests" / "bench" / "latency"
    programs = {
        "Stator": built / "stator_handover",
        "bare threads": built / "futex_handover",
        "tasks": built / "many_tasks",
    }
    for peer in PEERS:
        if not Path(peer.header).is_file() or any(
            shutil.which(name) is None for name in peer.daemon[:1]
        ):
            print(
                f"{peer.name}: not installed; hint: apt-get install {peer.package}", file=sys.stderr
            )
            continue
        program = FOLDER / f"{peer.source}_handover"
        source = SOURCES / "peers" / f"{peer.source}_handover.cpp"
        command = ["g++", "-O2", str(source), "-o", str(program), *peer.flags.split()]
        subprocess.run(command, env=environment(), check=True)
        programs[peer.name] = program
    return programs


@contextlib.contextmanager
def _daemons(programs: dict[str, Path]) -> Iterator[None]:
    """The background programs that the other software needs."""
    os.environ.update(
        ROS_IP="127.0.0.1",
        ROS_HOME=str(FOLDER / "ros"),
        ROS_MASTER_URI=f"http://127.0.0.1:{ROS_PORT}",
    )
    with contextlib.ExitStack() as daemons:
        for peer in PEERS:
            if not peer.daemon or peer.name not in programs:
                continue
            quiet = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}
            daemon = daemons.enter_context(start(peer.daemon, **quiet))
            daemons.callback(daemon.terminate)
        yield


def _run(program: Path, *options: str) -> Rows:
    """Other software gets the same real-time priority, if that is allowed."""
    fifo = ["chrt", "-f", "15"] if program.parent == FOLDER and _may_have_fifo() else []
    command = [*fifo, str(program), str(SAMPLES), *options]
    finished = subprocess.run(command, check=True, capture_output=True, text=True, timeout=120)
    rows = np.array([line.split() for line in finished.stdout.splitlines()], dtype=np.int64)
    return rows.reshape(-1, 2)


def _may_have_fifo() -> bool:
    return (
        subprocess.run(["chrt", "-f", "15", "true"], capture_output=True, check=False).returncode
        == 0
    )


def _in_turns(programs: dict[str, Path]) -> dict[str, list[Rows]]:
    names = [name for name in programs if name != "tasks"]
    rounds: dict[str, list[Rows]] = {name: [] for name in (*names, ONE_CPU, BARE_ONE_CPU)}
    for number in range(ROUNDS):
        print(f"\rlatency: round {number + 1} of {ROUNDS}", end="", file=sys.stderr)
        for name in names:
            rounds[name].append(_run(programs[name]))
        rounds[ONE_CPU].append(_run(programs["Stator"], "--one-cpu"))
        rounds[BARE_ONE_CPU].append(_run(programs["bare threads"], "--one-cpu"))
    print(file=sys.stderr)
    return rounds


# --- figures ---


def _quantiles(rounds: list[Rows], column: int, percent: float) -> NDArray[np.float64]:
    """The quantile of each round, in us; lost samples do not count here."""
    taken = [rows[:, column][rows[:, column] > 0] for rows in rounds]
    return np.array([np.percentile(values, percent) for values in taken if values.size]) * 1e-3


def _peers_of(rounds: dict[str, list[Rows]]) -> list[str]:
    return [peer.name for peer in PEERS if peer.name in rounds]


def _handover(rounds: dict[str, list[Rows]]) -> list[Figure]:
    figures = []
    for percent in (50, 99):
        bare = _quantiles(rounds["bare threads"], 1, percent)
        own = float(np.median(_quantiles(rounds["Stator"], 1, percent)))
        bound = f"bare threads: {np.median(bare):.3g} ({bare.min():.3g} to {bare.max():.3g})"
        what = f"publication to reception, p{percent}"
        figures.append(Figure(what, own, "us", bound, own <= float(bare.max())))
        for name in _peers_of(rounds):
            other = float(np.median(_quantiles(rounds[name], 1, percent)))
            ahead = f"{name} across processes, p{percent}"
            figures.append(Figure(ahead, other, "us", f"more than {own:.3g}", own < other))
        one_cpu = float(np.median(_quantiles(rounds[ONE_CPU], 1, percent)))
        figures.append(Figure(f"{ONE_CPU}, p{percent}", one_cpu, "us", "for comparison", True))
    figures.append(
        _woken("one publish with wake-up of the subscriber", rounds, "Stator", "bare threads")
    )
    figures.append(_woken("  the same on one processor", rounds, ONE_CPU, BARE_ONE_CPU))
    for name in _peers_of(rounds):
        other = float(np.median(_quantiles(rounds[name], 0, 50))) * 1e3
        figures.append(Figure(f"one publish, {name}", other, "ns", "for comparison", True))
    lost = sum(int((rows[:, 1] == 0).sum()) for rows in rounds["Stator"])
    total = sum(len(rows) for rows in rounds["Stator"])
    figures.append(Figure(f"samples lost, of {total}", lost, "", "each is counted", True))
    return figures


def _woken(what: str, rounds: dict[str, list[Rows]], own: str, bare: str) -> Figure:
    """The time of one call beyond a call of bare threads in the same round: between two processors,
    a call varies by microseconds from round to round."""
    own_calls = _quantiles(rounds[own], 0, 50) * 1e3
    bare_calls = _quantiles(rounds[bare], 0, 50) * 1e3
    more = float(np.median(own_calls - bare_calls))
    bound = f"bare futex {np.median(bare_calls):.0f} ({more:+.0f}, under +50)"
    return Figure(what, float(np.median(own_calls)), "ns", bound, more <= 50)


def _calls() -> list[Figure]:
    times = google_benchmark("calls")
    over = times["publish_awake"] - times["plain_stores"]
    new = times["read_new"] - times["publish_awake"]
    latest, poll = times["read_latest"], times["poll_nothing_new"]
    return [
        Figure("publish, subscriber awake: over plain stores", over, "ns", "under 50", over < 50),
        Figure("read the newest sample, already read", latest, "ns", "under 4", latest < 4),
        Figure("read the newest sample, not yet read", new, "ns", "for comparison", True),
        Figure("poll without a new sample", poll, "ns", "under 2", poll < 2),
    ]


def _tasks(program: Path) -> list[Figure]:
    """8 levels, 200 tasks, 1 kHz: all due at once, which is the default of graphs, and each at its
    own time, with a wake-up each."""
    return [
        *_tasks_at(program, "all due at once"),
        *_tasks_at(program, "each at its own time", "--spread"),
    ]


def _tasks_at(program: Path, due: str, *options: str) -> list[Figure]:
    print(f"latency: 200 tasks, {due}, 2 times {TASKS_S:g} s", file=sys.stderr)
    levels = _counts_of(program, *options)
    threads = _counts_of(program, *options, "--threads")
    uncounted = levels["releases"] - levels["activations"] - levels["missed"]
    together = 100 * levels["missed"] / levels["releases"]
    cost = levels["cpu_s"] / levels["activations"] * 1e6
    other = threads["cpu_s"] / threads["activations"] * 1e6
    return [
        Figure(
            f"200 tasks on 8 levels, {due}: activations lost and not counted",
            uncounted,
            "",
            "0",
            uncounted == 0,
        ),
        Figure("  releases served together, counted", together, "%", "", True),
        Figure(
            "  CPU time of an activation", cost, "us", f"a thread each: {other:.3g}", cost < other
        ),
    ]


def _counts_of(program: Path, *options: str) -> dict[str, float]:
    command = [str(program), f"{TASKS_S:g}", *options]
    finished = subprocess.run(command, check=True, capture_output=True, text=True)
    counts: dict[str, float] = json.loads(finished.stdout)
    return counts


# --- the picture ---


def _draw(programs: dict[str, Path], rounds: dict[str, list[Rows]]) -> Path:
    import matplotlib

    matplotlib.use("Agg")
    from matplotlib import pyplot

    program = programs["Stator"]
    idle = {
        "Stator": rounds["Stator"],
        ONE_CPU: rounds[ONE_CPU],
        "Stator without SCHED_FIFO": _some(program, "--plain"),
    }
    with _load():
        loaded = {
            "Stator": _some(program),
            ONE_CPU: _some(program, "--one-cpu"),
            "Stator without SCHED_FIFO": _some(program, "--plain"),
        }
    figure, panels = pyplot.subplots(2, 1, sharex=True, figsize=(8, 6), layout="constrained")
    bins = np.logspace(0, 5, 151)
    for panel, title, shown in (
        (panels[0], "idle", idle),
        (panels[1], f"{os.cpu_count()} busy processes beside it", loaded),
    ):
        for name, some in shown.items():
            latency = np.concatenate([rows[:, 1] for rows in some]) * 1e-3
            panel.hist(latency[latency > 0], bins, histtype="step", label=name)
        if shown is idle:
            for name in ["bare threads", *_peers_of(rounds)]:
                latency = np.concatenate([rows[:, 1] for rows in rounds[name]]) * 1e-3
                panel.hist(latency[latency > 0], bins, histtype="step", alpha=0.5, label=name)
        panel.set(title=title, ylabel="samples", xscale="log", yscale="log")
        panel.legend(loc="upper right")
    panels[1].set_xlabel(f"publication to reception [us]; {_firmware()}")
    figure.savefig(PICTURE, dpi=120)
    pyplot.close(figure)
    return PICTURE


def _firmware() -> str:
    """Emulated figures are counts, not times."""
    from stator.bench.counts import counts
    from stator.emulator.qemu import NoEmulator

    try:
        _, least, most, _ = counts()[0]
    except (NoEmulator, OSError):
        return "firmware: not counted, because there is no emulator"
    count = f"{least}" if least == most else f"{least} to {most}"
    return f"firmware in QEMU: {count} instructions"


def _some(program: Path, *options: str) -> list[Rows]:
    return [_run(program, *options) for _ in range(OTHER_ROUNDS)]


@contextlib.contextmanager
def _load() -> Iterator[None]:
    spin = [sys.executable, "-I", "-c", "while True: pass"]
    busy = [start(spin) for _ in range(os.cpu_count() or 1)]
    try:
        yield
    finally:
        for process in busy:
            process.kill()
            process.wait()
