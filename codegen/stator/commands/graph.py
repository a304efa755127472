"""`./stator graph`: draws a graph with Graphviz. Nodes are boxes, topics are arrows."""

from __future__ import annotations

import subprocess
from typing import TYPE_CHECKING

from stator.arguments import add_graph_arguments, path
from stator.diagnostics import UserError
from stator.pipeline import make_plan

if TYPE_CHECKING:
    import argparse
    from pathlib import Path

    from stator.graph.model import Trigger
    from stator.plan.plan import Plan, Task

FORMATS = (".svg", ".png", ".dot")
# From the least to the most urgent level: light to strong.
_URGENT = (0xE8, 0x6A, 0x33)
_PALE = (0xF4, 0xF1, 0xEA)


def add_arguments(parser: argparse.ArgumentParser) -> None:
    add_graph_arguments(parser)
    parser.add_argument(
        "-o",
        "--output",
        required=True,
        metavar="FILE",
        type=path,
        help="picture to write: .svg, .png or .dot",
    )


def main(arguments: argparse.Namespace) -> int:
    draw(make_plan(arguments.graph, arguments.board), arguments.output)
    print(f"{arguments.output}: written")
    return 0


def draw(plan: Plan, file: Path) -> None:
    """Writes the picture. Raises `UserError`."""
    if file.suffix not in FORMATS:
        raise UserError(
            f"error: expected a file name that ends in {', '.join(FORMATS)}, found '{file.name}'\n"
            "hint: write for example quad.svg"
        )
    text = dot(plan)
    if file.suffix != ".dot":
        try:
            drawn = subprocess.run(
                ["dot", f"-T{file.suffix[1:]}"],
                input=text.encode(),
                check=True,
                capture_output=True,
            ).stdout
        except FileNotFoundError:
            raise UserError(
                "error: missing program 'dot'\nhint: apt-get install graphviz"
            ) from None
        except subprocess.CalledProcessError as error:
            said = error.stderr.decode(errors="replace").strip()
            raise UserError(f"error: dot failed: {said}") from None
    else:
        drawn = text.encode()
    try:
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_bytes(drawn)
    except OSError as error:
        raise UserError(f"error: cannot write '{file}': {error.strerror}") from None


def dot(plan: Plan) -> str:
    """The graph in Graphviz's language."""
    lines = [
        f"digraph {plan.graph.name} {{",
        '  graph [rankdir=LR, nodesep=0.2, ranksep=0.4, fontname="Helvetica", bgcolor="white"];',
        '  node [shape=box, style="rounded,filled", fontname="Helvetica", fontsize=11, '
        'color="#5b5b5b", penwidth=0.8];',
        '  edge [fontname="Helvetica", fontsize=9, color="#7a7a7a", fontcolor="#4a4a4a", '
        "arrowsize=0.6];",
    ]
    lines += [_node(plan, task) for task in plan.tasks]
    for topic in plan.topics.values():
        for publisher in topic.publishers:
            for reader, _ in topic.readers:
                wakes = plan.graph.nodes[reader].trigger_of(topic.name) is not None
                style = 'penwidth=1.6, color="#2b2b2b"' if wakes else "style=dashed, weight=0"
                lines.append(f'  {publisher} -> {reader} [label="{topic.name}", {style}];')
    lines += [
        '  key [shape=plaintext, style="", fontsize=9, label="solid arrow: triggers its reader\\l'
        'dashed arrow: read as latest\\lstrong colour: urgent\\lsharp corners: owns a device\\l"];',
        "}",
    ]
    return "\n".join(lines) + "\n"


def _node(plan: Plan, task: Task) -> str:
    node = task.node
    levels = sorted({t.level for t in plan.tasks})
    share = (levels.index(task.level) + 1) / len(levels)
    colour = "#" + "".join(
        f"{round(p + (u - p) * share):02x}" for p, u in zip(_PALE, _URGENT, strict=True)
    )
    below = ", ".join(_unprompted(trigger) for trigger in node.triggers if trigger.kind != "topic")
    label = f"{node.name}\\nlevel {task.level}" + (f"\\n{below}" if below else "")
    shape = ', style=filled, penwidth=2, color="#2b2b2b"' if node.device is not None else ""
    return f'  {node.name} [label="{label}", fillcolor="{colour}"{shape}];'


def _unprompted(trigger: Trigger) -> str:
    """The text of a trigger that is not a topic."""
    return trigger.name if trigger.kind == "irq" else f"every {trigger.period_us / 1000:g} ms"
