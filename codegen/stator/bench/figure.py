"""A figure of `./stator bench` with its bound, and programs that measure."""

from __future__ import annotations

import json
import subprocess
from dataclasses import dataclass

from stator import HOME
from stator.build.cmake import configure

REPEATS = 5


@dataclass(frozen=True)
class Figure:
    what: str
    value: float
    unit: str
    bound: str
    met: bool


def google_benchmark(target: str) -> dict[str, float]:
    """Name -> CPU time of one iteration in ns: the minimum of several runs, as noise only adds."""
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
