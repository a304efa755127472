"""`proof.html`: what an engineer shows in a review of a proof."""

from __future__ import annotations

import re
import subprocess
from colorsys import hls_to_rgb
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from jinja2 import Environment, FileSystemLoader, StrictUndefined

from stator.prove.problems import shown_ns
from stator.prove.proof import utilisation
from stator.prove.report import verdict
from stator.prove.timeline import timeline

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from stator.plan.plan import Plan
    from stator.prove.proof import Proof, TaskBound

GOLDEN_ANGLE = 137.5  # degrees: neighbours in a list get hues that differ
FULL = 100.0


@dataclass(frozen=True)
class Bar:
    """A figure against its limit."""

    name: str
    shown: str
    limit: str
    pct: float  # of the limit
    note: str = ""

    @property
    def width(self) -> str:
        return f"{min(self.pct, FULL):.2f}"

    @property
    def is_broken(self) -> bool:
        return self.pct > FULL


@dataclass(frozen=True)
class Piece:
    """Of a timeline, in per cent of its length."""

    name: str
    left: str
    width: str
    colour: str
    title: str


@dataclass(frozen=True)
class Lane:
    """The worst window of a task."""

    bar: Bar
    level: int
    budget: str
    source: str
    slack: str
    length: str
    pieces: list[Piece]
    shares: list[tuple[str, str, str]]  # colour, name, time


