"""Draws a graph with Graphviz. Nodes are boxes, topics are arrows."""

from __future__ import annotations

import subprocess
from typing import TYPE_CHECKING, NamedTuple, TypeAlias

from stator.diagnostics import UserError, nearest

if TYPE_CHECKING:
    from pathlib import Path

    from stator.graph.model import Trigger
    from stator.plan.plan import Plan, Task

FORMATS = (".svg", ".png", ".dot")
BREAK = " \\n "  # of a label, in Graphviz's language


class Theme(NamedTuple):
    background: str
    text: str
    line: str
    strong: str
    # From the least to the most urgent level.
    pale: tuple[int, int, int]
    urgent: tuple[int, int, int]


LIGHT = Theme("white", "#1f1f1f", "#8a8a8a", "#2b2b2b", (0xF4, 0xF1, 0xEA), (0xE8, 0x6A, 0x33))
DARK = Theme("#0d1117", "#e6edf3", "#7d8590", "#c9d1d9", (0x1C, 0x23, 0x2D), (0xA8, 0x45, 0x16))


SINGLE_COLUMNS = 5
Arrow: TypeAlias = tuple[str, str, str]  # publisher, reader, topic


class View(NamedTuple):
    """What of the graph is drawn, and how."""

    around: str | None = None
    wakes: bool = False
    dark: bool = False


def draw(plan: Plan, file: Path, view: View | None = None) -> None:
    """Writes the picture. Raises `UserError`."""
    if file.suffix not in FORMATS:
        raise UserError(
            f"error: expected a file name that ends in {', '.join(FORMATS)}, found '{file.name}'\n"
            "hint: write for example quad.svg"
        )
    form = file.suffix[1:]
    drawn = dot(plan, view).encode() if form == "dot" else rendered(plan, form, view)
    try:
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_bytes(drawn)
    except OSError as error:
        raise UserError(f"error: cannot write '{file}': {error.strerror}") from None


def rendered(plan: Plan, form: str, view: View | None = None) -> bytes:
    """The picture in a format of Graphviz. Raises `UserError`."""
    try:
        return subprocess.run(
            ["dot", f"-T{form}"],
            input=dot(plan, view).encode(),
            check=True,
            capture_output=True,
        ).stdout
    except FileNotFoundError:
        raise UserError("error: missing program 'dot'\nhint: apt-get install graphviz") from None
    except subprocess.CalledProcessError as error:
        said = error.stderr.decode(errors="replace").strip()
        raise UserError(f"error: dot failed: {said}") from None


def dot(plan: Plan, view: View | None = None) -> str:
    """The graph in Graphviz's language. Arrows that wake their reader have the topic's name; what a
    node reads besides stands in its box, as many names on crossing arrows cannot be read."""
    view = view or View()
    shown = _around(plan, view)
    links = _links(plan, shown, view)
    theme = _theme(view)
    lines = [
        f"digraph {plan.graph.name} {{",
        f'  graph [rankdir=TB, nodesep=0.25, ranksep=0.35, fontname="Helvetica", '
        f'bgcolor="{theme.background}"];',
        f'  node [shape=box, style="rounded,filled", fontname="Helvetica", fontsize=11, '
        f'color="{theme.line}", fontcolor="{theme.text}", penwidth=0.8, margin="0.09,0.05"];',
        f'  edge [fontname="Helvetica", fontsize=9, color="{theme.line}", '
        f'fontcolor="{theme.text}", arrowsize=0.6];',
    ]
    for task in plan.tasks:
        if task.node.name in shown:
            lines.append(_node(plan, task, [t for _, r, t in links if r == task.node.name], view))
    lines += _wakes(plan, links, theme)
    lines += _rows_of_single(plan, links) if view.wakes else _reads(plan, links, theme)
    lines += [_key(view, theme), "}"]
    return "\n".join(lines) + "\n"


def _theme(view: View) -> Theme:
    return DARK if view.dark else LIGHT


def _around(plan: Plan, view: View) -> set[str]:
    """All nodes; or those that share a topic with one."""
    if view.around is None:
        return set(plan.graph.nodes)
    if view.around not in plan.graph.nodes:
        raise UserError(
            f"error: unknown node '{view.around}' of {plan.graph.name}\n"
            f"hint: {nearest(view.around, plan.graph.nodes)}"
        )
    shown = {view.around}
    for topic in plan.topics.values():
        readers = [
            name
            for name, _ in topic.readers
            if not view.wakes or plan.graph.nodes[name].trigger_of(topic.name) is not None
        ]
        if view.around in topic.publishers:
            shown.update(readers)
        if view.around in readers:
            shown.update(topic.publishers)
    return shown


