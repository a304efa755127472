"""`./stator replay`: repeats a recorded flight, and compares every sample."""

from __future__ import annotations

import argparse
import contextlib
import hashlib
import json
from dataclasses import dataclass
from fractions import Fraction
from pathlib import Path
from typing import TYPE_CHECKING, Any

from stator import HOME
from stator.arguments import add_verbose_argument, path
from stator.build.cmake import build_replay
from stator.diagnostics import ANSWER_IS_NO, Failed, UserError, shown_path
from stator.emit.recording import definitions
from stator.flight.crash import crash_of
from stator.flight.params import Replaced, in_words, param_options
from stator.flight.progress import progress
from stator.flight.recording import Recording, fields_of, logged_sample, read_recording
from stator.pipeline import make_plan
from stator.plan.hash import graph_hash
from stator.processes import run_shown

if TYPE_CHECKING:
    from stator.plan.plan import Plan

Facts = dict[str, Any]

# The end of the log cuts the streams of the levels within a few periods of the logger.
MAX_CUT_US = 500_000


@dataclass(frozen=True)
class Subject:
    """The graph to replay with, and whether it is the recorded one."""

    plan: Plan
    same_hash: bool


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("log", type=path, help="flight log with a recording")
    parser.add_argument(
        "--graph", type=path, help="graph file, if it is not at the path in the log"
    )
    add_verbose_argument(parser)
    parser.add_argument("--json", action="store_true", help="print the result as JSON")


def main(arguments: argparse.Namespace) -> int:
    """0 if the whole recording was replayed and every sample is equal; else 1."""
    recording = read_recording(arguments.log)
    subject = find_graph(recording, arguments.graph)
    program = build_replay(subject.plan)
    with progress(f"replaying {arguments.log.name} ..."):
        command: list[str | Path] = [program, arguments.log, str(recording.good_bytes)]
        command += param_options(flown_params(recording, subject.plan))
        finished = run_shown(command)
    crash = crash_of(program, finished.stderr)
    if crash is not None:
        raise UserError(f"error: cannot replay to the end: {crash.in_words()}")
    if finished.returncode != 0:
        raise UserError(finished.stderr.rstrip() or "error: the replay program ended unexpectedly")
    facts = facts_of(recording, subject, json.loads(finished.stdout))
    if arguments.json:
        print(json.dumps(facts, indent=2))
    else:
        report(facts)
    return 0 if facts["equal"] else ANSWER_IS_NO


# --- the graph ---


def find_graph(recording: Recording, file: Path | None) -> Subject:
    name, board, shown = recording.graph()
    if file is None:
        kept = kept_graph(recording)
        places = [
            *([] if kept is None else [kept]),
            HOME / shown,
            Path(shown),
            recording.log.parent / Path(shown).name,
        ]
        file = next((place for place in places if place.is_file()), None)
    if file is None:
        raise UserError(f"error: missing graph '{shown}' of this recording\nhint: add --graph FILE")
    plan = make_plan(str(file), None)
    same_hash = graph_hash(plan) == recording.hash
    if not same_hash and board != plan.board.name:
        # Its board may have a plan of its own.
        with contextlib.suppress(Failed):
            planned = make_plan(str(file), board)
            if graph_hash(planned) == recording.hash:
                plan, same_hash = planned, True
    if not same_hash:
        _refuse_misfits(recording, plan, name)
    return Subject(plan, same_hash)


def kept_graph(recording: Recording) -> Path | None:
    """Where the graph was, from the report beside the log: a log names no place."""
    log = recording.log
    with contextlib.suppress(OSError, ValueError, AttributeError, KeyError):
        report = log.with_name(f"{log.name.removesuffix('.ulg')}.json")
        facts = json.loads(report.read_bytes())
        if facts.get("log_sha256") == hashlib.sha256(recording.data).hexdigest():
            return Path(facts["graph_file"])
    return None


def flown_params(recording: Recording, plan: Plan) -> list[Replaced]:
    """What `--param` replaced in this flight, as far as the graph has it."""
    found = []
    for name, number in recording.replaced.items():
        node, _, key = name.partition(".")
        values = plan.graph.nodes[node].params if node in plan.graph.nodes else {}
        if key in values:
            param = plan.graph.nodes[node].interface.params[key]
            value = bool(number) if param.type == "bool" else number
            exact = Fraction(value) if isinstance(value, float) else value
            found.append(Replaced(node, param, exact, values[key]))
    return found


def _refuse_misfits(recording: Recording, plan: Plan, name: str) -> None:
    """Another graph can replay a recording if it has the same nodes with the same connections."""
    now = _lines(definitions(plan, ""))
    misfits = [
        what
        for what, line in _lines(recording.lines).items()
        if what[0] in ("topic", "app", "parameters") and now.get(what) != line
    ]
    if misfits:
        shown = ", ".join(f"{kind} {what}" for kind, what in misfits[:5])
        more = f" and {len(misfits) - 5} more" if len(misfits) > 5 else ""
        raise UserError(
            f"error: expected graph '{name}' with hash {recording.hash[:12]}, found "
            f"{shown_path(plan.graph.file)} with hash {graph_hash(plan)[:12]}; missing there, or "
            f"with other fields or connections: {shown}{more}\n"
            "hint: replay with the graph that flew: --graph FILE"
        )


