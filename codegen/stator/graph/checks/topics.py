"""Derives the topics from the ports of the nodes, and checks publishers against readers."""

from __future__ import annotations

from typing import TYPE_CHECKING

from stator.diagnostics import Mark, Report, beside
from stator.graph.checks.cycles import check_cycles
from stator.graph.checks.params import check_param_ids, check_params_publisher
from stator.graph.model import Message, Node, NodeOutput, Topic, TopicConfig, Trigger
from stator.language.keys import DEPTHS, MAX_LOGGED_BYTES
from stator.language.period import Period
from stator.language.shapes import Record, items, quoted
from stator.language.yaml_tree import Scalar
from stator.quantities import split

if TYPE_CHECKING:
    from stator.graph.checks.nodes import Nodes

_NO_CONFIG = TopicConfig(None, None, False, None)
Publishers = list[tuple[Node, NodeOutput]]
MAX_THINNED = 32  # of one topic: a bit of a word for each (`activate` in one_core_topic.hpp)


def connect(record: Record, nodes: Nodes, report: Report) -> dict[str, Topic]:
    """All topics, in the order in which the graph publishes them."""
    configs = {
        name: _config(value, record.get("topics").keys[name], report)
        for name, value in items(record, "topics")
    }
    _check_loggers(nodes.good, report)
    check_params_publisher(nodes.good, report)
    check_param_ids(nodes.good, report)
    modes_of = _modes_of(record)
    outputs, readers = _outputs(nodes.good), _readers(nodes.good)
    topics: dict[str, Topic] = {}
    for name, publishers in outputs.items():
        config = configs.get(name, _NO_CONFIG)
        message = publishers[0][1].port.message
        _check_message(name, publishers, message, report)
        if not config.many_publishers:
            _check_publishers(name, publishers, modes_of, report)
        _check_params_name(name, publishers[0][1].mark, nodes.good, report)
        topics[name] = Topic(
            name,
            message,
            tuple(node.name for node, _ in publishers),
            tuple(readers.get(name, ())),
            config,
        )
    _check_inputs(nodes, topics, report)
    _check_thinned(nodes.good, report)
    for name, value in items(record, "topics"):
        topic = topics.get(name)
        if topic is not None:
            _check_log_size(topic, value, report)
        elif name not in readers and not nodes.may_publish(name):
            report.error(
                record.get("topics").keys[name],
                "topic-unused",
                f"unknown topic '{name}': no node publishes or reads it",
                report.nearest(name, topics),
            )
    check_cycles(nodes.good, topics, report)
    return topics


def _outputs(nodes: dict[str, Node]) -> dict[str, Publishers]:
    outputs: dict[str, Publishers] = {}
    for node in nodes.values():
        for output in node.outputs.values():
            outputs.setdefault(output.topic, []).append((node, output))
    return outputs


def _readers(nodes: dict[str, Node]) -> dict[str, list[tuple[str, str]]]:
    readers: dict[str, list[tuple[str, str]]] = {}
    for node in nodes.values():
        for key, source in node.inputs.items():
            readers.setdefault(source.topic, []).append((node.name, key))
    return readers


def _config(value: Record, mark: Mark, report: Report) -> TopicConfig:
    depth = value.get("depth")
    if depth is not None and depth.value not in DEPTHS:
        above = next(power for power in DEPTHS if power > depth.value)
        report.error(
            depth.mark,
            "depth-power",
            f"expected a power of two as depth, found {depth.value}",
            f"write {above}, or remove `depth`: it then follows from the rates",
        )
    return TopicConfig(
        _log(value, report),
        value.value("depth"),
        value.value("publishers") == "many",
        mark if depth is None else depth.mark,
        *_link(value),
    )


def _link(value: Record) -> tuple[int | None, int | None]:
    link = value.get("link")
    return (None, None) if link is None else (link.value("every"), link.value("priority"))


def _log(value: Record, report: Report) -> str | int | None:
    leaf = value.get("log")
    if leaf is None or leaf.value in ("all", "none"):
        return None if leaf is None else str(leaf.value)
    if split(leaf.value) is None:
        report.error(
            leaf.mark,
            "wrong-type",
            f"expected all, none or a rate, found {quoted(leaf.value)}",
            "write all, none, or a rate, for example 50 Hz",
        )
        return None
    period = Period().read(Scalar(leaf.value, leaf.mark), report)
    return None if period is None else int(period.value)


