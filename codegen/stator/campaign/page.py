"""`report.html`: how often flights fail, which, and what the failures go together with."""

from __future__ import annotations

import base64
import io
import math
import re
from collections import Counter
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from jinja2 import Environment, FileSystemLoader, StrictUndefined

from stator.campaign.columns import INPUT_COLUMNS, LIMITED, unit_of
from stator.campaign.pictures import draw_curve, draw_spread
from stator.campaign.statistics import (
    Crossing,
    Point,
    correlation,
    crossing,
    curve,
    is_significant,
    wilson,
)

if TYPE_CHECKING:
    from collections.abc import Callable

    from stator.campaign.definition import Campaign

    Rows = list[dict[str, Any]]

MOST_FAILURES = 200
MOST_SPREADS = 9
MOST_CURVES = 6


@dataclass(frozen=True)
class Input:
    """A column that varies. `values`: numbers; of words 1 where a flight has the word."""

    name: str
    unit: str
    values: list[float]
    is_word: bool = False

    @property
    def label(self) -> str:
        return self.name if self.is_word or self.unit == "1" else f"{self.name} ({self.unit})"


@dataclass(frozen=True)
class Summary:
    """The figures of a campaign, for the page and for `--json`."""

    flights: int
    failed: int
    interval: tuple[float, float]  # of the share of good flights
    found: tuple[str, float, Crossing] | None
    strengths: list[tuple[Input, float, bool]]  # strongest first; whether it is more than chance

    @property
    def success(self) -> float:
        return 1.0 - self.failed / self.flights

    def as_json(self) -> dict[str, Any]:
        found = None
        if self.found is not None:
            name, share, at = self.found
            ends = [v if math.isfinite(v) else None for v in at]
            found = {"input": name, "failures": share, "at": ends[0], "interval": ends[1:]}
        return {
            "flights": self.flights,
            "failed": self.failed,
            "success": self.success,
            "success_interval": list(self.interval),
            "found": found,
            "correlations": [
                {"input": i.name, "rank_correlation": strength, "significant": significant}
                for i, strength, significant in self.strengths
            ],
        }


def summary_of(campaign: Campaign, rows: Rows) -> Summary:
    failed = [not row["success"] for row in rows]
    count = sum(failed)
    found = None
    if campaign.find is not None:
        name, share = campaign.find
        values = [row[INPUT_COLUMNS.get(name, name)] for row in rows]
        found = (name, share, crossing(values, failed, share))
    strengths = []
    for each in inputs_of(campaign, rows):
        strength = correlation(each.values, failed)
        strengths.append((each, strength, is_significant(strength, len(rows))))
    strengths.sort(key=lambda row: -abs(row[1]))
    return Summary(len(rows), count, wilson(len(rows) - count, len(rows)), found, strengths)


def inputs_of(campaign: Campaign, rows: Rows) -> list[Input]:
    """What differs between flights; of words one input each."""
    found = []
    for key, column in INPUT_COLUMNS.items():
        found.append(Input(key, unit_of(column), [float(row[column]) for row in rows]))
    for param in campaign.params:
        values = [float(row[param.name]) for row in rows]
        found.append(Input(param.name, param.unit, values))
    for column in ("gusts", "mission", "pilot"):
        for word in sorted({str(row[column]) for row in rows}):
            values = [float(str(row[column]) == word) for row in rows]
            found.append(Input(f"{column} {word}", "", values, is_word=True))
    names = [[text.partition("@")[0] for text in row["faults"].split()] for row in rows]
    for name in sorted({name for row in names for name in row}):
        values = [float(name in row) for row in names]
        found.append(Input(f"fault {name}", "", values, is_word=True))
    return [each for each in found if len(set(each.values)) > 1]


