"""The plan of each topic: depth, slots, critical sections and log rate."""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from typing import TYPE_CHECKING

from stator.graph.model import Message, TopicConfig
from stator.graph.model import Topic as GraphTopic
from stator.language.keys import DEPTHS, MAX_LOGGED_BYTES, MAX_SLOTS

if TYPE_CHECKING:
    from stator.diagnostics import Mark, Report
    from stator.graph.model import Graph, Node
    from stator.plan.rates import Rates

LOG_ALL_UP_TO_US = 10_000  # every sample of a topic of at most 100 Hz is logged
LOG_ELSE_US = 20_000  # other topics are logged at 50 Hz


@dataclass(frozen=True)
class TopicPlan:
    name: str
    message: Message
    publishers: tuple[str, ...]  # none: parameters, which are published at the start only
    readers: tuple[tuple[str, str], ...]
    owner: str  # the node whose parameters these are; empty for the graph's own topics
    depth: int
    slots: int
    ceiling: int  # the highest publishing level if several levels publish, else 0
    kept_by: tuple[str, ...]  # publishers that a reader outranks
    # On one core its one or two slots take turns, as nobody holds one while the next but one is
    # built: one level publishes, and every reader is of that level or above it.
    takes_turns: bool
    log_us: int | None  # None: not logged; 0: every sample
    period_us: Fraction | None  # mean time between publications, if known


def plan_topics(
    graph: Graph, levels: dict[str, int], rates: Rates, report: Report
) -> dict[str, TopicPlan]:
    """The graph's topics in its order, then the parameters of its nodes."""
    logger = next((n for n in graph.nodes.values() if n.interface.reads_log), None)
    plans: dict[str, TopicPlan] = {}
    for topic in graph.topics.values():
        plans[topic.name] = _topic(graph, topic, levels, rates, logger, report)
    publisher = next((n for n in graph.nodes.values() if n.interface.publishes_params), None)
    for node in graph.nodes.values():
        message = node.interface.params_message
        if message is None:
            continue
        reading = [levels[n.name] for n in (node, logger) if n is not None]
        plans[f"{node.name}_params"] = _params(node, message, publisher, levels, reading)
    return plans


def _params(
    node: Node, message: Message, publisher: Node | None, levels: dict[str, int], reading: list[int]
) -> TopicPlan:
    """The topic of a node's parameters. The node reads it. If parameters can change, the logger
    reads it too, and so does their publisher."""
    name = f"{node.name}_params"
    readers = ((node.name, "params"),)
    if publisher is None:
        return TopicPlan(name, message, (), readers, node.name, 1, 1, 0, (), True, None, None)
    by = (publisher.name,)
    config = TopicConfig(None, None, many_publishers=False, mark=None)
    topic = GraphTopic(name, message, by, (*readers, (publisher.name, "")), config)
    slots = slots_needed(topic, levels, reading, depth=1)
    kept_by = by if max(reading) > levels[publisher.name] else ()
    return TopicPlan(name, message, by, readers, node.name, 1, slots, 0, kept_by, False, None, None)


def _topic(
    graph: Graph,
    topic: GraphTopic,
    levels: dict[str, int],
    rates: Rates,
    logger: Node | None,
    report: Report,
) -> TopicPlan:
    period = rates.topic(topic.name)
    log_us = _log(graph, topic, period, logger)
    queue_readers = [node for node, port in topic.readers if graph.nodes[node].inputs[port].queue]
    if log_us == 0 and logger is not None:
        queue_readers.append(logger.name)
    depth = max(_depth(topic, queue_readers, rates, report), _burst(graph, topic, levels))
    publishing = {levels[name] for name in topic.publishers}
    top = max(publishing)
    reading = [levels[name] for name, _ in topic.readers]
    if log_us is not None and logger is not None:
        reading.append(levels[logger.name])
    slots = slots_needed(topic, levels, reading, depth)
    if slots > MAX_SLOTS:
        mark = topic.config.mark or _output_mark(topic, graph)
        report.error(
            mark,
            "slots-many",
            f"expected at most {MAX_SLOTS} slots for topic '{topic.name}', found {slots}",
            f"give it a smaller depth (now {depth}), or put its readers and publishers on fewer "
            "levels",
        )
    kept_by = tuple(n for n in topic.publishers if any(level > levels[n] for level in reading))
    ceiling = top if len(publishing) > 1 else 0
    reads_own = any(name in topic.publishers for name, _ in topic.readers)
    takes_turns = depth == 1 and ceiling == 0 and min(reading, default=top) >= top and not reads_own
    return TopicPlan(
        topic.name,
        topic.message,
        topic.publishers,
        topic.readers,
        "",
        depth,
        slots,
        ceiling,
        kept_by,
        takes_turns,
        log_us,
        period,
    )


