"""The schedule of the worst window, against the equations: both end at the same time."""

from __future__ import annotations

from itertools import pairwise
from typing import TYPE_CHECKING

import pytest
from tests.codegen.prove.graphs import proved

from stator import HOME
from stator.pipeline import make_plan
from stator.prove.proof import prove
from stator.prove.system import RELEASE
from stator.prove.timeline import Run, timeline

if TYPE_CHECKING:
    from pathlib import Path


@pytest.mark.parametrize("name", ["quad", "quad_logged"])
def test_each_window_of_a_vehicle_ends_as_the_equations_say(name: str) -> None:
    proof = prove(make_plan(str(HOME / "graph" / f"{name}.yaml"), "fmu_v2"))
    for task in proof.tasks:
        runs = timeline(task)
        assert task.window is not None
        assert (runs[-1].name, runs[-1].end) == (task.name, task.window.end)
        taken: dict[str, int] = {}
        for run in runs:
            taken[run.name] = taken.get(run.name, 0) + run.end - run.begin
        assert taken == {share.name: share.cost for share in task.shares}
        assert all(one.end == two.begin for one, two in pairwise(runs))


def test_who_runs_when(tmp_path: Path) -> None:
    """By hand: what blocks has begun; then the urgent one; it comes again within the slow one."""
    proof = proved(
        tmp_path,
        """
        nodes:
          fast: {app: stage, trigger: {every: 100 us}, priority: 3, budget: 20 us}
          slow: {app: stage, trigger: {every: 1 ms}, priority: 2, budget: 90 us}
          peer: {app: stage, trigger: {every: 1 ms}, priority: 2, budget: 30 us}
        """,
    )
    runs = timeline(proof.task("slow"))
    assert [run.name for run in runs if run.name != RELEASE] == [
        *("fast", "peer", "slow", "fast", "slow"),
    ]
    costs = proof.plan.board.costs
    assert costs is not None
    slow = [run for run in runs if run.name == "slow"]
    assert sum(run.end - run.begin for run in slow) == 90_000 + costs.task_ns
    assert runs[0].begin == 0
    assert runs[-1] == Run("slow", runs[-1].begin, runs[-1].end)
