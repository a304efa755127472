"""Large graphs: the work grows in proportion. Counted, as clocks on shared machines lie; the
seconds are in `./stator bench`."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

from stator.bench.check import write_big_graph
from stator.graph.check import check
from stator.plan.plan import Plan, plan


def calls_of(graph: Path) -> tuple[int, Plan]:
    """Calls of Python functions that check and plan make."""
    count = 0

    def note(_frame: object, event: str, _argument: object) -> None:
        nonlocal count
        count += event in ("call", "c_call")

    sys.setprofile(note)
    try:
        result = plan(*check(graph))
    finally:
        sys.setprofile(None)
    return count, result


def test_work_grows_in_proportion(tmp_path: Path) -> None:
    check(write_big_graph(tmp_path, 40))  # what is remembered from one run to the next
    few, small = calls_of(write_big_graph(tmp_path, 400))
    many, large = calls_of(write_big_graph(tmp_path, 1600))
    assert (len(small.tasks), len(large.tasks)) == (400, 1600)
    assert many < 1.1 * 4 * few
    assert many < 1500 * 1600  # about 1,100 calls a node, which take 0.16 ms


@pytest.mark.parametrize("count", [200, 800])
def test_one_topic_of_many_costs_the_sum_not_the_product(tmp_path: Path, count: int) -> None:
    """Half of the nodes publish it, the other half is triggered by it."""
    write_big_graph(tmp_path, 8)
    nodes = "".join(
        f"  s{i}: {{app: bench_source, trigger: {{every: 10 ms}}, outputs: {{sample: bus}}}}\n"
        f"  f{i}: {{app: bench_filter, trigger: {{topic: bus}}, deadline: 1 ms,"
        " inputs: {sample: bus}}\n"
        for i in range(count // 2)
    )
    graph = tmp_path / "bus.yaml"
    graph.write_text(f"board: sitl\ntopics: {{bus: {{publishers: many}}}}\nnodes:\n{nodes}")
    calls, _ = calls_of(graph)
    assert calls < 1500 * count


def test_a_topic_thins_for_as_many_nodes_as_a_word_has_bits(tmp_path: Path) -> None:
    write_big_graph(tmp_path, 8)
    nodes = "".join(
        f"  f{i}: {{app: bench_filter, trigger: {{topic: bus, min_interval: 20 ms}},"
        " inputs: {sample: bus}}\n"
        for i in range(32)
    )
    graph = tmp_path / "thinned.yaml"
    graph.write_text(
        "board: sitl\nnodes:\n  source: {app: bench_source, trigger: {every: 10 ms},"
        f" outputs: {{sample: bus}}}}\n{nodes}"
    )
    assert len(plan(*check(graph)).tasks) == 33
