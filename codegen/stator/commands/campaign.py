"""`./stator campaign`: flies a graph many times, with inputs that a file draws, and reports."""

from __future__ import annotations

import argparse
import json
import os
import pickle
import shlex
import subprocess
import sys
import time
from pathlib import Path
from typing import TYPE_CHECKING, Any

from stator import HOME
from stator.arguments import add_verbose_argument, path
from stator.build.cmake import build
from stator.campaign.definition import MAX_FLIGHTS, Campaign, read_campaign
from stator.campaign.draw import row_of
from stator.campaign.page import Summary, draw_found, found_text, page, summary_of
from stator.campaign.results import Results
from stator.diagnostics import NOT_DONE, in_place, shown_path
from stator.lock import Line

if TYPE_CHECKING:
    from stator.campaign.draw import Row
    from stator.campaign.worker import Kit

USUAL_PICTURES = 3
BAR = 24  # characters


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "campaign", type=path, help="campaign file, for example graph/campaigns/wind.yaml"
    )
    parser.add_argument(
        "--flights", type=_count, help="number of flights (default: as the file says, else 100)"
    )
    parser.add_argument(
        "-o",
        "--output",
        type=path,
        metavar="DIR",
        help="folder of the results; results of the same campaign there are continued (default: "
        "build/campaigns/NAME)",
    )
    parser.add_argument(
        "--workers",
        type=_count,
        default=os.cpu_count() or 1,
        help="processes of this machine (default: one for each processor)",
    )
    parser.add_argument(
        "--cluster",
        metavar="ADDRESS",
        help="a Dask cluster in place of processes of this machine, such as tcp://head:8786",
    )
    parser.add_argument(
        "--pictures",
        type=int,
        default=USUAL_PICTURES,
        metavar="N",
        help="failed flights that are flown again for their picture and log (default: 3)",
    )
    add_verbose_argument(parser)
    parser.add_argument("--json", action="store_true", help="print the result as JSON")


def main(arguments: argparse.Namespace) -> int:
    """0 if all flights were flown, whether they were successful or not."""
    campaign = read_campaign(arguments.campaign.resolve())
    count = arguments.flights or campaign.flights
    kit = _kit(campaign)
    folder = arguments.output or HOME / "build" / "campaigns" / campaign.file.stem
    results = Results(folder, campaign, _identity(campaign, kit))
    flown_before = sum(number < count for number in results.rows)
    rows = [row_of(campaign, n) for n in range(count) if n not in results.rows]
    failed = _fly(arguments, kit, rows, results, count)
    if failed:
        results.close()
        print(f"error: {len(failed)} flights were not flown: {failed[0]}", file=sys.stderr)
        print(in_place("hint: repeat the command; it flies the rest"), file=sys.stderr)
        return NOT_DONE
    table = results.finish(count)
    summary = summary_of(campaign, table)
    pictures = _fly_again(campaign, table, arguments.pictures, folder)

    def command_of(number: int) -> str:
        return in_place(f"./stator fly {_words(campaign, row_of(campaign, number))}")

    draw_found(summary, table, folder / "find.png")
    report = folder / "report.html"
    report.write_text(page(campaign, table, summary, command_of, pictures), encoding="utf-8")
    if arguments.json:
        facts = summary.as_json() | {"table": str(results.parquet.resolve())}
        facts |= {"report": str(report.resolve()), "flown_before": flown_before}
        print(json.dumps(facts, indent=2))
    else:
        _say(campaign, summary, report, results.parquet, flown_before)
    return 0


def _kit(campaign: Campaign) -> Kit:
    from stator.campaign.worker import Kit, sources_sha256

    program = build(campaign.graph, campaign.board, executor="virtual")
    return Kit(
        program=program.read_bytes(),
        plan=pickle.dumps(campaign.plan),
        files={name: file.read_bytes() for name, file in campaign.files.items()},
        by=campaign.by,
        limits=campaign.limits,
        sources=sources_sha256(),
    )


