"""What the log takes in a second, against what the logger can write."""

from __future__ import annotations

import math
from fractions import Fraction
from typing import TYPE_CHECKING

from stator.plan.rates import Rates

if TYPE_CHECKING:
    from collections.abc import Mapping

    from stator.diagnostics import Report
    from stator.graph.model import Graph, Node
    from stator.plan.topics import TopicPlan

LOGGED_BYTES = 5  # of a logged sample, without its data: size, type, topic
CHECK_BYTES = 12  # of a recording, in each block: a check of what stands before it
SECOND_US = 1_000_000
# Of what the logger can write. With the rest it writes the definitions, with which a log begins and
# during which samples wait, and catches up.
MAX_SHARE = Fraction(3, 4)
# Of the period in a hint. Below its shortest one, the graph has to log less.
STEP_US = 1000


def logger_of(graph: Graph) -> Node | None:
    return next((node for node in graph.nodes.values() if node.interface.reads_log), None)


def logged_bytes(topics: Mapping[str, TopicPlan], rates: Rates | None = None) -> Fraction:
    """Bytes of samples in a second; `rates`: of topics, in place of those of the plan."""
    return sum((rate * size for rate, size in _samples(topics, rates)), Fraction(0))


def block_bytes(graph: Graph, topics: Mapping[str, TopicPlan]) -> Fraction:
    """What a block holds. A sample that does not fit in whole begins the next one."""
    samples = _samples(topics)
    total = sum((rate * size for rate, size in samples), Fraction(0))
    wasted = sum((rate * size * size for rate, size in samples), Fraction(0)) / (total or 1)
    return _data_bytes(graph) - wasted - CHECK_BYTES


def most_blocks(graph: Graph) -> int:
    """That an activation of any logger publishes: the `burst` of its interface."""
    logger = logger_of(graph)
    assert logger is not None
    return max((output.port.burst for output in logger.outputs.values()), default=0)


def blocks_at_once(
    graph: Graph, topics: Mapping[str, TopicPlan], bytes_per_s: Fraction | None = None
) -> int:
    """That an activation of this graph's logger publishes at most, so that none takes longer than
    its log needs: what it needs, and one that ends where the activation's samples are written.
    `bytes_per_s`: with a recording."""
    logger = logger_of(graph)
    assert logger is not None
    period = Rates(graph).node(logger.name)
    if period is None:
        return most_blocks(graph)
    wanted = logged_bytes(topics) if bytes_per_s is None else bytes_per_s
    needed = wanted * period / SECOND_US / (MAX_SHARE * block_bytes(graph, topics))
    return min(max(math.ceil(needed), 1) + 1, most_blocks(graph))


def at_once_bytes(graph: Graph, topics: Mapping[str, TopicPlan]) -> Fraction:
    """What one activation of any logger writes at most."""
    return most_blocks(graph) * block_bytes(graph, topics)


def longest_period_us(
    graph: Graph, topics: Mapping[str, TopicPlan], bytes_per_s: Fraction
) -> Fraction:
    """Of a logger that writes so much, and catches up."""
    return MAX_SHARE * SECOND_US * at_once_bytes(graph, topics) / bytes_per_s


def check_log_rate(
    graph: Graph, topics: Mapping[str, TopicPlan], rates: Rates, report: Report
) -> None:
    """A logger that is too slow for the samples would lose some in each second."""
    logger = logger_of(graph)
    if logger is None or not logger.outputs:
        return
    wanted, period = logged_bytes(topics), rates.node(logger.name)
    if period is None or not wanted:
        return
    longest = longest_period_us(graph, topics, wanted)
    if period > longest:
        report.error(
            logger.triggers[0].mark,
            "log-rate",
            too_slow(logger, period, wanted, longest),
            faster(longest),
        )


def too_slow(logger: Node, period: Fraction, wanted: Fraction, longest: Fraction) -> str:
    able = wanted * longest / period
    return (
        f"the log takes up to {_kilobytes(wanted)}, and '{logger.name}' writes at most "
        f"{_kilobytes(able)} at a period of {float(period) / 1000:g} ms"
    )


def faster(longest: Fraction) -> str:
    less = "log less, such as `topics: {NAME: {log: 10 Hz}}`"
    steps = int(longest / STEP_US)
    return f"write `every: {steps} ms`, or {less}" if steps else less


def _kilobytes(rate: Fraction) -> str:
    return f"{float(rate) / 1000:.0f} kB/s"


def _samples(
    topics: Mapping[str, TopicPlan], rates: Rates | None = None
) -> list[tuple[Fraction, int]]:
    """Logged samples in a second, and the bytes of each, by topic."""
    return [
        (SECOND_US / _logged_period(topic, rates), LOGGED_BYTES + topic.message.bytes)
        for topic in topics.values()
        if topic.log_us is not None
    ]


def _logged_period(topic: TopicPlan, rates: Rates | None) -> Fraction:
    if rates is None or topic.owner:
        return Fraction(topic.log_us or topic.period_us or 1000)
    return max(Fraction(topic.log_us or 0), rates.topic(topic.name) or Fraction(1000))


def _data_bytes(graph: Graph) -> int:
    logger = logger_of(graph)
    assert logger is not None
    arrays = (
        field.count or 0
        for output in logger.outputs.values()
        for field in output.port.message.fields
    )
    return max(arrays, default=0)
