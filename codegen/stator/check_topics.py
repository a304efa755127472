"""Topics follow from the nodes' ports: who publishes, who reads, and whether that fits."""

from __future__ import annotations

from typing import TYPE_CHECKING

from stator.diagnostics import Mark, Report, nearest
from stator.language import DEPTHS
from stator.model import Message, Node, NodeOutput, Topic, TopicConfig
from stator.shapes import Period, Record, quoted
from stator.yaml_tree import Scalar

if TYPE_CHECKING:
    from collections.abc import Mapping


def connect(record: Record, nodes: dict[str, Node], report: Report) -> dict[str, Topic]:
    """All topics, in the order in which the graph publishes them."""
    configs = _configs(record, report)
    _check_loggers(nodes, report)
    modes_of = _modes_of(record)
    topics: dict[str, Topic] = {}
    outputs = _outputs(nodes)
    readers: dict[str, list[tuple[str, str]]] = {}
    for node in nodes.values():
        for key, source in node.inputs.items():
            readers.setdefault(source.topic, []).append((node.name, key))
    for name, publishers in outputs.items():
        config = configs.get(name, TopicConfig(None, None, False, None))
        message = publishers[0][1].port.message
        _check_message(name, publishers, message, report)
        _check_publishers(name, publishers, config, modes_of, report)
        _check_params_name(name, publishers[0][1].mark, nodes, report)
        topics[name] = Topic(name, message, tuple(n for n, _ in publishers),
                             tuple(readers.get(name, ())), config)
    _check_inputs(nodes, topics, _outputs_of_rejected(record, nodes), report)
    touched = set(topics) | _outputs_of_rejected(record, nodes) | {i.topic for node in nodes.values() for i in node.inputs.values()}
    for name, config in configs.items():
        if name not in touched and config.mark is not None:
            report.error(config.mark, "topic-unused", f"no node touches topic '{name}'",
                         nearest(name, topics))
    _check_cycles(nodes, topics, report)
    return topics


def _outputs(nodes: dict[str, Node]) -> dict[str, list[tuple[str, NodeOutput]]]:
    outputs: dict[str, list[tuple[str, NodeOutput]]] = {}
    for node in nodes.values():
        for output in node.outputs.values():
            outputs.setdefault(output.topic, []).append((node.name, output))
    return outputs


def _configs(record: Record, report: Report) -> dict[str, TopicConfig]:
    table = record.get("topics")
    configs: dict[str, TopicConfig] = {}
    for name, value in (table.values if table is not None else {}).items():
        depth = value.get("depth")
        if depth is not None and depth.value not in DEPTHS:
            report.error(depth.mark, "depth-power", f"depth {depth.value} is no power of two",
                         "write 1, 2, 4, 8 or 16, or leave it out")
        configs[name] = TopicConfig(_log(value, report), value.value("depth"),
                                    value.value("publishers") == "many", table.keys[name])
    return configs


def _log(value: Record, report: Report) -> str | int | None:
    leaf = value.get("log")
    if leaf is None or leaf.value in ("all", "none"):
        return None if leaf is None else str(leaf.value)
    period = Period().read(Scalar(leaf.value, leaf.mark), report)
    return None if period is None else int(period.value)


def _check_message(name: str, publishers: list[tuple[str, NodeOutput]], message: Message,
                   report: Report) -> None:
    for node, output in publishers[1:]:
        if output.port.message != message:
            report.error(output.mark, "message-mismatch", f"'{node}' publishes "
                         f"{output.port.message.name} on '{name}', others {message.name}",
                         "give it a topic of its own")


def _modes_of(record: Record) -> dict[str, set[str]]:
    """Node -> the modes in which it runs; nodes in no set are not in here."""
    result: dict[str, set[str]] = {}
    modes = record.get("modes")
    sets = modes.get("sets") if modes is not None else None
    for mode, leaf in (sets.values if sets is not None else {}).items():
        for name in leaf.value:
            result.setdefault(name.value, set()).add(mode)
    return result


def _check_publishers(name: str, publishers: list[tuple[str, NodeOutput]], config: TopicConfig,
                      modes_of: Mapping[str, set[str]], report: Report) -> None:
    if config.many_publishers:
        return
    for i, (node, output) in enumerate(publishers):
        for other, first in publishers[:i]:
            mine, theirs = modes_of.get(node), modes_of.get(other)
            if mine is not None and theirs is not None and not mine & theirs:
                continue
            report.error(output.mark, "publishers", f"'{name}' is published by '{other}' already",
                         f"line {first.mark.line}; if both are meant, write "
                         f"`topics: {{{name}: {{publishers: many}}}}`")
            break


def _check_params_name(name: str, mark: Mark, nodes: dict[str, Node], report: Report) -> None:
    node = nodes.get(name.removesuffix("_params"))
    if name.endswith("_params") and node is not None and node.interface.params:
        report.error(mark, "reserved-name", f"topic '{name}' carries the parameters of "
                     f"'{node.name}'", "give it another name")


def _outputs_of_rejected(record: Record, nodes: dict[str, Node]) -> set[str]:
    """Topics of nodes that have errors of their own: one mistake, one error."""
    topics: set[str] = set()
    for name, value in record.get("nodes").values.items():
        outputs = value.get("outputs") if name not in nodes else None
        if outputs is not None:
            topics |= {leaf.value for leaf in outputs.values.values()}
    return topics


def _check_inputs(nodes: dict[str, Node], topics: dict[str, Topic], rejected: set[str],
                  report: Report) -> None:
    for node in nodes.values():
        for key, source in node.inputs.items():
            topic = topics.get(source.topic)
            if source.topic in rejected:
                continue
            if topic is None:
                report.error(source.mark, "topic-unpublished",
                             f"topic {quoted(source.topic)} is read and never published",
                             nearest(source.topic, topics))
            elif topic.message != source.port.message:
                report.error(source.mark, "message-mismatch", f"input '{key}' reads "
                             f"{source.port.message.name}, and '{topic.name}' carries "
                             f"{topic.message.name}",
                             nearest(source.topic, [t.name for t in topics.values()
                                                    if t.message == source.port.message]))


def _check_loggers(nodes: dict[str, Node], report: Report) -> None:
    loggers = [node for node in nodes.values() if node.interface.reads_log]
    for node in loggers[1:]:
        report.error(node.mark, "log-many", f"'{loggers[0].name}' is a logger already",
                     "keep one of them")


def _check_cycles(nodes: dict[str, Node], topics: dict[str, Topic], report: Report) -> None:
    """Topic triggers must not lead back: the nodes would activate each other for ever."""
    done: set[str] = set()
    for start in nodes:
        if start in done:
            continue
        path = {start: iter(_woken_by(start, nodes, topics))}  # in order of insertion
        while path:
            name = next(reversed(path))
            following = next(path[name], None)
            if following is None:
                del path[name]
                done.add(name)
            elif following in path:
                names = list(path)
                cycle = [*names[names.index(following) :], following]
                report.error(nodes[following].mark, "trigger-cycle", "these nodes trigger each "
                             f"other for ever: {' -> '.join(cycle)}",
                             "trigger one of them by a period, and read the topic as latest")
            elif following not in done:
                path[following] = iter(_woken_by(following, nodes, topics))


def _woken_by(name: str, nodes: dict[str, Node], topics: dict[str, Topic]) -> list[str]:
    woken = []
    for output in nodes[name].outputs.values():
        topic = topics.get(output.topic)
        for reader, _ in topic.readers if topic is not None else ():
            if nodes[reader].trigger_of(output.topic) is not None:
                woken.append(reader)
    return woken