def page(
    campaign: Campaign,
    rows: Rows,
    summary: Summary,
    command_of: Callable[[int], str],
    pictures: dict[int, Path],
) -> str:
    """`command_of`: what flies a flight again. `pictures`: of flights."""
    environment = Environment(
        loader=FileSystemLoader(Path(__file__).parent),
        undefined=StrictUndefined,
        autoescape=True,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    failures = [row for row in rows if not row["success"]]
    low, high = summary.interval
    found = environment.get_template("report.html.j2").render(
        name=campaign.file.stem,
        doc=campaign.doc,
        flights=summary.flights,
        failed=summary.failed,
        success=f"{100 * summary.success:.2f}",
        low=f"{100 * low:.2f}",
        high=f"{100 * high:.2f}",
        state="good" if not summary.failed else "bad",
        found=found_text(summary),
        curves=_curves(summary, rows),
        strengths=[
            (each.label, f"{strength:+.3f}", significant)
            for each, strength, significant in summary.strengths
        ],
        reasons=Counter(_kind(row) for row in failures).most_common(20),
        failures=[
            (row["flight"], row["reason"], command_of(row["flight"]))
            for row in failures[:MOST_FAILURES]
        ],
        left=max(len(failures) - MOST_FAILURES, 0),
        worst=[
            (
                column,
                f"{row[column]:.4g}",
                unit_of(column),
                row["flight"],
                command_of(row["flight"]),
            )
            for column, row in _worst(rows)
        ],
        spread=_spread(rows),
        pictures=[(number, _embedded(file.read_bytes())) for number, file in pictures.items()],
    )
    return str(found)


def found_text(summary: Summary) -> str:
    """The answer to `find`; empty without the question."""
    if summary.found is None:
        return ""
    name, share, at = summary.found
    unit = next((f" {i.unit}" for i, _, _ in summary.strengths if i.name == name), "")
    wanted = f"{100 * share:g} % of flights fail"
    if not math.isfinite(at.at):
        return f"{wanted} at no {name} that was flown"
    high = f"{at.high:.4g}" if math.isfinite(at.high) else "beyond what was flown"
    return f"{wanted} at {name} {at.at:.4g}{unit} (95 % interval: {at.low:.4g} to {high})"


def _kind(row: dict[str, Any]) -> str:
    """Failures of one kind differ in their figures."""
    if row["crash"]:
        return "crash of the program"
    if row["broken_invariant"]:
        return f"broken invariant: {row['broken_invariant']}"
    text = str(row["reason"]).partition(":")[0].partition(" at ")[0]
    return re.sub(r" -?\d+\.\d+( \w+(/s)?)?$", "", text)


def draw_found(summary: Summary, rows: Rows, file: Path) -> None:
    """The curve that answers `find`, if its input varies."""
    if summary.found is None:
        return
    name, share, at = summary.found
    failed = [not row["success"] for row in rows]
    for each in [each for each, _, _ in summary.strengths if each.name == name]:
        draw_curve(curve(each.values, failed), each.label, file, (share, at))


def _curves(summary: Summary, rows: Rows) -> list[tuple[str, str]]:
    failed = [not row["success"] for row in rows]
    found = []
    for each, _, _ in [row for row in summary.strengths if not row[0].is_word][:MOST_CURVES]:
        wanted = summary.found
        asked = None if wanted is None or wanted[0] != each.name else (wanted[1], wanted[2])
        file = io.BytesIO()
        draw_curve(curve(each.values, failed), each.label, file, asked)
        found.append((each.label, _embedded(file.getvalue())))
    for each, _, _ in [row for row in summary.strengths if row[0].is_word]:
        without, having = _split(each, failed)
        text = f"{having.failed} of {having.total} failed; without it {without.failed} of "
        found.append((f"{each.label}: {text}{without.total}", ""))
    return found


def _split(each: Input, failed: list[bool]) -> tuple[Point, Point]:
    without, having = curve(each.values, failed)
    return without, having


def _worst(rows: Rows) -> list[tuple[str, dict[str, Any]]]:
    """Of each measured result the flight with the largest."""
    found = []
    for column in LIMITED:
        known = [row for row in rows if _is_finite(row[column])]
        if column != "activations" and known and len({row[column] for row in known}) > 1:
            found.append((column, max(known, key=lambda row: row[column])))
    return found


def _spread(rows: Rows) -> str:
    shown = [column for column, _ in _worst(rows)][:MOST_SPREADS]
    if not shown:
        return ""
    file = io.BytesIO()
    draw_spread(rows, shown, file)
    return _embedded(file.getvalue())


def _is_finite(value: Any) -> bool:
    return value is not None and math.isfinite(value)


def _embedded(png: bytes) -> str:
    return f"data:image/png;base64,{base64.b64encode(png).decode()}"
