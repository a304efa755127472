"""How many slots a topic gets where one job holds two samples, or publishes more than once."""

from pathlib import Path

import pytest

from stator.emit import pthread
from stator.pipeline import make_plan

GRAPHS = Path(__file__).parent / "graph"


@pytest.mark.parametrize(
    ("graph", "topic", "slots", "on_threads"),
    [
        # Its own sample, the newest one, which the watcher may read, and the next.
        ("selfread", "counted", 3, 6),
        # Its own sample, the newest one, which it copies, and the next; the same with threads,
        # where the link has one more.
        ("tuner", "tuner_params", 3, 4),
        # The newest one and the next; below, the input and what is logged.
        ("logging", "counted", 3, 5),
        # Nobody changes it.
        ("logging", "collector_params", 1, 4),
        ("everything", "counted", 6, 8),
        # The newest one, which is copied, and the next; below, its own and what is logged.
        ("everything", "collector_params", 4, 6),
    ],
)
def test_samples_held_at_once(graph: str, topic: str, slots: int, on_threads: int) -> None:
    plan = make_plan(str(GRAPHS / f"{graph}.yaml"), None)
    planned = plan.topics[topic]
    assert planned.slots == slots
    assert pthread.slots(plan, planned) == on_threads