def _wakes(plan: Plan, links: list[Arrow], theme: Theme) -> list[str]:
    """One arrow for each pair, with all topics by which it wakes."""
    pairs: dict[tuple[str, str], list[str]] = {}
    for publisher, reader, topic in links:
        if plan.graph.nodes[reader].trigger_of(topic) is not None:
            pairs.setdefault((publisher, reader), []).append(topic)
    return [
        f'  {publisher} -> {reader} [label=" {BREAK.join(topics)} ", penwidth=1.6, '
        f'color="{theme.strong}", weight=4];'
        for (publisher, reader), topics in pairs.items()
    ]


def _reads(plan: Plan, links: list[Arrow], theme: Theme) -> list[str]:
    """Arrows of what does not wake, without names."""
    wakes = {
        (publisher, reader)
        for publisher, reader, topic in links
        if plan.graph.nodes[reader].trigger_of(topic) is not None
    }
    pairs = dict.fromkeys((p, r) for p, r, _ in links if (p, r) not in wakes)
    urgency = {task.node.name: task.level for task in plan.tasks}
    return [
        f'  {publisher} -> {reader} [style=dashed, color="{theme.line}", penwidth=0.7, '
        f"weight=0{', constraint=false' if urgency[publisher] < urgency[reader] else ''}];"
        for publisher, reader in pairs
    ]


def _rows_of_single(plan: Plan, links: list[Arrow]) -> list[str]:
    """Invisible arrows, so that nodes without an arrow stand in several rows."""
    woken = {
        name
        for publisher, reader, topic in links
        if plan.graph.nodes[reader].trigger_of(topic) is not None
        for name in (publisher, reader)
    }
    single = [task.node.name for task in plan.tasks if task.node.name not in woken]
    pairs = zip(single, single[SINGLE_COLUMNS:], strict=False)
    return [f"  {upper} -> {lower} [style=invis];" for upper, lower in pairs]


def _links(plan: Plan, shown: set[str], view: View) -> list[Arrow]:
    """All; around a node, only its own."""
    return [
        (publisher, reader, topic.name)
        for topic in plan.topics.values()
        for publisher in topic.publishers
        for reader, _ in topic.readers
        if publisher in shown and reader in shown and publisher != reader
        if view.around is None or view.around in (publisher, reader)
    ]


def _node(plan: Plan, task: Task, topics: list[str], view: View) -> str:
    """`topics`: what it reads in this picture."""
    node, theme = task.node, _theme(view)
    levels = sorted({t.level for t in plan.tasks})
    share = (levels.index(task.level) + 1) / len(levels)
    colour = "#" + "".join(
        f"{round(p + (u - p) * share):02x}" for p, u in zip(theme.pale, theme.urgent, strict=True)
    )
    below = ", ".join(_unprompted(trigger) for trigger in node.triggers if trigger.kind != "topic")
    small = [f"level {task.level}" + (f", {below}" if below else "")]
    if not view.wakes:
        read = [
            s.topic
            for s in node.inputs.values()
            if node.trigger_of(s.topic) is None and s.topic in topics
        ]
        small += [f"<I>{topic}</I>" for topic in read]
    rows = "<BR/>".join(small)
    label = f'<<B>{node.name}</B><BR/><FONT POINT-SIZE="8">{rows}</FONT>>'
    shape = f', style=filled, penwidth=2, color="{theme.strong}"' if node.device is not None else ""
    if node.name == view.around:
        shape += ", peripheries=2"
    return f'  {node.name} [label={label}, fillcolor="{colour}"{shape}];'


def _key(view: View, theme: Theme) -> str:
    rows = ["arrow with a topic: wakes its reader"]
    if not view.wakes:
        rows.append("dashed arrow: is read as well; topics in italics, in the reader")
    rows += ["strong colour: urgent", "sharp corners: owns a device"]
    label = "".join(f"{row}\\l" for row in rows)
    return f'  key [shape=plaintext, style="", fontsize=9, label="{label}"];'


def _unprompted(trigger: Trigger) -> str:
    """The text of a trigger that is not a topic."""
    return trigger.name if trigger.kind == "irq" else f"every {trigger.period_us / 1000:g} ms"