def _identity(campaign: Campaign, kit: Kit) -> str:
    """All that the results depend on, except for their number."""
    drawn = (campaign.seed, campaign.inputs, campaign.is_varied, campaign.duration_s)
    return f"{kit.sha256} {drawn} {campaign.faults} {campaign.params}"


def _fly(
    arguments: argparse.Namespace, kit: Kit, rows: list[Row], results: Results, count: int
) -> list[str]:
    if not rows:
        return []
    from stator.campaign.engine import cluster, fly_all

    line, begin_s = Line(), time.monotonic()

    def take(text: str) -> None:
        results.add(text)
        done = len(results.rows) - (count - len(rows))
        line.show(_progress(done, len(rows), count, time.monotonic() - begin_s))

    try:
        with cluster(arguments.cluster, min(arguments.workers, len(rows))) as client:
            return fly_all(client, kit, rows, take)
    except BaseException:
        results.close()  # what has ended is kept
        raise
    finally:
        line.clear()


def _progress(done: int, total: int, count: int, seconds: float) -> str:
    full = BAR * (count - total + done) // count
    left_s = seconds / done * (total - done)
    shown = f"{left_s:.0f} s" if left_s < 100 else f"{left_s / 60:.0f} min"
    bar = "#" * full + "." * (BAR - full)
    speed = f"{3600 * done / seconds:,.0f} flights an hour" if seconds > 1.0 else ""
    return f"[{bar}] {count - total + done} of {count} flown, {shown} left  {speed}".rstrip()


def _words(campaign: Campaign, row: Row) -> str:
    """The graph and what follows it, as words of `fly`."""
    words = [_place(campaign.graph)]
    words += [] if campaign.board == "sitl" else ["--board", campaign.board]
    for option, name in row.files.items():
        words += [f"--{option}", _place(campaign.files[name].resolve())]
    return shlex.join([*words, *row.words])


def _place(file: Path) -> str:
    return str(file.relative_to(HOME)) if file.is_relative_to(HOME) else str(file)


def _fly_again(
    campaign: Campaign, rows: list[dict[str, Any]], most: int, folder: Path
) -> dict[int, Path]:
    """The pictures of the first failed flights; their logs lie beside them."""
    found = {}
    for row in [row for row in rows if not row["success"]][:most]:
        log = (folder / "failed" / f"flight-{row['flight']}.ulg").resolve()
        log.parent.mkdir(exist_ok=True)
        words = shlex.split(_words(campaign, row_of(campaign, row["flight"])))
        command = [sys.executable, "-I", "-X", "utf8", "-m", "stator", "fly", *words]
        subprocess.run(
            [*command, "--no-record", "-o", str(log)], cwd=HOME, check=False, capture_output=True
        )
        if log.with_suffix(".png").is_file():
            found[row["flight"]] = log.with_suffix(".png")
    return found


def _say(
    campaign: Campaign, summary: Summary, report: Path, table: Path, flown_before: int
) -> None:
    low, high = summary.interval
    good = summary.flights - summary.failed
    print(
        f"{campaign.file.stem}: {good} of {summary.flights} flights successful, "
        f"{100 * summary.success:.2f} % (95 % interval: {100 * low:.2f} to {100 * high:.2f} %)"
    )
    if flown_before:
        print(f"  {flown_before} of them flown before")
    for each, strength, significant in summary.strengths[:5]:
        if significant:
            print(f"  failures go together with {each.label}: rank correlation {strength:+.2f}")
    if text := found_text(summary):
        print(f"  {text}")
    print(f"  report  {shown_path(report)}")
    print(f"  table   {shown_path(table)}")


def _count(text: str) -> int:
    if text.isascii() and text.isdigit() and 1 <= int(text) <= MAX_FLIGHTS:
        return int(text)
    raise argparse.ArgumentTypeError(
        f"expected a whole number from 1 to {MAX_FLIGHTS}, found '{text}'"
    )
