"""`./stator bench`: figures beside their peers, each pair measured in one run."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import time
from dataclasses import asdict, dataclass
from typing import TYPE_CHECKING

from stator.build import RECORDING, build, configure
from stator.diagnostics import UserError
from stator.library import HOME

if TYPE_CHECKING:
    import argparse

REPEATS = 5


@dataclass(frozen=True)
class Figure:
    what: str
    value: float
    unit: str
    bound: str
    met: bool


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "names", nargs="*", metavar="NAME", help=f"some of: {', '.join(BENCHMARKS)}"
    )
    parser.add_argument("--json", action="store_true", help="print what programs read")


def main(arguments: argparse.Namespace) -> int:
    unknown = [name for name in arguments.names if name not in BENCHMARKS]
    if unknown:
        raise UserError(
            f"error: there is no benchmark '{unknown[0]}'\nhint: known: {', '.join(BENCHMARKS)}"
        )
    figures: list[Figure] = []
    for name in arguments.names or BENCHMARKS:
        if not arguments.json:
            print(f"{name} ...", file=sys.stderr)
        figures += BENCHMARKS[name]()
    if arguments.json:
        print(json.dumps([asdict(figure) for figure in figures], indent=2))
    else:
        _show(figures)
    return 0


def _show(figures: list[Figure]) -> None:
    width = max(len(figure.what) for figure in figures)
    for figure in figures:
        verdict = "met" if figure.met else "NOT MET"
        value = f"{figure.value:10.4g} {figure.unit:<6}"
        print(f"{figure.what:<{width}}  {value} {figure.bound:<24} {verdict}")
    print("machine: shared and noisy runs vary; compare figures of one run only")


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
    """Publishing 64 bytes and reading the newest sample, beside plain stores and a plain load."""
    times = google_benchmark("bench_topic")
    publish = times["publish"] - times["plain_stores"]
    read = times["read_latest"] - times["plain_load"]
    return [
        Figure(
            "publish 64 bytes, nobody woken: over plain stores",
            publish,
            "ns",
            "at most 3",
            publish <= 3,
        ),
        Figure("read the newest sample: over a plain load", read, "ns", "at most 2", read <= 2),
    ]


def _activations() -> list[Figure]:
    """Timing an activation on threads: two reads of the thread's CPU time, and what it adds."""
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
        Figure("its response besides", response, "ns", "for comparison", True),
        Figure("one read of CPU time", cpu, "ns", "for comparison", True),
        Figure("one read of the clock", clock, "ns", "for comparison", True),
    ]


def google_benchmark(target: str) -> dict[str, float]:
    """Name -> CPU time of one iteration in ns: the least of several runs, as noise only adds."""
    folder = HOME / "build" / "bench"
    configure(folder, ["-DSTATOR_TESTS=ON"], [target])
    found = next(path for path in sorted(folder.rglob(target)) if path.is_file())
    result = subprocess.run(
        [found, "--benchmark_format=json", f"--benchmark_repetitions={REPEATS}"],
        check=True,
        capture_output=True,
        text=True,
    )
    times: dict[str, float] = {}
    for row in json.loads(result.stdout)["benchmarks"]:
        if row["run_type"] == "iteration":
            name = row["run_name"]
            times[name] = min(times.get(name, float("inf")), row["cpu_time"])
    return times


def _check() -> list[Figure]:
    """Checking generated graphs of 1,000 and 10,000 nodes."""
    from stator.bench_check import measure

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
    """One number edited in the graph, until it has flown again."""
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
    return [Figure("one number edited, until it has flown", seconds, "s", "under 10", seconds < 10)]


def _counts() -> list[Figure]:
    """Instructions in QEMU: no times (docs/emulation.md)."""
    from stator.counts import counts

    return [
        Figure(
            what,
            most,
            "instr." if least == most else f"instr., at least {least}",
            "to compare" if bound is None else f"at most {bound}",
            least == most and (bound is None or most <= bound),
        )
        for what, least, most, bound in counts()
    ]


def _latency() -> list[Figure]:
    """From publication to reception, beside bare threads, LCM and ROS."""
    from stator.bench_latency import measure

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
