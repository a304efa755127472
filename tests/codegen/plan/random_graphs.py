"""Random small graphs: nodes that publish several times, read their own topics, publish parameters
and have some, loggers that read what they log, modes. Many of them can also stand in one graph."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from random import Random

RUN = Path(__file__).with_name("run")
BURSTS = (1, 2, 3, 6)  # one app each
TOPICS = 3  # that a node may have as inputs and outputs
MAX_LEVEL = 12

_BLOCK = """doc: A value, twice, so that a sample that changes shows.
fields:
  value: {type: uint32, unit: "1", doc: Any.}
  same: {type: uint32, unit: "1", doc: The same once more.}
"""
_MODE = """doc: Which nodes run.
fields:
  mode: {type: uint8, unit: "1", doc: The number of the mode.}
"""
_BOARD = "doc: Virtual time and no device.\nexecutor: virtual\ndevices: {}\n"


@dataclass(frozen=True)
class Reader:
    node: str
    way: str  # latest, queue, trigger, thinned


@dataclass
class Node:
    name: str
    app: str
    level: int
    triggers: list[str]
    inputs: dict[str, str] = field(default_factory=dict)  # port: the topic and how it is read
    outputs: dict[str, str] = field(default_factory=dict)
    params: str = ""

    def text(self) -> str:
        parts = [f"app: {self.app}", f"trigger: [{', '.join(self.triggers)}]"]
        parts.append(f"priority: {self.level}")
        if self.inputs:
            parts.append(f"inputs: {{{', '.join(f'{k}: {v}' for k, v in self.inputs.items())}}}")
        if self.outputs:
            parts.append(f"outputs: {{{', '.join(f'{k}: {v}' for k, v in self.outputs.items())}}}")
        if self.params:
            parts.append(f"params: {{{self.params}}}")
        return f"  {self.name}: {{{', '.join(parts)}}}"


@dataclass
class Topic:
    name: str
    publishers: list[str]
    readers: list[Reader]
    depth: int | None
    log: str | None

    def text(self) -> str:
        parts = ["publishers: many"] if len(self.publishers) > 1 else []
        parts += [f"depth: {self.depth}"] if self.depth else []
        parts += [f"log: {self.log}"] if self.log else []
        return f"  {self.name}: {{{', '.join(parts)}}}" if parts else ""


@dataclass
class Part:
    """Nodes and topics that have nothing to do with those of other parts."""

    nodes: list[Node]
    topics: list[Topic]
    gated: dict[str, list[str]]  # by mode


@dataclass
class Services:
    """The nodes of which a graph has one each: they log, publish parameters, select the mode."""

    logger: Node | None
    tuner: Node | None
    switcher: Node | None


def make_part(rng: Random, prefix: str, period_ms: tuple[int, ...]) -> Part:
    count = rng.randint(2, 6)
    levels = rng.sample(range(1, MAX_LEVEL + 1), rng.randint(1, min(4, count)))
    names = [f"{prefix}n{i}" for i in range(count)]
    nodes = []
    for name in names:
        burst = rng.choice(BURSTS)
        has_params = rng.random() < 0.4
        nodes.append(
            Node(
                name,
                f"tuned{burst}" if has_params else f"box{burst}",
                rng.choice(levels),
                [],
                params=f"count: {rng.randint(0, 9)}" if has_params else "",
            )
        )
    topics = []
    for k in range(rng.randint(1, TOPICS)):
        topics.append(_topic(rng, f"{prefix}t{k}", k, nodes))
    for node in nodes:
        if not node.triggers or rng.random() < 0.3:
            every, offset = rng.choice(period_ms), rng.randint(0, 4)
            node.triggers.append(f"{{every: {every} ms, offset: {offset} ms}}")
    gated: dict[str, list[str]] = {"day": [], "night": []}
    for name in names:
        if rng.random() < 0.3:
            gated[rng.choice(("day", "night"))].append(name)
    return Part(nodes, topics, gated)


def _topic(rng: Random, name: str, place: int, nodes: list[Node]) -> Topic:
    several = rng.choice((1, 1, 1, 2, 3))
    publishers = sorted(rng.sample(range(len(nodes)), min(several, len(nodes))))
    readers = []
    for i, node in enumerate(nodes):
        if i in publishers:
            node.outputs[f"o{place}"] = name
            way = rng.choice(("", "latest", "latest", "queue"))
        else:
            way = rng.choice(("", "latest", "queue", "trigger", "thinned"))
        # What wakes a node stands before it: no circle of nodes wakes itself.
        if way in ("trigger", "thinned") and i < publishers[-1]:
            way = "latest"
        if not way:
            continue
        read = f"{{topic: {name}, read: queue}}" if way == "queue" else name
        node.inputs[f"i{place}"] = read
        if way == "trigger":
            node.triggers.append(f"{{topic: {name}}}")
        elif way == "thinned":
            node.triggers.append(f"{{topic: {name}, min_interval: {rng.choice((7, 30))} ms}}")
        readers.append(Reader(node.name, way))
    log = rng.choice((None, "none", "all", "50 Hz"))
    depth = rng.choice((1, 2, 2, 4, 4, None))
    return Topic(name, [nodes[i].name for i in publishers], readers, depth, log)


def source_part() -> Part:
    """One that publishes all the time, for a logger to read and to log."""
    node = Node("source", "box3", MAX_LEVEL, ["{every: 3 ms}"], outputs={"o0": "sourced"})
    return Part([node], [Topic("sourced", ["source"], [], 1, "50 Hz")], {"day": [], "night": []})


def make_services(rng: Random, parts: list[Part], *, all_of_them: bool = False) -> Services:
    def wanted() -> bool:
        return all_of_them or rng.random() < 0.5

    logger = tuner = switcher = None
    if wanted():
        # Lowest where it is to run: there others publish while it holds its samples.
        level = 1 if all_of_them else rng.randint(1, MAX_LEVEL)
        logger = Node("collector", "collector", level, ["{every: 20 ms}"])
        logged = [topic for part in parts for topic in part.topics if topic.log != "none"]
        chosen = rng.sample(logged, min(TOPICS, len(logged)))
        if all_of_them and logged:
            chosen[0] = logged[-1]
        for place, topic in enumerate(chosen):
            logger.inputs[f"i{place}"] = topic.name
            topic.readers.append(Reader(logger.name, "latest"))
        logger.params = "share: 0.5"
    if wanted():
        level = rng.randint(2, MAX_LEVEL)
        tuner = Node("tuner", "tuner", level, ["{every: 11 ms, offset: 3 ms}"])
        tuner.params = "first: 1"
    if wanted():
        every = "{every: 50 ms, offset: 7 ms}"
        switcher = Node("switcher", "switcher", rng.randint(1, MAX_LEVEL), [every])
        switcher.outputs["mode"] = "mode"
    return Services(logger, tuner, switcher)


def graph_text(parts: list[Part], services: Services) -> str:
    topics = [text for part in parts for topic in part.topics if (text := topic.text())]
    extra = [n for n in (services.logger, services.tuner, services.switcher) if n is not None]
    nodes = [node.text() for part in parts for node in part.nodes]
    lines = ["board: quiet"]
    lines += ["topics:", *topics] if topics else []
    lines += ["nodes:", *nodes, *(node.text() for node in extra)]
    if services.switcher is not None:
        sets = {mode: [n for part in parts for n in part.gated[mode]] for mode in ("day", "night")}
        shown = ", ".join(f"{mode}: [{', '.join(names)}]" for mode, names in sets.items())
        lines.append(f"modes: {{initial: day, sets: {{{shown}}}}}")
    return "\n".join(lines) + "\n"


def write_apps(folder: Path) -> None:
    """Messages, board, and the interfaces of the apps, whose code is in `apps/`."""
    files = {"messages/Block.yaml": _BLOCK, "messages/Mode.yaml": _MODE}
    files["boards/quiet/board.yaml"] = _BOARD
    for burst in BURSTS:
        ports = (
            _inputs()
            + "outputs:\n"
            + "".join(
                f"  o{k}: {{message: Block, burst: {burst}, doc: Any number.}}\n"
                for k in range(TOPICS)
            )
        )
        files[f"apps/box{burst}/box{burst}.yaml"] = f"doc: Reads and publishes.\n{ports}"
        params = "{count: {type: int32, range: [0, 9], default: 2, doc: Publications.}}"
        files[f"apps/tuned{burst}/tuned{burst}.yaml"] = (
            f"doc: The same, as often as a parameter says.\n{ports}params: {params}\n"
        )
    files["apps/collector/collector.yaml"] = (
        f"doc: A logger that also reads.\n{_inputs()}"
        "params: {share: {type: float, range: [0, 1], default: 0.5, doc: Not used.}}\n"
        "reads_log: true\n"
    )
    files["apps/tuner/tuner.yaml"] = (
        "doc: Changes parameters, its own among them.\n"
        "params: {first: {type: float, range: [0, 9], default: 1, doc: Any.}}\n"
        "publishes_params: true\n"
    )
    files["apps/switcher/switcher.yaml"] = (
        "doc: Takes turns.\noutputs: {mode: {message: Mode, doc: The next one.}}\n"
    )
    for name, text in files.items():
        path = folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text, encoding="utf-8")


def _inputs() -> str:
    return "inputs:\n" + "".join(
        f"  i{k}: {{message: Block, optional: true, doc: Any.}}\n" for k in range(TOPICS)
    )


def write_code(folder: Path) -> None:
    """The code of the apps: all boxes do the same."""
    for burst in BURSTS:
        often = {
            f"box{burst}": f"{burst} + body_.draw() % 2",
            f"tuned{burst}": "static_cast<uint32_t>(ports.params->count)",
        }
        for name, count in often.items():
            code = f"""#pragma once
#include "{name}_ports.hpp"
#include "box.hpp"
namespace stator::apps::{name} {{
class {name.capitalize()} {{
  public:
    void step({name.capitalize()}Ports& ports) {{ body_.step(ports, {count}); }}

  private:
    Box body_;
}};
}}  // namespace stator::apps::{name}
"""
            (folder / f"apps/{name}/{name}.hpp").write_text(code, encoding="utf-8")
    for name in ("collector", "tuner", "switcher"):
        code = (RUN / f"{name}.hpp").read_text(encoding="utf-8")
        (folder / f"apps/{name}/{name}.hpp").write_text(code, encoding="utf-8")
