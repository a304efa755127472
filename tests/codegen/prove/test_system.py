"""From graphs to jobs: what wakes a task, how late, and what the executor takes beside the nodes.

The costs of the board `bench`: 1 ns for each task, 100 and 10 for each timer for a release, 1,000
and 200 for each line for a dispatcher, 30 for a section.
"""

from __future__ import annotations

from pathlib import Path

import pytest
from tests.codegen.prove.graphs import proved

from stator.prove.proof import Proof

US = 1000


def responses(proof: Proof) -> dict[str, int | None]:
    return {task.name: task.response_ns for task in proof.tasks}


def test_a_line_with_its_own_vector(tmp_path: Path) -> None:
    proof = proved(
        tmp_path,
        """
        nodes:
          sensor0: {device: sensor0, trigger: {irq: ready, min_interarrival: 1 ms},
            priority: 9, budget: 10 us}
          sensor1: {device: sensor1, trigger: {irq: ready, min_interarrival: 2 ms},
            priority: 8, budget: 20 us}
        """,
    )
    # Pins 5 to 9 share a vector, and the board has sensor2 there, too. So it is not sensor1's own.
    assert responses(proof) == {
        "sensor0": 10 * US + 1,
        "sensor1": (10 + 20) * US + 2 + (1000 + 200),
    }


def test_lines_that_share_a_vector_are_dispatched_at_the_highest_level(tmp_path: Path) -> None:
    proof = proved(
        tmp_path,
        """
        nodes:
          sensor1: {device: sensor1, trigger: {irq: ready, min_interarrival: 1 ms},
            priority: 3, budget: 10 us}
          sensor2: {device: sensor2, trigger: {irq: ready, min_interarrival: 1 ms},
            priority: 9, budget: 20 us}
          other: {app: stage, trigger: {every: 10 ms}, priority: 8, budget: 5 us}
        """,
    )
    both = 1000 + 2 * 200
    handler = proof.solutions[0].responses["the handler of exti9_5"]
    # Of the same level, sensor2 can have begun. The handler itself may run once for each line.
    assert handler.from_arrival == 20 * US + 1 + 2 * both
    assert responses(proof)["sensor2"] == 2 * both + 20 * US + 1
    assert responses(proof)["sensor1"] == 2 * both + 20 * US + 1 + 5 * US + 1 + 110 + 10 * US + 1


def test_a_release_is_as_late_as_the_timers_handler(tmp_path: Path) -> None:
    proof = proved(
        tmp_path,
        """
        nodes:
          one: {app: stage, trigger: {every: 1 ms}, priority: 2, budget: 10 us}
          two: {app: stage, trigger: {every: 2 ms}, priority: 1, budget: 20 us}
        """,
    )
    handler = 100 + 2 * 10
    blocked = 10 * US + 1 + handler  # as `one` can have begun
    assert proof.solutions[0].responses["the timer's handler"].from_arrival == blocked
    # Late by the handler's own run once more, as the handler arms the timer itself.
    assert responses(proof)["one"] == handler + handler + 10 * US + 1


CHAIN = """
    nodes:
      sensor0: {{device: sensor0, trigger: {{irq: ready, min_interarrival: 100 us}},
        priority: 9, budget: 10 us, outputs: {{sample: s}}}}
      middle: {{app: stage, trigger: {{topic: s}},
        priority: {middle}, budget: 20 us, inputs: {{a: s}}, outputs: {{out: t}}}}
      last: {{app: stage, trigger: {{topic: t}},
        priority: {last}, budget: {budget} us, inputs: {{a: t}}}}
    """


def test_more_urgent_publishers_come_with_their_source(tmp_path: Path) -> None:
    short, long = (
        responses(proved(tmp_path, CHAIN.format(middle=8, last=7, budget=budget)))
        for budget in (65, 69)
    )
    assert short == {"sensor0": 10_001, "middle": 30_002, "last": 95_003}
    # With 69 us it ends after 99.003 us; beyond 100 us, the next sample would come first.
    assert long["last"] == 99_003


def test_a_less_urgent_publisher_is_as_late_as_it_responds(tmp_path: Path) -> None:
    proof = proved(tmp_path, CHAIN.format(middle=5, last=8, budget=40))
    (wake,) = proof.solutions[0].wakes["last"]
    middle = proof.solutions[0].responses["middle"]
    # It counts from the line, with all three of them.
    assert wake.stream.jitter == middle.from_arrival == 10_001 + 20_001 + 40_001
    # So the next one can come 29.997 us after one that is as late as that.
    assert responses(proof)["last"] == 10_001 + 2 * 40_001 - (100_000 - 70_003)


def test_a_thinned_subscriber_comes_once_in_each_interval(tmp_path: Path) -> None:
    proof = proved(
        tmp_path,
        """
        nodes:
          sensor0: {device: sensor0, trigger: {irq: ready, min_interarrival: 1 ms},
            priority: 9, budget: 10 us, outputs: {sample: s}}
          rare: {app: stage, trigger: {topic: s, min_interval: 4 ms},
            priority: 8, budget: 20 us, inputs: {a: s}}
        """,
    )
    (wake,) = proof.solutions[0].wakes["rare"]
    # Two may follow each other as closely as the samples do.
    assert wake.stream.period == 4000 * US
    assert wake.stream.distance == 1000 * US
    assert wake.stream.most(900 * US) == 1
    assert wake.stream.most(4000 * US) == 2


