"""Each equation weakened once: the simulator sees it, by a response above its bound. The seeds are
those that were found to show it."""

from __future__ import annotations

import types
from pathlib import Path
from typing import NamedTuple

import pytest
from tests.codegen.prove import test_published
from tests.codegen.prove.graphs import written
from tests.codegen.prove.test_published import ONE_LEVEL, PREEMPTIVE, worst
from tests.codegen.prove.test_simulated import compare

from stator.prove import proof, response, system


class Fault(NamedTuple):
    module: types.ModuleType
    text: str
    instead: str
    seed: int = 0  # for the simulator


FAULTS = {
    "only the first activation of a window": Fault(
        response, "range(1, number + 1)", "range(1, min(number, 1) + 1)", 12
    ),
    "nothing of the same level has begun": Fault(
        response, "blocked = self._blocker[i].cost", "blocked = 0", 0
    ),
    "what comes at the instant of the begin waits": Fault(
        response,
        "number = (window + self._jitter[part]) // self._period[part] + 1",
        "number = -(-(window + self._jitter[part]) // self._period[part])",
        5,
    ),
    "a burst is one activation": Fault(
        response, "_column(stream.count * job.cost", "_column(job.cost", 2
    ),
    "a less urgent publisher is never late": Fault(
        system, "stream = stream.late(response.late(wake.stream))", "pass", 0
    ),
    "a handler takes no time": Fault(
        system, "cost = costs.dispatch_ns + len(lines) * costs.line_ns", "cost = 1", 5
    ),
    "a level is preempted by its own first tasks": Fault(
        response, "end = self._first[i]\n", "end = self._first[self._begin[i]]\n", 0
    ),
}

# Those that only the published sets show: in these graphs little has jitter.
PUBLISHED_FAULTS = {
    "others come without jitter": Fault(response, "(window + self._jitter[part])", "window"),
    "nothing comes between once it has begun": Fault(
        response, "end = self._end(i, start)", "end = start + job.cost"
    ),
    "only the first activation of a window": Fault(
        response, "range(1, number + 1)", "range(1, min(number, 1) + 1)"
    ),
    "nothing of the same level has begun": Fault(
        response, "blocked = self._blocker[i].cost", "blocked = 0"
    ),
}


def plant(fault: Fault, monkeypatch: pytest.MonkeyPatch) -> None:
    """Changes the module where the prover has taken its names from."""
    file = Path(str(fault.module.__file__))
    source = file.read_text(encoding="utf-8")
    assert source.count(fault.text) >= 1, "the equation is written in another way"
    changed = dict(vars(fault.module))
    exec(compile(source.replace(fault.text, fault.instead), str(file), "exec"), changed)
    if fault.module is response:
        monkeypatch.setattr(system, "Processor", changed["Processor"])
        monkeypatch.setattr(test_published, "responses", changed["responses"])
    else:
        monkeypatch.setattr(proof, "System", changed["System"])


@pytest.mark.parametrize("fault", FAULTS.values(), ids=FAULTS)
def test_a_weakened_equation_is_seen(
    fault: Fault, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    written(tmp_path, "")
    assert compare(tmp_path, fault.seed)[0] == []
    plant(fault, monkeypatch)
    assert compare(tmp_path, fault.seed)[0] != []


def as_published() -> bool:
    rows = [test_published.Row(10, 30, 5), test_published.Row(3, 15, 6)]
    return (
        all(worst(rows) == expected for rows, expected in PREEMPTIVE.values())
        and all(worst(rows, one_level=True) == expected for rows, expected in ONE_LEVEL.values())
        and worst([*rows, test_published.Row(1, 60)]) == [15, 19, 17]
    )


@pytest.mark.parametrize("fault", PUBLISHED_FAULTS.values(), ids=PUBLISHED_FAULTS)
def test_a_weakened_equation_gives_other_results_than_the_papers(
    fault: Fault, monkeypatch: pytest.MonkeyPatch
) -> None:
    assert as_published()
    plant(fault, monkeypatch)
    assert not as_published()
