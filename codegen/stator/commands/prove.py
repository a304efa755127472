"""`./stator prove`: the worst response time of each task and chain against its deadline, and the
worst case of the stack and the memory of the image."""

from __future__ import annotations

import json
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Any

from stator import HOME
from stator.arguments import add_graph_arguments, path
from stator.build.cmake import build, short_name
from stator.diagnostics import ANSWER_IS_NO, UserError, in_place, shown_path
from stator.image.handlers import stack_of_graph
from stator.image.memory import memory_of
from stator.image.report import memory_facts, memory_text, stack_facts, stack_text
from stator.pipeline import make_plan
from stator.prove.changes import shortest_period_us
from stator.prove.needs import require_provable
from stator.prove.problems import problems
from stator.prove.proof import prove
from stator.prove.report import facts, text
from stator.review.page import page

if TYPE_CHECKING:
    import argparse

    from stator.image.memory import Memory
    from stator.image.stack import Stack
    from stator.plan.plan import Plan

PAGE = "proof.html"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    add_graph_arguments(parser)
    parser.add_argument(
        "--max-rate",
        metavar="NODE",
        help="find the shortest period of this node's line or timer with which all still holds",
    )
    parser.add_argument(
        "-o",
        "--output",
        metavar="FOLDER",
        type=path,
        help="where proof.html and proof.json go (default: below build/proofs)",
    )
    parser.add_argument(
        "--no-image", action="store_true", help="times only: builds no image for stack and memory"
    )
    parser.add_argument("--json", action="store_true", help="print the result as JSON")


def main(arguments: argparse.Namespace) -> int:
    plan = make_plan(arguments.graph, arguments.board)
    require_provable(plan)
    if arguments.max_rate is not None:
        return _max_rate(plan, arguments)
    proof = prove(plan)
    errors = problems(proof)
    image = None if arguments.no_image else _image(plan, arguments)
    broken = [] if image is None else [*image[0].faults, *image[0].overflows()]
    holds = proof.holds and not broken
    shown = {**facts(proof), "stack_bytes": None, "stack_limit_bytes": None, "proven": holds}
    if image is not None:
        shown |= stack_facts(image[0])
        shown["memory"] |= memory_facts(plan, image[1])
    shown["errors"] = [error.as_json() for error in errors]
    shown["image_errors"] = broken
    folder = _folder(plan, arguments, has_image=image is not None)
    if folder is not None:
        _write(folder, shown, page(proof, shown if image else None, is_broken=bool(broken)))
    if arguments.json:
        print(json.dumps(shown, indent=2))
        return 0 if holds else ANSWER_IS_NO
    lines = _image_lines(plan, image, arguments)
    if folder is not None:
        lines += ["", f"{shown_path(folder / PAGE)}: written"]
    print(text(proof, lines, is_broken=bool(broken)), end="")
    sys.stdout.flush()
    for error in [*(error.text() for error in errors), *broken]:
        print(in_place(f"\n{error}"), file=sys.stderr)
    return 0 if holds else ANSWER_IS_NO


def _folder(plan: Plan, arguments: argparse.Namespace, *, has_image: bool) -> Path | None:
    """Without an image, only where the user wants the files."""
    if arguments.output is not None or not has_image:
        folder: Path | None = arguments.output
        return folder
    return HOME / "build" / "proofs" / f"{short_name(plan.graph.file)}-{plan.board.name}"


def _write(folder: Path, shown: dict[str, Any], html: str) -> None:
    try:
        folder.mkdir(parents=True, exist_ok=True)
        (folder / PAGE).write_text(html, encoding="utf-8")
        (folder / "proof.json").write_text(json.dumps(shown, indent=2) + "\n", encoding="utf-8")
    except OSError as error:
        raise UserError(f"error: cannot write to '{folder}': {error.strerror}") from None


def _image(plan: Plan, arguments: argparse.Namespace) -> tuple[Stack, Memory] | None:
    """None: its board has no code. Raises `BuildFailed`."""
    if not any(plan.board.file.parent.glob("*.cpp")):
        return None
    image = build(Path(arguments.graph), arguments.board, executor="cortex_m")
    return stack_of_graph(plan, image), memory_of(plan, image)


def _image_lines(
    plan: Plan, image: tuple[Stack, Memory] | None, arguments: argparse.Namespace
) -> list[str]:
    if image is None:
        why = "--no-image" if arguments.no_image else f"board {plan.board.name} has no code"
        return [f"stack and memory: not computed ({why})"]
    return [*memory_text(plan, image[1]), "", *stack_text(image[0])]


def _max_rate(plan: Plan, arguments: argparse.Namespace) -> int:
    name = arguments.max_rate
    us = shortest_period_us(plan, name)
    if arguments.json:
        print(json.dumps({"node": name, "shortest_period_us": us}, indent=2))
    elif us is None:
        print(f"{name}: the graph is not proven with its own rate; see ./stator prove without it")
    else:
        print(f"{name}: proven down to {us} us ({1e6 / us:.0f} Hz)")
    return ANSWER_IS_NO if us is None else 0
