"""The slots of the plan are those that a full search needs: never fewer, and no more."""

from __future__ import annotations

import itertools
import re

import pytest
from tests.codegen.plan.needed import needed_slots

from stator.plan.topics import ANY_NUMBER, Use, slots_needed

DEPTHS = (1, 2, 4)
BURSTS = (1, 2, 3, 5)
READERS = ("n", "o")
# One of a level, of all kinds: reads the newest or a queue, publishes, or both.
ROLES = (*READERS, "p1", *(f"{way}p{burst}" for way in READERS for burst in BURSTS))
LOGGERS = ("nN", "nO", "oN", "oO")  # its input, and what it logs


def planned(topic: str) -> int:
    depth, *users = topic.split()
    uses = []
    for user in users:
        level, holds, copies, burst = re.fullmatch(r"(\d+)([noNO]*)(c?)(?:p(\d+))?", user).groups()
        uses.append(
            Use(
                int(level),
                held=len(holds),
                reads_queue="o" in holds.lower(),
                publications=0 if burst is None else int(burst) or ANY_NUMBER,
                copies_newest=bool(copies),
            )
        )
    return slots_needed(uses, int(depth))


def expect_exact(topics: list[str]) -> None:
    needed = needed_slots(topics)
    wrong = {topic: (planned(topic), slots) for topic, slots in needed.items()}
    assert {topic: pair for topic, pair in wrong.items() if pair[0] != pair[1]} == {}


def shapes(levels: int, roles: tuple[str, ...]) -> list[str]:
    """One user on each level, in every combination with one to three publishers."""
    return [
        " ".join(f"{level}{role}" for level, role in enumerate(chosen, start=1))
        for chosen in itertools.product(roles, repeat=levels)
        if 1 <= sum("p" in role for role in chosen) <= 3
    ]


@pytest.mark.parametrize("depth", DEPTHS)
def test_every_shape_of_up_to_three_levels(depth: int) -> None:
    found = [shape for levels in (1, 2, 3) for shape in shapes(levels, ROLES)]
    expect_exact([f"{depth} {shape}" for shape in found])


# On four levels with the bursts that differ from one, and from each other, at some depth up to 4.
@pytest.mark.long
@pytest.mark.parametrize("depth", DEPTHS)
def test_every_shape_of_four_levels(depth: int) -> None:
    expect_exact([f"{depth} {shape}" for shape in shapes(4, ROLES)])


# Two users share a level: the one that holds more counts, not their sum.
@pytest.mark.parametrize("depth", DEPTHS)
def test_levels_that_two_users_share(depth: int) -> None:
    pairs = itertools.combinations(ROLES, 2)
    found = [f"{shared}{a} {shared}{b}" for a, b in pairs for shared in (2,)]
    found += [f"{other} {pair}" for pair in found for other in ("1n", "1op2", "3o", "3p1")]
    expect_exact([f"{depth} {shape}" for shape in found if "p" in shape])


# The logger holds its input and what it logs: two samples of one job.
@pytest.mark.parametrize("depth", DEPTHS)
def test_loggers_that_read_what_they_log(depth: int) -> None:
    found = [
        f"{level}{logger} {shape}"
        for logger in LOGGERS
        for shape in ("2p1", "2np3", "2op2 3n", "1o 2p1", "1np2 3op1")
        for level in (1, 2, 4)
    ]
    expect_exact([f"{depth} {shape}" for shape in found])


# One node publishes all parameters, as often as it likes, and has some itself.
def test_parameters() -> None:
    owners = ("", "1n", "2n", "3n", "4n")
    loggers = ("", "1N", "2N", "3N", "1nN", "2nN", "4nN")
    publishers = ("2cp0", "2ncp0")
    found = [" ".join(words).split() for words in itertools.product(publishers, owners, loggers)]
    expect_exact([f"1 {' '.join(words)}" for words in found])
