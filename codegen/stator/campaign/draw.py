"""A row of a campaign: what the flight of this number is flown with. A function of the campaign and
the number, so it is the same whatever has flown before, and wherever."""

from __future__ import annotations

import random
from typing import TYPE_CHECKING, Any, NamedTuple

from stator.campaign.columns import INPUT_COLUMNS
from stator.campaign.definition import fault_text
from stator.flight.faults import RANDOM

if TYPE_CHECKING:
    from stator.campaign.definition import Campaign, DrawnFault

SEEDS = 2**32


class Row(NamedTuple):
    """`words`: of the command line of `fly`, behind the graph, without files. `files`: by option,
    the name in the campaign. `columns`: of the results."""

    flight: int
    words: tuple[str, ...]
    files: dict[str, str]
    columns: dict[str, Any]


def row_of(campaign: Campaign, number: int, params: dict[str, float] | None = None) -> Row:
    """`params`: values in place of those that are drawn, as a search sets them."""

    def drawn(key: str) -> Any:
        found = campaign.inputs.get(key)
        return None if found is None else found.draw(key, campaign.seed, number)

    seed = random.Random(f"campaign {campaign.seed}, flight {number}: seed").randrange(SEEDS)
    words = ["--seed", str(seed)]
    columns: dict[str, Any] = {"flight": number, "seed": seed}
    words += ["--vary"] if campaign.is_varied else []
    columns["vehicle_varies"] = campaign.is_varied
    if campaign.duration_s is not None:
        words += ["--duration", f"{campaign.duration_s:g}"]
    for key, option in (("wind", "--wind"), ("wind_from", "--wind-from")):
        value = drawn(key)
        columns[INPUT_COLUMNS[key]] = 0.0 if value is None else float(value)
        words += [] if not value else [option, f"{value:g}"]
    gusts = drawn("gusts") or "none"
    columns["gusts"] = gusts
    words += [] if gusts == "none" else ["--gusts", gusts]
    files = {key: str(drawn(key)) for key in ("mission", "pilot") if drawn(key) is not None}
    columns |= {key: files.get(key) for key in ("mission", "pilot")}
    faults = [_fault(campaign, number, i, fault) for i, fault in enumerate(campaign.faults)]
    fails = [text for text in faults if text]
    columns["faults"] = " ".join(fails)
    words += [word for text in fails for word in ("--fail", text)]
    for param in campaign.params:
        value = (params or {}).get(param.name)
        value = param.value.draw(param.name, campaign.seed, number) if value is None else value
        columns[param.name] = value
        words += ["--param", f"{param.name}={_shown(value, param.unit)}"]
    return Row(number, tuple(words), files, columns)


def _fault(campaign: Campaign, number: int, i: int, fault: DrawnFault) -> str:
    """As `--fail` reads it; empty if this flight does not have it."""
    key = f"fault {i}"
    source = random.Random(f"campaign {campaign.seed}, flight {number}: {key}")
    if source.random() >= fault.chance:
        return ""
    if fault.name == RANDOM:
        return f"{RANDOM}={1 if fault.value is None else _of(campaign, number, fault.value, key):g}"
    assert fault.at is not None
    at_s = _of(campaign, number, fault.at, f"{key} at")
    lasts_s = None if fault.lasts is None else _of(campaign, number, fault.lasts, f"{key} lasts")
    value = None if fault.value is None else _of(campaign, number, fault.value, f"{key} value")
    return fault_text(fault.name, value, at_s, lasts_s)


def _of(campaign: Campaign, number: int, drawn: Any, key: str) -> float:
    return float(drawn.draw(key, campaign.seed, number))


def _shown(value: Any, unit: str) -> str:
    """With its unit, as `--param` reads it."""
    if isinstance(value, bool):
        return str(value).lower()
    return f"{value:g}" if unit == "1" else f"{value:g} {unit}"