def _check_log_size(topic: Topic, value: Record, report: Report) -> None:
    if topic.config.log in (None, "none") or topic.message.bytes <= MAX_LOGGED_BYTES:
        return
    report.error(
        value.get("log").mark,
        "log-large",
        f"expected a message of at most {MAX_LOGGED_BYTES} bytes in the log, found "
        f"{topic.message.bytes} bytes in {topic.message.name}",
        "write `log: none`, or split the message",
    )


def _check_message(name: str, publishers: Publishers, message: Message, report: Report) -> None:
    for _, output in publishers[1:]:
        if output.port.message is not message:
            first = publishers[0][1].mark
            report.error(
                output.mark,
                "message-mismatch",
                f"expected message {message.name} on topic '{name}', found "
                f"{output.port.message.name}",
                f"'{publishers[0][0].name}' publishes {message.name} "
                f"({beside(output.mark, first)}); rename one of the topics",
            )


def _modes_of(record: Record) -> dict[str, frozenset[str]]:
    """Node -> the modes in which it runs; nodes in no set are not in here."""
    result: dict[str, set[str]] = {}
    modes = record.get("modes")
    for mode, leaf in items(modes, "sets") if modes is not None else ():
        for name in leaf.value:
            result.setdefault(name.value, set()).add(mode)
    return {name: frozenset(modes_of) for name, modes_of in result.items()}


def _check_publishers(
    name: str, publishers: Publishers, modes_of: dict[str, frozenset[str]], report: Report
) -> None:
    """One publisher at a time: nodes may share a topic only if no mode runs both."""
    if len(publishers) == 1:
        return
    in_mode: dict[str, tuple[Node, NodeOutput]] = {}
    always: tuple[Node, NodeOutput] | None = None
    for node, output in publishers:
        modes = modes_of.get(node.name)
        if modes is None:
            other = always or next(iter(in_mode.values()), None)
            always = always or (node, output)
        else:
            other = always or next((in_mode[m] for m in sorted(modes) if m in in_mode), None)
            for mode in modes:
                in_mode.setdefault(mode, (node, output))
        if other is not None and output.port.message is other[1].port.message:
            report.error(
                output.mark,
                "publishers",
                f"expected one publisher of topic '{name}', found '{other[0].name}' and "
                f"'{node.name}'",
                f"first one: {beside(output.mark, other[1].mark)}; rename one of the topics, or "
                f"write `topics: {{{name}: {{publishers: many}}}}`",
            )


def _check_params_name(name: str, mark: Mark, nodes: dict[str, Node], report: Report) -> None:
    node = nodes.get(name.removesuffix("_params"))
    if name.endswith("_params") and node is not None and node.interface.params:
        report.error(
            mark,
            "reserved-name",
            f"'{name}' cannot be a topic name: it carries the parameters of '{node.name}'",
            "rename this topic",
        )


def _check_inputs(nodes: Nodes, topics: dict[str, Topic], report: Report) -> None:
    for node in nodes.good.values():
        for key, source in node.inputs.items():
            topic = topics.get(source.topic)
            if topic is None and not nodes.may_publish(source.topic):
                report.error(
                    source.mark,
                    "topic-unpublished",
                    f"unknown topic '{source.topic}': no node publishes it",
                    report.nearest(source.topic, topics),
                )
            elif topic is not None and topic.message is not source.port.message:
                fitting = [t.name for t in topics.values() if t.message is source.port.message]
                report.error(
                    source.mark,
                    "message-mismatch",
                    f"expected a topic of message {source.port.message.name} for input '{key}', "
                    f"found '{topic.name}' of {topic.message.name}",
                    report.nearest(source.topic, fitting)
                    or f"add a node that publishes {source.port.message.name}",
                )


def _check_thinned(nodes: dict[str, Node], report: Report) -> None:
    thinned: dict[str, list[Trigger]] = {}
    for node in nodes.values():
        for trigger in node.triggers:
            if trigger.is_thinned:
                thinned.setdefault(trigger.name, []).append(trigger)
    for name, triggers in thinned.items():
        if len(triggers) > MAX_THINNED:
            report.error(
                triggers[MAX_THINNED].mark,
                "thinned-many",
                f"expected at most {MAX_THINNED} triggers with `min_interval` on topic '{name}', "
                f"found {len(triggers)}",
                "remove `min_interval` from some, or let one node publish the topic at the lower "
                "rate",
            )


def _check_loggers(nodes: dict[str, Node], report: Report) -> None:
    loggers = [node for node in nodes.values() if node.interface.reads_log]
    for node in loggers[1:]:
        report.error(
            node.mark,
            "log-many",
            f"expected one logger, found '{loggers[0].name}' and '{node.name}'",
            f"first one: {beside(node.mark, loggers[0].mark)}; keep one of them",
        )
