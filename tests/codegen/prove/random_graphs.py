"""Random graphs, as text for the prover and as jobs for the simulator."""

from __future__ import annotations

import random
from dataclasses import dataclass, field

from tests.codegen.prove.simulator import Handler, Task

US = 1000
PERIODS_US = (100, 200, 250, 400, 500, 1000)
SENSORS = 3
# boards/bench
TASK, RELEASE, TIMER, DISPATCH, LINE, SECTION = 1, 100, 10, 1000, 200, 30
LINE_ORDER = {0: 6}  # sensor0 has the vector of its line, 6
HANDLER_ORDER, FIRST_SPARE = 23, 40


@dataclass
class Node:
    name: str
    level: int
    budget_us: int
    sensor: int | None = None
    period_us: int = 0
    triggers: list[str] = field(default_factory=list)
    topics: list[tuple[str, int]] = field(default_factory=list)
    timers: list[tuple[int, int]] = field(default_factory=list)
    output: str = ""
    burst: int = 1


def random_nodes(dice: random.Random) -> list[Node]:
    nodes: list[Node] = []
    levels = dice.randint(2, 7)
    for sensor in range(dice.randint(1, SENSORS)):
        node = Node(f"sensor{sensor}", dice.randint(1, levels), 1, sensor)
        node.period_us = dice.choice(PERIODS_US)
        node.output = f"raw{sensor}"
        nodes.append(node)
    for i in range(dice.randint(2, 7)):
        node = Node(f"stage{i}", dice.randint(1, levels), 1)
        sources = [n for n in nodes if n.output]
        for source in dice.sample(sources, min(len(sources), dice.choice((0, 1, 1, 1, 2)))):
            interval = dice.choice((0, 0, 0, 700, 1000))
            if interval and source.burst > 1:
                interval = 0
            node.topics.append((source.output, interval * US))
        if not node.topics or dice.random() < 0.15:
            period = dice.choice(PERIODS_US)
            node.timers.append((period * US, dice.choice((0, 0, dice.randrange(period))) * US))
        if dice.random() < 0.8:
            node.output = f"out{i}"
            node.burst = dice.choice((1, 1, 1, 1, 3))
        nodes.append(node)
    for node in nodes:
        node.budget_us = max(1, int(100 * dice.uniform(0.02, 0.9) / len(nodes)))
    return nodes


def text_of(nodes: list[Node]) -> str:
    lines = ["board: bench", "nodes:"]
    for node in nodes:
        if node.sensor is not None:
            kind = f"device: {node.name}"
            trigger = f"{{irq: ready, min_interarrival: {node.period_us} us}}"
            ports = f"outputs: {{sample: {node.output}}}"
        else:
            kind = "app: stage"
            parts = [
                f"{{topic: {topic}" + (f", min_interval: {gap // US} us}}" if gap else "}")
                for topic, gap in node.topics
            ]
            parts += [f"{{every: {p // US} us, offset: {o // US} us}}" for p, o in node.timers]
            trigger = f"[{', '.join(parts)}]"
            inputs = ", ".join(f"{'abc'[i]}: {t}" for i, (t, _) in enumerate(node.topics))
            ports = f"inputs: {{{inputs}}}"
            if node.output:
                ports += f", outputs: {{{'three' if node.burst > 1 else 'out'}: {node.output}}}"
        lines.append(
            f"  {node.name}: {{{kind}, trigger: {trigger}, priority: {node.level}, "
            f"budget: {node.budget_us} us, {ports}}}"
        )
    return "\n".join(lines) + "\n"


def jobs_of(nodes: list[Node]) -> tuple[list[Task], list[Handler]]:
    tasks, spare = [], FIRST_SPARE
    dispatched = [n for n in nodes if n.sensor in (1, 2)]
    for node in nodes:
        order = LINE_ORDER.get(-1 if node.sensor is None else node.sensor, spare)
        spare += order == spare
        tasks.append(
            Task(
                node.name,
                node.level,
                order,
                node.budget_us * US + TASK,
                [node.period_us * US] if node.sensor is not None else [],
                node.timers,
                node.topics,
                [(node.output, node.burst, 0)] if node.output else [],
                "lines" if node in dispatched else "",
            )
        )
    handlers = []
    timed = [n for n in nodes if n.timers]
    if timed:
        count = sum(len(n.timers) for n in timed)
        level = max(n.level for n in timed)
        handlers.append(Handler("timers", level, -1, RELEASE + count * TIMER))
    if dispatched:
        level = max(n.level for n in dispatched)
        handlers.append(Handler("lines", level, HANDLER_ORDER, DISPATCH + len(dispatched) * LINE))
    return tasks, handlers
