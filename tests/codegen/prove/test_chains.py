"""Chains: parts that wake each other, and cuts where a node reads what does not wake it."""

from __future__ import annotations

from itertools import pairwise, product
from math import lcm
from pathlib import Path

from tests.codegen.prove.graphs import proved

from stator.prove.proof import Proof

US = 1000


def chain_of(proof: Proof) -> tuple[int | None, int | None]:
    (bound,) = proof.chains
    return bound.reaction_ns, bound.age_ns


def response(proof: Proof, name: str) -> int:
    found = proof.task(name).response_ns
    assert found is not None
    return found


def test_a_part_is_as_late_as_its_last_task(tmp_path: Path) -> None:
    proof = proved(
        tmp_path,
        """
        nodes:
          sensor0: {device: sensor0, trigger: {irq: ready, min_interarrival: 1 ms}, priority: 9,
            budget: 10 us, outputs: {sample: s}}
          middle: {app: stage, trigger: {topic: s}, priority: 8, budget: 20 us, inputs: {a: s},
            outputs: {out: t}}
          last: {app: stage, trigger: {topic: t}, priority: 7, budget: 30 us, inputs: {a: t}}
        chains: {all: {path: [sensor0, middle, last], deadline: 1 ms}}
        """,
    )
    # Each of them once, and not the sum of the three responses. The next sample comes 1 ms later.
    assert chain_of(proof) == (60_003, 60_003 + 1000 * US)


def test_a_chain_may_begin_behind_another_node(tmp_path: Path) -> None:
    proof = proved(
        tmp_path,
        """
        nodes:
          sensor0: {device: sensor0, trigger: {irq: ready, min_interarrival: 1 ms}, priority: 2,
            budget: 500 us, outputs: {sample: s}}
          middle: {app: stage, trigger: {topic: s}, priority: 8, budget: 20 us, inputs: {a: s},
            outputs: {out: t}}
          last: {app: stage, trigger: {topic: t}, priority: 7, budget: 30 us, inputs: {a: t}}
        chains: {all: {path: [middle, last], deadline: 1 ms}}
        """,
    )
    # Both once: while they run, sensor0 waits.
    assert chain_of(proof)[0] == 20_001 + 30_001


SAMPLED = """
    nodes:
      first: {{app: stage, trigger: {{every: {0} us}}, priority: 3, budget: {2} us,
        outputs: {{out: s}}}}
      second: {{app: stage, trigger: {{every: {1} us}}, priority: 2, budget: {3} us,
        inputs: {{a: s}}}}
    chains: {{all: {{path: [first, second], deadline: 1 s}}}}
    """


def test_a_sampled_link_adds_the_readers_period(tmp_path: Path) -> None:
    """Davare et al. 2007: the age is the sum of all periods and responses."""
    proof = proved(tmp_path, SAMPLED.format(2000, 5000, 100, 100))
    responses = response(proof, "first") + response(proof, "second")
    assert chain_of(proof) == (5000 * US + responses, (2000 + 5000) * US + responses)


def observed_age(periods: tuple[int, ...], responses: tuple[int, ...]) -> int:
    """Of the sample at the output when the next one replaces it, for the worst whole offsets. Reads
    at releases, writes when responses are over."""
    worst = 0
    for offsets in product(*(range(period) for period in periods[1:])):
        newest: dict[int, int] = {}
        for n in range(2 * lcm(*periods) // periods[0] + 4):
            time = n * periods[0]
            end = time + responses[0]
            for period, offset, took in zip(periods[1:], offsets, responses[1:], strict=True):
                end = offset + -(-(end - offset) // period) * period + took
            newest[end] = max(time, newest.get(end, 0))
        ends = sorted(newest)
        ages = (b - newest[a] for a, b in pairwise(ends))
        worst = max(worst, *ages)
    return worst


def test_the_age_is_not_less_than_what_can_be_seen() -> None:
    """The sets of whole numbers that were searched for this, with what was found."""
    cases = {((2, 5), (1, 1)): 8, ((5, 2), (1, 1)): 8, ((4, 4), (1, 2)): 10}
    for (periods, responses), age in cases.items():
        assert observed_age(periods, responses) == age == sum(periods) + sum(responses) - 1


def test_a_reader_that_is_thinned_waits_for_its_interval_and_a_sample(tmp_path: Path) -> None:
    proof = proved(
        tmp_path,
        """
        nodes:
          sensor0: {device: sensor0, trigger: {irq: ready, min_interarrival: 1 ms}, priority: 9,
            budget: 10 us, outputs: {sample: s}}
          control: {app: stage, trigger: {topic: s, min_interval: 4 ms}, priority: 8, budget: 20 us,
            inputs: {a: s}}
        chains: {all: {path: [sensor0, control], deadline: 10 ms}}
        """,
    )
    assert chain_of(proof)[0] == 10_001 + (4000 + 1000) * US + response(proof, "control")


def test_a_chain_is_bounded_in_the_modes_that_run_it(tmp_path: Path) -> None:
    proof = proved(
        tmp_path,
        """
        nodes:
          control: {app: chooser, trigger: {every: 100 ms}, priority: 9, budget: 1 us,
            outputs: {mode: mode}}
          source: {app: stage, trigger: {every: 1 ms}, priority: 5, budget: 10 us,
            outputs: {out: s}}
          one: {app: stage, trigger: {topic: s}, priority: 4, budget: 100 us, inputs: {a: s}}
          two: {app: stage, trigger: {topic: s}, priority: 6, budget: 300 us, inputs: {a: s}}
        modes: {initial: first, sets: {first: [one], second: [two], third: []}}
        chains: {all: {path: [source, one], deadline: 1 ms}}
        """,
    )
    # In the change from the second mode: each of the two once more, as the change wakes it.
    reaction = chain_of(proof)[0]
    assert reaction is not None
    assert 810 * US < reaction < 815 * US