def _lines(lines: list[str]) -> dict[tuple[str, str], str]:
    """(kind, name) -> what must be equal. The level need not be: any order of levels replays."""
    found = {}
    for line in lines:
        words = line.split(" ")
        if words[0] == "topic":
            found[("topic", words[1])] = line
        elif words[0] == "task":
            found[(words[3], words[1])] = " ".join(words[4:])
    return found


# --- facts ---


def facts_of(recording: Recording, subject: Subject, run: Facts) -> Facts:
    _, board, _ = recording.graph()
    topics = {name: row["different"] == 0 for name, row in run["topics"].items()}
    ends = []
    if recording.problem:
        ends.append(f"the log is damaged: {recording.problem}")
    for level, lost in sorted(recording.gaps.items()):
        ends.append(
            f"the recording has a gap: level {level} lost {lost:,} activations (buffer full)"
        )
    if not ends and run["recorded_until_us"] - run["until_us"] > MAX_CUT_US:
        ends.append(f"the recording lacks an input of a node after {run['until_us'] * 1e-6:.3f} s")
    same = all(topics.values())
    return {
        "equal": same and not ends and bool(topics),
        "reason": "; ".join(ends) or ("every sample is equal" if same else "samples differ"),
        "topics": topics,
        "first_difference": _difference(recording, run["first"]) if "first" in run else None,
        "activations": run["activations"],
        "samples": sum(row["compared"] for row in run["topics"].values()),
        "different_samples": sum(row["different"] for row in run["topics"].values()),
        "replayed_until_s": run["until_us"] * 1e-6,
        "recorded_until_s": run["recorded_until_us"] * 1e-6,
        "ends_early": bool(ends),
        "graph": subject.plan.graph.name,
        "board": board,
        "graph_hash": recording.hash,
        "same_hash": subject.same_hash,
        "params": [row.as_json() for row in flown_params(recording, subject.plan)],
        "log": str(recording.log.resolve()),
    }


def _difference(recording: Recording, first: Facts) -> Facts:
    layout = recording.layouts()[first["topic"]]
    recorded = bytes.fromhex(first["recorded"])
    replayed = bytes.fromhex(first["replayed"])
    if not recorded and first["kind"] != "extra":
        recorded = logged_sample(recording, first["topic"], first["recorded_hash"]) or b""
    values = [fields_of(layout, sample) if sample else {} for sample in (recorded, replayed)]
    both = values[0].keys() & values[1].keys()
    different = (n for n in values[0] if n in both and _differ(values[0][n], values[1][n]))
    field = next(different, None)
    return {
        "kind": first["kind"],
        "topic": first["topic"],
        "sequence_number": first["number"],
        "time_s": first["now_us"] * 1e-6,
        "field": field,
        "recorded": values[0].get(field) if field else None,
        "replayed": values[1].get(field) if field else None,
        "recorded_hash": None if first["kind"] == "extra" else f"{first['recorded_hash']:08x}",
        "replayed_hash": None if first["kind"] == "missing" else f"{first['hash']:08x}",
    }


def _differ(a: float, b: float) -> bool:
    return a != b and not (a != a and b != b)  # NaN has one bit pattern in logs


# --- for people ---


def report(facts: Facts) -> None:
    from rich.console import Console

    console = Console(highlight=False, soft_wrap=True, markup=False)
    console.print(f"replay of {facts['graph']} on {facts['board']}: ", end="")
    differs = facts["first_difference"] is not None or not facts["topics"]
    style = "bold green" if facts["equal"] else "bold red"
    verdict = "NOT EQUAL" if differs else "equal" if facts["equal"] else "EQUAL, BUT INCOMPLETE"
    console.print(verdict, style=style)
    for label, text in _rows(facts):
        console.print(f"  {label:<10}{text}")


def _rows(facts: Facts) -> list[tuple[str, str]]:
    until = f"up to {facts['replayed_until_s']:.3f} s"
    counts = f"{facts['activations']:,} activations, {facts['samples']:,} samples of "
    rows = [("run", f"{counts}{len(facts['topics'])} topics, {until}")]
    if not facts["same_hash"]:
        rows.append(("graph", "it has changed since the recording (another hash), and still fits"))
    rows += [
        ("param", f"{row['name']} = {in_words(row['value'])}, as flown") for row in facts["params"]
    ]
    if facts["ends_early"]:
        rows += [("ends", reason) for reason in str(facts["reason"]).split("; ")]
    if facts["first_difference"] is not None:
        rows += _difference_rows(facts["first_difference"])
        unequal = [name for name, equal in facts["topics"].items() if not equal]
        count = f"{facts['different_samples']:,} samples"
        rows.append(("different", f"{count}, of {', '.join(unequal)}"))
    return rows


def _difference_rows(first: Facts) -> list[tuple[str, str]]:
    where = f"{first['topic']}, sample {first['sequence_number']:,}, at {first['time_s']:.6f} s"
    if first["kind"] != "value":
        what = {
            "missing": "recorded, but not published in the replay",
            "extra": "published in the replay, but not recorded",
        }
        return [("first", f"{where}: {what[first['kind']]}")]
    if first["field"] is not None:
        text = f"{first['field']}: recorded {first['recorded']!r}, replayed {first['replayed']!r}"
    else:
        hashes = f"recorded {first['recorded_hash']}, replayed {first['replayed_hash']}"
        text = f"hash: {hashes} (the log does not contain this sample)"
    return [("first", where), ("", text)]