def test_any_of_several_triggers(tmp_path: Path) -> None:
    proof = proved(
        tmp_path,
        """
        nodes:
          sensor0: {device: sensor0, trigger: {irq: ready, min_interarrival: 100 us},
            priority: 9, budget: 10 us, outputs: {sample: s}}
          other: {app: stage, trigger: {every: 1 ms}, priority: 8, budget: 5 us, outputs: {out: t}}
          both: {app: stage, trigger: [{topic: s}, {topic: t}],
            priority: 7, budget: 20 us, inputs: {a: s, b: t}}
        """,
    )
    streams = [wake.stream for wake in proof.solutions[0].wakes["both"]]
    assert [stream.period for stream in streams] == [100 * US, 1000 * US]
    # Two activations of its own, and what is more urgent: both publishers and the timer's handler.
    assert responses(proof)["both"] == 10_001 + 5_001 + 110 + 2 * 20_001


def test_a_burst_wakes_as_often_as_it_may_publish(tmp_path: Path) -> None:
    proof = proved(
        tmp_path,
        """
        nodes:
          source: {app: stage, trigger: {every: 1 ms},
            priority: 2, budget: 10 us, outputs: {three: s}}
          sink: {app: stage, trigger: {topic: s}, priority: 1, budget: 20 us, inputs: {a: s}}
        """,
    )
    assert responses(proof)["sink"] == 110 + 10_001 + 3 * 20_001


def test_sections_of_less_urgent_publishers(tmp_path: Path) -> None:
    text = """
        topics: {{s: {{publishers: many}}}}
        nodes:
          top: {{app: stage, trigger: {{every: 1 ms}}, priority: {top}, budget: 10 us}}
          high: {{app: stage, trigger: {{every: 1 ms}},
            priority: 8, budget: 10 us, outputs: {{out: s}}}}
          low: {{app: stage, trigger: {{every: 1 ms}},
            priority: 2, budget: 10 us, outputs: {{out: s}}}}
        """

    def section_of_top(top: int) -> int:
        jobs = proved(tmp_path, text.format(top=top)).solutions[0].jobs
        return next(job.section for job in jobs if job.name == "top")

    # The section masks up to the highest publisher.
    assert [section_of_top(top) for top in (9, 8, 5, 1)] == [0, 30, 30, 0]


MODES = """
    nodes:
      control: {{app: chooser, trigger: {{every: {period}}},
        priority: 9, budget: 1 us, outputs: {{mode: mode}}}}
      one: {{app: stage, trigger: {{every: 1 ms}},
        priority: 8, budget: 100 us, outputs: {{out: s}}}}
      two: {{app: stage, trigger: {{every: 1 ms}},
        priority: 7, budget: 100 us, outputs: {{out: s}}}}
      three: {{app: stage, trigger: {{every: 1 ms}},
        priority: 6, budget: 100 us, outputs: {{out: s}}}}
      low: {{app: stage, trigger: {{every: 10 ms}}, priority: 1, budget: 100 us, inputs: {{a: s}}}}
    modes: {{initial: first, sets: {{first: [one], second: [two], third: [three]}}}}
    """


def test_each_change_between_two_modes(tmp_path: Path) -> None:
    proof = proved(tmp_path, MODES.format(period="100 ms"))
    assert len(proof.solutions) == 3
    names = [{job.name for job in s.jobs} & {"one", "two", "three"} for s in proof.solutions]
    assert names == [{"one", "two"}, {"one", "three"}, {"two", "three"}]
    # Each of two may run once more, as the change wakes it.
    low = responses(proof)["low"]
    assert low is not None
    assert 500 * US < low < 520 * US


def test_modes_that_change_faster_than_tasks_end(tmp_path: Path) -> None:
    proof = proved(tmp_path, MODES.format(period="1 ms"))
    names = [{job.name for job in s.jobs} & {"one", "two", "three"} for s in proof.solutions]
    assert names == [{"one", "two", "three"}] or len(names) == 3


def test_an_interrupt_of_the_board_counts_where_its_device_is_used(tmp_path: Path) -> None:
    text = """
        nodes:
          sensor0: {device: DEVICE, trigger: {irq: ready, min_interarrival: 1 ms},
            priority: 9, budget: 10 us}
        """
    for device, cost in (("sensor0", 10_001), ("radio", 10_001 + 5 + 1200)):
        proof = proved(tmp_path, text.replace("DEVICE", device))
        assert proof.task("sensor0").response_ns == cost


def test_an_overload_takes_the_bounds_of_what_it_can_delay(tmp_path: Path) -> None:
    proof = proved(
        tmp_path,
        """
        nodes:
          fine: {app: stage, trigger: {every: 1 ms}, priority: 9, budget: 10 us}
          heavy: {app: stage, trigger: {every: 1 ms},
            priority: 5, budget: 995 us, outputs: {out: s}}
          low: {app: stage, trigger: {every: 100 ms}, priority: 4, budget: 10 us}
          woken: {app: stage, trigger: {topic: s}, priority: 8, budget: 1 us, inputs: {a: s}}
        """,
    )
    found = responses(proof)
    assert found["fine"] is not None
    assert [found[name] for name in ("heavy", "low", "woken")] == [None, None, None]
    assert not proof.holds


@pytest.mark.parametrize(("deadline", "holds"), [("31 us", True), ("29 us", False)])
def test_a_deadline(tmp_path: Path, deadline: str, holds: bool) -> None:
    proof = proved(
        tmp_path,
        f"""
        nodes:
          sensor0: {{device: sensor0, trigger: {{irq: ready, min_interarrival: 100 us}},
            priority: 9, budget: 10 us, outputs: {{sample: s}}}}
          last: {{app: stage, trigger: {{topic: s}},
            priority: 8, budget: 20 us, deadline: {deadline}, inputs: {{a: s}}}}
        """,
    )
    last = proof.task("last")
    assert (last.holds, last.response_ns) == (holds, 30_002)
    assert last.is_stated
    assert not proof.task("sensor0").is_stated
    assert proof.task("sensor0").deadline_ns == 100_000
