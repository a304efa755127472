"""The time of `check` on large generated graphs, for `./stator bench`; tests count its work."""

from __future__ import annotations

import subprocess
import sys
import tempfile
import time
from pathlib import Path

SIZES = (1_000, 10_000)
REPEATS = 3
_MAX_PRIORITY = 15

_APPS = {
    "bench_source": """doc: Makes samples.
outputs: {sample: {message: BenchSample, doc: The newest.}}
params: {scale: {type: float, unit: m, range: [0, 100], default: 1, doc: Of the samples.}}
""",
    "bench_filter": """doc: Smooths samples.
inputs:
  sample: {message: BenchSample, doc: What to smooth.}
  other: {message: BenchSample, optional: true, doc: What to compare with.}
outputs: {smooth: {message: BenchSample, doc: The result.}}
params:
  gain: {type: float, unit: "1", range: [0, 10], default: 1, doc: Factor.}
  limit: {type: float, unit: rad/s, range: [0, 10], default: 1, doc: Greatest change.}
""",
}
_MESSAGE = """doc: One sample.
fields:
  timestamp_sample: {type: uint64, unit: us, doc: When it was measured.}
  xyz: {type: "float[3]", unit: m, doc: What was measured.}
"""


def write_big_graph(folder: Path, count: int) -> Path:
    """A graph of `count` nodes on board sitl, as people write them: chains of four nodes. Each node
    reads the topic of the node before it, and the newest sample of another chain."""
    for name, text in _APPS.items():
        (folder / "apps" / name).mkdir(parents=True, exist_ok=True)
        (folder / "apps" / name / f"{name}.yaml").write_text(text, encoding="utf-8")
    (folder / "messages").mkdir(exist_ok=True)
    (folder / "messages" / "BenchSample.yaml").write_text(_MESSAGE, encoding="utf-8")
    graph = folder / f"big_{count}.yaml"
    nodes = "\n".join(_node(i, count) for i in range(count))
    graph.write_text(f"board: sitl\n\nnodes:\n{nodes}", encoding="utf-8")
    return graph


def _node(index: int, count: int) -> str:
    chain, place = divmod(index, 4)
    priority = index % _MAX_PRIORITY + 1
    other = (chain + 1) % (count // 4) * 4
    if place == 0:
        return f"""  node{index}:
    app: bench_source
    trigger: {{every: {chain % 10 + 1} ms, offset: {chain % 7 * 100} us}}
    priority: {priority}
    outputs: {{sample: topic{index}}}
    params: {{scale: {chain % 100} m}}
"""
    return f"""  node{index}:
    app: bench_filter
    trigger: {{topic: topic{index - 1}}}
    priority: {priority}
    deadline: {place} ms
    inputs: {{sample: topic{index - 1}, other: {{topic: topic{other}, max_age: 50 ms}}}}
    outputs: {{smooth: topic{index}}}
    params: {{gain: 0.{place}, limit: {place * 10} deg/s}}
"""


def measure() -> dict[str, float]:
    """Seconds of the whole program `stator check` for each size: the minimum of some runs."""
    result = {}
    with tempfile.TemporaryDirectory() as folder:
        for count in SIZES:
            graph = write_big_graph(Path(folder), count)
            result[f"nodes_{count}_s"] = min(_check_once(graph) for _ in range(REPEATS))
    return result


def _check_once(graph: Path) -> float:
    start = time.perf_counter()
    subprocess.run(
        [sys.executable, "-I", "-X", "utf8", "-m", "stator", "check", str(graph)],
        check=True,
        capture_output=True,
    )
    return time.perf_counter() - start
