"""Random graphs, proven and simulated: nothing that the simulator sees is above its bound."""

from __future__ import annotations

import random
from pathlib import Path
from statistics import median

import pytest
from tests.codegen.prove.graphs import written
from tests.codegen.prove.random_graphs import SECTION, jobs_of, random_nodes, text_of
from tests.codegen.prove.simulator import Machine

from stator.graph.check import check
from stator.plan.plan import plan
from stator.prove.proof import Proof, prove

HORIZON = 15_000_000
MOST_LOAD = 2.0  # bursts that wake bursts: unread samples without end


def compare(folder: Path, seed: int) -> tuple[list[str], list[float]]:
    """What is above its bound; and observed through bound, of all responses."""
    dice = random.Random(seed)
    nodes = random_nodes(dice)
    graph = folder / "small.yaml"
    graph.write_text(text_of(nodes), encoding="utf-8")
    proof = prove(plan(*check(graph)))
    if proof.load > MOST_LOAD:
        return [], []
    bounds = late(proof)
    needed = {(q.topic, q.reader): q.needed for q in proof.queues}
    broken: list[str] = []
    tightness: dict[tuple[str, tuple[str, ...]], float] = {}
    for _ in range(3):
        seen = Machine(*jobs_of(nodes), SECTION, dice).run(HORIZON)
        for key, observed in seen.from_root.items():
            bound = bounds.get(key)
            if bound is None:
                continue
            tightness[key] = max(tightness.get(key, 0.0), observed / bound)
            if observed > bound:
                broken.append(f"seed {seed}: {key} took {observed}, bound {bound}")
        for row, count in seen.unread.items():
            most = needed.get(row)
            if most is not None and count > most:
                broken.append(f"seed {seed}: {row} had {count} unread, bound {most}")
    return broken, list(tightness.values())


def late(proof: Proof) -> dict[tuple[str, tuple[str, ...]], int]:
    """For each task and each way to it: the longest time from the source to its end."""
    (solution,) = proof.solutions
    return {
        (name, wake.path): solution.responses[name].late(wake.stream)
        for name, wakes in solution.wakes.items()
        if name in solution.responses
        for wake in wakes
        if wake.path
    }


@pytest.mark.parametrize("count", [100, pytest.param(20_000, marks=pytest.mark.long)])
def test_nothing_is_above_its_bound(
    count: int, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    written(tmp_path, "")
    broken: list[str] = []
    tightness: list[float] = []
    for seed in range(count):
        more, ratios = compare(tmp_path, seed)
        broken += more
        tightness += ratios
    assert broken == []
    assert len(tightness) > 3 * count
    with capsys.disabled():
        print(f" {len(tightness)} responses, median {median(tightness):.2f} of the bound ", end="")
