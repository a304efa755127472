"""Mean rates of nodes and topics, as far as the triggers define them."""

from __future__ import annotations

from fractions import Fraction
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from stator.graph.model import Graph, Node


class Rates:
    """Mean periods, as far as the triggers define them. None: unknown."""

    def __init__(self, graph: Graph, *, usual: bool = False) -> None:
        """`usual`: what a node publishes seldom counts with the `min_interval` of its output."""
        self.graph = graph
        self.usual = usual
        self._periods: dict[str, Fraction | None] = {}
        self._of_topics: dict[str, Fraction | None] = {}
        for name in publishers_first(graph):
            self._periods[name] = self._of_node(graph.nodes[name])

    def node(self, name: str) -> Fraction | None:
        """Mean time between activations of a node."""
        return self._periods.get(name)

    def topic(self, name: str) -> Fraction | None:
        """Mean time between publications, one for each activation of a publisher."""
        if name not in self._of_topics:
            sums = [
                _sum_of_rates([self._of_publisher(node, name) for node in together])
                for together in self._at_one_time(self.graph.topics[name].publishers)
            ]
            known = [period for period in sums if period is not None]
            self._of_topics[name] = min(known) if known and len(known) == len(sums) else None
        return self._of_topics[name]

    def _of_publisher(self, node: str, topic: str) -> Fraction | None:
        bridge = self.graph.nodes[node].interface.bridge
        if bridge is not None:
            ports = (p for p, o in self.graph.nodes[node].outputs.items() if o.topic == topic)
            return bridge.period_of(next(ports))
        period = self._periods.get(node)
        outputs = self.graph.nodes[node].outputs.values() if self.usual else ()
        least = max((o.port.min_interval_us for o in outputs if o.topic == topic), default=0)
        return max(period or Fraction(0), Fraction(least)) or None

    def _at_one_time(self, nodes: tuple[str, ...]) -> list[list[str]]:
        """For each mode that runs any of the nodes: those that it runs."""
        if len(nodes) == 1 or self.graph.modes is None:
            return [list(nodes)]
        sets = list(self.graph.modes.sets.values())
        always = [name for name in nodes if not any(name in names for names in sets)]
        together = [[*always, *(name for name in nodes if name in names)] for names in sets]
        return [names for names in together if names] or [list(nodes)]

    def _of_node(self, node: Node) -> Fraction | None:
        periods: list[Fraction | None] = []
        for trigger in node.triggers:
            if trigger.kind == "every":
                periods.append(Fraction(trigger.period_us))
            elif trigger.kind == "irq":
                least = trigger.min_interarrival_us
                periods.append(None if least is None else Fraction(least))
            else:
                period = self.topic(trigger.name)
                if trigger.min_interval_us is not None:
                    least = trigger.min_interval_us
                    period = Fraction(least) if period is None else max(period, Fraction(least))
                periods.append(period)
        return _sum_of_rates(periods)


def _sum_of_rates(periods: list[Fraction | None]) -> Fraction | None:
    known = [period for period in periods if period is not None]
    if not known or len(known) < len(periods):
        return None
    return 1 / sum((1 / period for period in known), Fraction(0))


def publishers_first(graph: Graph) -> list[str]:
    """The nodes in an order in which publishers come before the nodes that their topics trigger.
    The check has refused cycles."""
    unknown = {name: len(topic.publishers) for name, topic in graph.topics.items()}
    waits: dict[str, int] = {}
    woken: dict[str, list[str]] = {name: [] for name in graph.topics}
    for node in graph.nodes.values():
        sources = [t.name for t in node.triggers if t.kind == "topic"]
        waits[node.name] = len(sources)
        for topic in sources:
            woken[topic].append(node.name)
    ready = [name for name, count in waits.items() if not count]
    for name in ready:
        for output in graph.nodes[name].outputs.values():
            unknown[output.topic] -= 1
            if unknown[output.topic]:
                continue
            for reader in woken[output.topic]:
                waits[reader] -= 1
                if not waits[reader]:
                    ready.append(reader)
    return ready
