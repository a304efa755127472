"""The hash of a graph: two builds with the same hash behave alike. It covers topics, messages, app
nodes with interfaces and parameters, device classes and the plan; not board, driver, budgets or
text."""

from __future__ import annotations

import hashlib
import json
from dataclasses import astuple
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from stator.graph.model import Interface, Message
    from stator.plan.plan import Plan


def graph_hash(plan: Plan) -> str:
    """SHA-256, in hexadecimal."""
    text = json.dumps(_content(plan), sort_keys=True, separators=(",", ":"))
    return hashlib.sha256(text.encode()).hexdigest()


def _content(plan: Plan) -> dict[str, Any]:
    graph = plan.graph
    return {
        "topics": {t.name: [t.message.name, t.depth, t.publishers] for t in plan.topics.values()},
        "messages": {t.message.name: _message(t.message) for t in plan.topics.values()},
        "nodes": {
            node.name: {
                "interface": _interface(node.interface),
                "device": node.device,
                "params": {key: str(value) for key, value in node.params.items()},
                "inputs": {key: [i.topic, i.max_age_us, i.queue] for key, i in node.inputs.items()},
                "outputs": {key: o.topic for key, o in node.outputs.items()},
                "triggers": [
                    [
                        t.kind,
                        t.name,
                        t.min_interarrival_us,
                        t.min_interval_us,
                        t.period_us,
                        t.offset_us,
                    ]
                    for t in node.triggers
                ],
            }
            for node in graph.nodes.values()
        },
        "modes": None if graph.modes is None else [graph.modes.initial, graph.modes.sets],
        "plan": [[task.node.name, task.level] for task in plan.tasks],
    }


def _message(message: Message) -> list[Any]:
    return [[f.name, f.type, f.count, f.unit, f.values] for f in message.fields]


def _interface(interface: Interface) -> dict[str, Any]:
    return {
        "name": interface.name,
        "lines": list(interface.lines),
        "inputs": {p.name: p.message.name for p in interface.inputs.values()},
        "outputs": {p.name: [p.message.name, p.burst] for p in interface.outputs.values()},
        "params": {
            p.name: [p.type, p.unit, *([p.id] if p.id else []), *([] if p.in_flight else [False])]
            for p in interface.params.values()
        },
        **(
            {}
            if interface.failsafe is None
            else {
                "failsafe": interface.failsafe.rows,
                "choices": [astuple(choice) for choice in interface.failsafe.choices],
            }
        ),
    }
