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

ANY_NUMBER = 1 << 16  # of publications: of parameters, which have no `burst`
LOG_ALL_UP_TO_US = 10_000  # every sample of a topic of at most 100 Hz is logged
LOG_ELSE_US = 20_000  # other topics are logged at 50 Hz


@dataclass(frozen=True)
class Use:
    """What one activation of a node does with a topic."""

    level: int
    held: int = 0  # samples that it holds at once
    reads_queue: bool = False  # these may be the oldest of the history, not only the newest
    publications: int = 0  # at most
    copies_newest: bool = False  # and holds it while it builds the next one


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
    # On one core its one or two slots take turns, as no job holds one while the next but one is
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
    publisher, changeable = graph.params_publisher, graph.changeable
    for node in graph.nodes.values():
        message = node.interface.params_message
        if message is None:
            continue
        by = publisher if node.name in changeable else None
        plans[f"{node.name}_params"] = _params(node, message, by, logger, levels)
    return plans


def _params(
    node: Node,
    message: Message,
    publisher: Node | None,
    logger: Node | None,
    levels: dict[str, int],
) -> TopicPlan:
    """The topic of a node's parameters. The node reads it. If parameters can change, the logger
    reads it too, and so does their publisher."""
    name = f"{node.name}_params"
    readers: tuple[tuple[str, str], ...] = ((node.name, "params"),)
    if publisher is None:
        return TopicPlan(name, message, (), readers, node.name, 1, 1, 0, (), True, None, None)
    by = (publisher.name,)
    level = levels[publisher.name]
    uses = [
        Use(
            levels[name],
            held=(name == node.name) + (logger is not None and name == logger.name),
            publications=ANY_NUMBER if name == publisher.name else 0,
            copies_newest=name == publisher.name,
        )
        for name in {n.name: n for n in (node, publisher, logger) if n is not None}
    ]
    slots = slots_needed(uses, depth=1)
    kept_by = by if any(use.held and use.level > level for use in uses) else ()
    readers = (*readers, (publisher.name, ""))
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
    logged_by = logger if log_us is not None else None
    uses = _uses(graph, topic, levels, logged_by, log_us == 0)
    slots = slots_needed(uses, depth)
    if slots > MAX_SLOTS:
        mark = topic.config.mark or _output_mark(topic, graph)
        report.error(
            mark,
            "slots-many",
            f"expected at most {MAX_SLOTS} slots for topic '{topic.name}', found {slots}",
            f"give it a smaller depth (now {depth}), or put its readers and publishers on fewer "
            "levels",
        )
    reading = [use.level for use in uses if use.held]
    kept_by = tuple(n for n in topic.publishers if any(level > levels[n] for level in reading))
    ceiling = max(publishing) if len(publishing) > 1 else 0
    takes_turns = depth == 1 and all(
        use.level >= max(publishing) and not (use.publications and use.held) for use in uses
    )
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


def _uses(
    graph: Graph,
    topic: GraphTopic,
    levels: dict[str, int],
    logger: Node | None,
    logs_all: bool,
) -> list[Use]:
    inputs = {name: graph.nodes[name].inputs[port] for name, port in topic.readers}
    names = {*inputs, *topic.publishers, *([] if logger is None else [logger.name])}
    uses = []
    for name in names:
        node = graph.nodes[name]
        logs = logger is not None and name == logger.name
        way = node.way_of(inputs[name]) if name in inputs else ""
        bursts = [o.port.burst for o in node.outputs.values() if o.topic == topic.name]
        uses.append(
            Use(
                levels[name],
                held=(name in inputs) + logs,
                reads_queue=way in ("trigger", "queue") or (logs and logs_all),
                publications=max(bursts, default=0),
            )
        )
    return uses


def slots_needed(uses: list[Use], depth: int) -> int:
    """What the highest publishing level can need: the samples that a publication there keeps, its
    own ones that are older, the one that it builds, and what the levels below hold.
    docs/topics.md has the argument."""
    top = max(use.level for use in uses if use.publications)
    is_read_above = any(use.held and use.level > top for use in uses)
    held: dict[int, int] = {}
    for use in uses:
        if use.level < top:
            own = use.held + (use.publications > 0)
            held[use.level] = max(held.get(use.level, 0), own)
    return sum(held.values()) + max(
        _slots_at_top(use, depth, is_read_above)
        for use in uses
        if use.level == top and use.publications
    )


def _slots_at_top(use: Use, depth: int, is_read_above: bool) -> int:
    kept = depth - 1 + (is_read_above or use.copies_newest)
    # How old the sample that it holds can be at its last publication: 1 is the newest.
    oldest = (depth if use.reads_queue else 1) + use.publications - 1
    return kept + (use.held if oldest > kept else 0) + 1


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
