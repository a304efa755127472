"""A proof as a table, and as facts for programs."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from stator.language.keys import PROVENANCES
from stator.plan.text import text_table
from stator.prove.problems import shown_ns

if TYPE_CHECKING:
    from collections.abc import Sequence

    from stator.prove.proof import Proof

NAMES_SHOWN = 8


def facts(proof: Proof) -> dict[str, Any]:
    return {
        "proven": proof.holds,
        "graph": proof.plan.graph.name,
        "board": proof.plan.board.name,
        "weakest_provenance": proof.weakest_source,
        "load_pct": round(100 * proof.load, 3),
        "tasks": [
            {
                "name": task.name,
                "priority": task.level,
                "budget_ns": task.budget_ns,
                "provenance": task.source,
                "response_ns": task.response_ns,
                "deadline_ns": task.deadline_ns,
                "slack_ns": task.slack_ns,
                "shares": {share.name: share.cost for share in task.shares},
            }
            for task in proof.tasks
        ],
        "chains": [
            {
                "name": bound.chain.name,
                "reaction_ns": bound.reaction_ns,
                "age_ns": bound.age_ns,
                "deadline_ns": bound.deadline_ns,
            }
            for bound in proof.chains
        ],
        "queues": [
            {
                "topic": queue.topic,
                "reader": queue.reader,
                "depth": queue.depth,
                "needed": queue.needed,
                "lost": queue.lost,
            }
            for queue in proof.queues
        ],
        "memory": {
            "topic_bytes": {
                topic.name: topic.slots * topic.message.bytes
                for topic in proof.plan.topics.values()
            }
        },
    }


def text(proof: Proof, image: Sequence[str] = (), *, is_broken: bool = False) -> str:
    """`image`: lines about it. `is_broken`: whether it breaks a bound."""
    plan = proof.plan
    lines = [f"graph {plan.graph.name} on {plan.board.name}", ""]
    rows = [("task", "level", "budget", "from", "response", "deadline", "slack", "")]
    rows += [
        (
            task.name,
            str(task.level),
            shown_ns(task.budget_ns),
            task.source,
            _shown(task.response_ns),
            shown_ns(task.deadline_ns) + ("" if task.is_stated else " (period)"),
            _shown(task.slack_ns),
            "" if task.holds else "LATE",
        )
        for task in proof.tasks
    ]
    lines += text_table(rows)
    if proof.chains:
        lines += ["", *_chains(proof)]
    losing = [queue for queue in proof.queues if queue.lost != 0]
    lines += [""] if losing else []
    for queue in losing:
        lost = "has no bound" if queue.lost is None else f"can lose {queue.lost} at a time"
        lines.append(
            f"queue {queue.topic}: depth {queue.depth}, and {queue.reader} needs "
            f"{queue.needed or 'more'}: it {lost}"
        )
    lines += ["", *image] if image else []
    lines += ["", f"all tasks together take {100 * proof.load:.1f} % of the processor"]
    result = ["NOT PROVEN: the image"] if is_broken and proof.holds else verdict(proof)
    return "\n".join([*lines, *result]) + "\n"


def _chains(proof: Proof) -> list[str]:
    rows = [("chain", "reaction", "age", "deadline", "slack", "")]
    for bound in proof.chains:
        slack = None if bound.reaction_ns is None else bound.deadline_ns - bound.reaction_ns
        rows.append(
            (
                bound.chain.name,
                _shown(bound.reaction_ns),
                _shown(bound.age_ns),
                shown_ns(bound.deadline_ns),
                _shown(slack),
                "" if bound.holds else "LATE",
            )
        )
    return text_table(rows)


def _shown(value: int | None) -> str:
    return "no bound" if value is None else shown_ns(value)


def verdict(proof: Proof) -> list[str]:
    """The result, and the weakest that it rests on."""
    if not proof.holds:
        late = [t.name for t in proof.tasks if not t.holds]
        late += [bound.chain.name for bound in proof.chains if not bound.holds]
        return [f"NOT PROVEN: {', '.join(late)}"]
    source = proof.weakest_source
    names = [task.name for task in proof.tasks if task.source == source]
    costs = proof.plan.board.costs
    assert costs is not None
    if costs.source == source:
        names.insert(0, f"costs of {proof.plan.board.name}")
    shown = ", ".join(names[:NAMES_SHOWN])
    if len(names) > NAMES_SHOWN:
        shown += f" and {len(names) - NAMES_SHOWN} more"
    if source == PROVENANCES[0]:
        return [f"PROVEN ONLY IF GUESSES HOLD. Nothing has measured: {shown}"]
    if source == PROVENANCES[1]:
        return [
            "PROVEN FOR THE EMULATOR'S INSTRUCTION COUNTS, not for times measured on hardware: "
            f"{shown}"
        ]
    return ["proven; all times are measured on hardware"]
