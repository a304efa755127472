"""The benchmarks of `./stator bench`: figures beside those of other software, in the same run."""

from __future__ import annotations

import json
import os
import subprocess
import time

from stator import HOME
from stator.bench.figure import REPEATS, Figure, google_benchmark
from stator.build.cmake import RECORDING, build


def _fly() -> list[Figure]:
    """The quad with every sample of every topic logged, on one core."""
    return [
        _speed(what, variant)
        for what, variant in (("logged", {}), ("logged and recorded", RECORDING))
    ]


def _speed(what: str, variant: dict[str, str]) -> Figure:
    program = build(HOME / "graph" / "quad_logged.yaml", "sitl", variant)
    speeds = []
    for _ in range(REPEATS):
        result = subprocess.run(
            [*_one_core(), program, "--log", os.devnull, "--duration", "120"],
            check=True,
            capture_output=True,
            text=True,
        )
        facts = json.loads(result.stdout)
        speeds.append(facts["simulated_s"] / facts["wall_s"])
    speed = max(speeds)
    name = f"fly, everything {what}, one core: against real time"
    return Figure(name, speed, "times", "at least 100, goal 300", speed >= 100)


def _one_core() -> list[str]:
    return ["taskset", "-c", str(max(os.sched_getaffinity(0)))]


def _topics() -> list[Figure]:
    """Publishing 64 bytes and reading the newest sample, compared with plain stores and a load."""
    times = google_benchmark("bench_topic")
    publish = times["publish"] - times["plain_stores"]
    read = times["read_latest"] - times["plain_load"]
    return [
        Figure(
            "publish 64 bytes without subscriber: over plain stores",
            publish,
            "ns",
            "at most 3",
            publish <= 3,
        ),
        Figure("read the newest sample: over a plain load", read, "ns", "at most 2", read <= 2),
    ]


def _activations() -> list[Figure]:
    """The cost of timing an activation on threads: two reads of CPU time, and the rest."""
    times = google_benchmark("bench_activation")
    cpu, clock, own = times["cpu_clock"], times["monotonic_clock"], times["activation"]
    response = times["activation_with_response"] - own
    return [
        Figure(
            "timing an activation on threads",
            own,
            "ns",
            f"at most {2 * cpu + 50:.0f}",
            own <= 2 * cpu + 50,
        ),
        Figure("timing its response as well", response, "ns", "for comparison", True),
        Figure("one read of CPU time", cpu, "ns", "for comparison", True),
        Figure("one read of the clock", clock, "ns", "for comparison", True),
    ]


def _check() -> list[Figure]:
    """Checking generated graphs of 1,000 and 10,000 nodes."""
    from stator.bench.check import measure

    seconds = measure()
    growth = seconds["nodes_10000_s"] / seconds["nodes_1000_s"]
    return [
        Figure(
            "check 1,000 nodes",
            seconds["nodes_1000_s"],
            "s",
            "under 1.5",
            seconds["nodes_1000_s"] < 1.5,
        ),
        Figure("check 10,000 nodes: against 1,000", growth, "times", "at most 12", growth <= 12),
    ]


def _edit() -> list[Figure]:
    """The time from editing one number of the graph to the end of the next flight."""
    folder = HOME / "build" / "bench-edit"
    folder.mkdir(parents=True, exist_ok=True)
    graph = folder / "edited.yaml"

    def fly(height: str) -> float:
        start = time.monotonic()
        graph.write_text(
            "include: [{file: quad.yaml}]\nboard: fmu_v2\n"
            f"nodes: {{sequence: {{params: {{height: {height}}}}}}}\n"
        )
        program = build(graph, "sitl")
        subprocess.run(
            [program, "--log", folder / "edited.ulg", "--duration", "120"],
            check=True,
            capture_output=True,
        )
        return time.monotonic() - start

    fly("2 m")
    seconds = fly("2.1 m")
    return [Figure("edit one number, build, fly", seconds, "s", "under 10", seconds < 10)]


def _counts() -> list[Figure]:
    """Instructions in QEMU, not times (docs/emulation.md)."""
    from stator.bench.counts import counts

    return [
        Figure(
            what,
            most,
            "instr." if least == most else f"instr., at least {least}",
            "for comparison" if bound is None else f"at most {bound}",
            least == most and (bound is None or most <= bound),
        )
        for what, least, most, bound in counts()
    ]


def _latency() -> list[Figure]:
    """The time from publication to reception, beside bare threads, LCM and ROS."""
    from stator.bench.latency import measure

    return measure()


BENCHMARKS = {
    "fly": _fly,
    "topics": _topics,
    "activations": _activations,
    "latency": _latency,
    "check": _check,
    "edit": _edit,
    "counts": _counts,
}