def slots_needed(topic: GraphTopic, levels: dict[str, int], reading: list[int], depth: int) -> int:
    """(D - 1) + max(keep, pins at Lw) + loans at Lw + sum over levels L < Lw of c(L)."""
    top = max(levels[name] for name in topic.publishers)
    reads = {name for name, _ in topic.readers}
    keep = 1 if any(level > top for level in reading) else 0
    pins_at_top = int(any(levels[n] == top and n in reads for n in topic.publishers))
    held: dict[int, int] = {level: 1 for level in reading if level < top}
    for name in topic.publishers:
        if levels[name] < top:
            held[levels[name]] = max(held.get(levels[name], 1), 2 if name in reads else 1)
    return (depth - 1) + max(keep, pins_at_top) + 1 + sum(held.values())


def _log(
    graph: Graph, topic: GraphTopic, period: Fraction | None, logger: Node | None
) -> int | None:
    config: TopicConfig = topic.config
    own = logger is not None and logger.name in topic.publishers
    if logger is None or own or config.log == "none" or topic.message.bytes > MAX_LOGGED_BYTES:
        return None
    if config.log == "all":
        return 0
    if isinstance(config.log, int):
        return config.log
    slow = period is not None and period >= LOG_ALL_UP_TO_US
    return 0 if slow else LOG_ELSE_US


def _burst(graph: Graph, topic: GraphTopic, levels: dict[str, int]) -> int:
    """The publications of one activation, before readers of the same or a lower level run."""
    if topic.config.depth is not None:
        return 1
    bursts = [1]
    woken = [name for name, _ in topic.readers if graph.nodes[name].trigger_of(topic.name)]
    for name in topic.publishers:
        if any(levels[reader] <= levels[name] for reader in woken):
            outputs = graph.nodes[name].outputs.values()
            bursts += [o.port.burst for o in outputs if o.topic == topic.name]
    return next(depth for depth in DEPTHS if depth >= max(bursts))


def _depth(topic: GraphTopic, queue_readers: list[str], rates: Rates, report: Report) -> int:
    """The smallest depth that holds what is published between two activations of each reader."""
    config = topic.config
    mark = config.mark or _output_mark(topic, rates.graph)
    needed, slowest = 1, ""
    for name in queue_readers:
        published, read = rates.topic(topic.name), rates.node(name)
        if published is not None and read is not None:
            # One more, because the phase between the two is unknown.
            count = -(-read // published) + 1
            needed, slowest = max((needed, slowest), (count, name))
        elif config.depth is None:
            unknown = topic.publishers[0] if published is None else name
            report.error(
                mark,
                "depth-rate-unknown",
                f"cannot derive the depth of '{topic.name}', which '{name}' reads as a queue: the "
                f"rate of '{unknown}' is unknown",
                "add `min_interarrival:` to the irq trigger behind it, or write "
                f"`topics: {{{topic.name}: {{depth: 4}}}}`",
            )
            break
    fitting = next((depth for depth in DEPTHS if depth >= needed), None)
    if fitting is None:
        report.error(
            mark,
            "depth-small",
            f"expected a depth of at most {DEPTHS[-1]} for '{topic.name}', found {needed}: "
            f"{needed} samples can come between two activations of '{slowest}'",
            f"activate '{slowest}' more often, or "
            + (
                "let it read the latest sample only"
                if any(name == slowest for name, _ in topic.readers)
                else f"write `topics: {{{topic.name}: {{log: 50 Hz}}}}`"
            ),
        )
    elif config.depth is not None and config.depth < needed:
        report.error(
            mark,
            "depth-small",
            f"expected a depth of at least {needed} for '{topic.name}', found {config.depth}: "
            f"{needed} samples can come between two activations of '{slowest}'",
            f"write {fitting}, or remove `depth`",
        )
    return config.depth or fitting or DEPTHS[-1]


def _output_mark(topic: GraphTopic, graph: Graph) -> Mark:
    """The place of the output that publishes the topic first."""
    outputs = graph.nodes[topic.publishers[0]].outputs.values()
    return next(output.mark for output in outputs if output.topic == topic.name)