def page(proof: Proof, image: Mapping[str, Any] | None, *, is_broken: bool = False) -> str:
    """`image`: facts of its stack and memory, as `prove --json` has them. `is_broken`: whether
    these break a bound."""
    environment = Environment(
        loader=FileSystemLoader(Path(__file__).parent),
        undefined=StrictUndefined,
        autoescape=True,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    names = [job.name for job in proof.solutions[0].jobs]
    names += [share.name for task in proof.tasks for share in task.shares]
    colours = {name: _colour(i) for i, name in enumerate(dict.fromkeys(names))}
    holds = proof.holds and not is_broken
    found = environment.get_template("proof.html.j2").render(
        graph=proof.plan.graph.name,
        board=proof.plan.board.name,
        state=("bad" if not holds else "good" if proof.weakest_source == "hardware" else "guess"),
        verdict=["NOT PROVEN: the image"] if proof.holds and is_broken else verdict(proof),
        load=f"{FULL * proof.load:.1f}",
        picture=_picture(proof),
        chains=[_chain_bar(proof, i) for i in range(len(proof.chains))],
        lanes=[_lane(task, colours) for task in proof.tasks],
        stack=[] if image is None else _stack(image),
        stack_levels=[] if image is None else _levels(image),
        memory=[] if image is None else _memory(image["memory"]),
        nodes=[] if image is None else _nodes(image["memory"]),
    )
    return str(found)


def _chain_bar(proof: Proof, i: int) -> Bar:
    bound = proof.chains[i]
    if bound.reaction_ns is None or bound.age_ns is None:
        return Bar(bound.chain.name, "no bound", shown_ns(bound.deadline_ns), 2 * FULL)
    pct = FULL * bound.reaction_ns / bound.deadline_ns
    note = f"{' > '.join(bound.chain.path)}; data age {shown_ns(bound.age_ns)}"
    limit = shown_ns(bound.deadline_ns)
    return Bar(bound.chain.name, shown_ns(bound.reaction_ns), limit, pct, note)


def _lane(task: TaskBound, colours: Mapping[str, str]) -> Lane:
    limit = shown_ns(task.deadline_ns)
    if task.response_ns is None or task.slack_ns is None:
        bar = Bar(task.name, "no bound", limit, 2 * FULL)
        return Lane(bar, task.level, shown_ns(task.budget_ns), task.source, "none", "", [], [])
    runs = timeline(task)
    end = runs[-1].end
    pieces = [
        Piece(
            run.name,
            f"{FULL * run.begin / end:.3f}",
            f"{FULL * (run.end - run.begin) / end:.3f}",
            colours[run.name],
            f"{run.name}: {shown_ns(run.begin)} to {shown_ns(run.end)}",
        )
        for run in runs
    ]
    shares = [(colours[s.name], s.name, shown_ns(s.cost)) for s in task.shares]
    bar = Bar(
        task.name, shown_ns(task.response_ns), limit, FULL * task.response_ns / task.deadline_ns
    )
    return Lane(
        bar,
        task.level,
        shown_ns(task.budget_ns),
        task.source,
        shown_ns(task.slack_ns),
        shown_ns(end),
        pieces,
        shares,
    )


def _stack(image: Mapping[str, Any]) -> list[Bar]:
    rows = (("stack", ""), ("stack of the fault handler", "fault_"))
    return [
        _bytes(name, image[f"{key}stack_bytes"], image[f"{key}stack_limit_bytes"])
        for name, key in rows
    ]


def _levels(image: Mapping[str, Any]) -> list[Bar]:
    """The worst of each level, against the whole."""
    worst: dict[int, dict[str, Any]] = {}
    for row in image["stack"]:
        size = row["bytes"] + row["frame_bytes"]
        if size > sum(worst.get(row["level"], {}).get(k, 0) for k in ("bytes", "frame_bytes")):
            worst[row["level"]] = row
    found = []
    for level, row in sorted(worst.items(), reverse=True):
        size = row["bytes"] + row["frame_bytes"]
        name = f"level {level}: {row['name']}" if level else row["name"]
        pct = FULL * size / image["stack_bytes"]
        found.append(Bar(name, f"{size:,} bytes", "", pct, f"{row['frame_bytes']} of an exception"))
    return found


def _memory(memory: Mapping[str, Any]) -> list[Bar]:
    return [
        _bytes(name, memory[f"{key}_bytes"], memory[f"{key}_limit_bytes"])
        for name, key in (("flash", "flash"), ("RAM", "ram"))
    ]


def _nodes(memory: Mapping[str, Any]) -> list[tuple[str, str, str]]:
    rows = sorted(memory["nodes"].items(), key=lambda item: -item[1]["flash_bytes"])
    return [(n, f"{sizes['flash_bytes']:,}", f"{sizes['ram_bytes']:,}") for n, sizes in rows]


def _bytes(name: str, used: int, limit: int) -> Bar:
    return Bar(name, f"{used:,} bytes", f"{limit:,} bytes", FULL * used / limit)


def _colour(i: int) -> str:
    red, green, blue = hls_to_rgb(i * GOLDEN_ANGLE % 360 / 360, 0.58, 0.55)
    return f"#{round(255 * red):02x}{round(255 * green):02x}{round(255 * blue):02x}"


def _picture(proof: Proof) -> str:
    """The graph as SVG; without Graphviz there is none."""
    try:
        drawn = subprocess.run(
            ["dot", "-Tsvg"],
            input=_dot(proof.plan, utilisation(proof)),
            check=True,
            capture_output=True,
            text=True,
        ).stdout
    except (FileNotFoundError, subprocess.CalledProcessError):
        return ""
    svg = drawn[drawn.index("<svg") :]
    return re.sub(r'<svg width="[^"]*" height="[^"]*"', '<svg class="graph"', svg, count=1)


def _dot(plan: Plan, load: Mapping[str, float]) -> str:
    """Nodes with what they take of the processor; an arrow wakes its reader."""
    lines = [
        "digraph graph_of_the_proof {",
        'graph [bgcolor="transparent", ranksep=0.3, nodesep=0.2];',
        'node [shape=box, style="rounded,filled", fontname="Helvetica", fontsize=11];',
        'edge [fontname="Helvetica", fontsize=8, color="#666666", arrowsize=0.6];',
    ]
    for task in plan.tasks:
        name = task.node.name
        share = load.get(name, 0.0)
        shade = f"0.07 {min(1.0, 0.05 + share):.3f} 1.0"
        label = f"{name}\\nlevel {task.level}, {FULL * share:.2f} %"
        lines.append(f'"{name}" [label="{label}", fillcolor="{shade}"];')
    lines += _arrows(plan)
    return "\n".join([*lines, "}"])


def _arrows(plan: Plan) -> Sequence[str]:
    return [
        f'"{publisher}" -> "{reader}" [label="{topic.name}"];'
        for topic in plan.topics.values()
        for publisher in topic.publishers
        for reader, _ in topic.readers
        if publisher != reader and plan.graph.nodes[reader].trigger_of(topic.name) is not None
    ]
