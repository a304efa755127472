"""The file of a campaign: what varies from flight to flight, and what counts. docs/campaigns.md"""

from __future__ import annotations

from dataclasses import dataclass, field
from fractions import Fraction
from typing import TYPE_CHECKING, Any

from stator.campaign.columns import LIMITED, unit_of
from stator.campaign.distribution import Distribution, Drawn, Words
from stator.diagnostics import Report, UserError
from stator.flight.arguments import MAX_DURATION_S, MAX_WIND_M_S
from stator.flight.faults import LATEST_S, RANDOM, Faults
from stator.graph.value import read_value
from stator.language import yaml_tree
from stator.language.nested import Key, Listing, Struct, Table
from stator.language.quantity import Quantity
from stator.language.shapes import Choice, Integer, Leaf, Raw, Record, Text, scalar
from stator.pipeline import make_plan

if TYPE_CHECKING:
    from pathlib import Path

    from stator.diagnostics import Mark
    from stator.graph.model import Param
    from stator.language.yaml_tree import Tree
    from stator.plan.plan import Plan

MAX_FLIGHTS = 10_000_000
USUAL_FLIGHTS = 100
PARAM = r"[a-z][a-z0-9_]*\.[a-z][a-z0-9_]*"


def _drawn(unit: str, least: float, most: float, doc: str) -> Key:
    return Key(Drawn(Quantity(unit, least, most)), doc)


@dataclass(frozen=True)
class _Any:
    """Kept as it is: what it may be depends on the graph."""

    def read(self, tree: Tree, report: Report) -> Tree:
        return tree

    def schema(self) -> dict[str, Any]:
        return {}


FAULT = Struct(
    {
        "fault": Key(Text(), "The part and its fault, such as baro0.stuck.", required=True),
        "chance": Key(Quantity("1", 0.0, 1.0), "The share of flights that have it. Default: all."),
        "at": _drawn("s", 0.0, LATEST_S, "When it begins."),
        "lasts": _drawn("s", 0.0, LATEST_S, "How long it lasts. Default: to the end."),
        "value": _drawn("1", -1e6, 1e6, "How strong it is, in the unit of the fault."),
    }
)
FLIGHT = Struct(
    {
        "mission": Key(Words(), "Mission files. Default: the graph's own flight."),
        "pilot": Key(Words(), "Scripts of the pilot."),
        "vehicle": Key(
            Choice(("nominal", "varied")),
            "Whether its mass, inertia and so on vary with the seed. Default: nominal.",
        ),
        "wind": _drawn("m/s", 0.0, MAX_WIND_M_S, "The mean wind."),
        "wind_from": _drawn("deg", -360.0, 360.0, "The direction that the wind comes from."),
        "gusts": Key(Words(("none", "light", "moderate", "severe")), "Gusts as in MIL-F-8785C."),
        "duration": Key(Quantity("s", 0.001, MAX_DURATION_S), "The longest flight."),
        "faults": Key(Listing(FAULT), "Failures of parts of the graph."),
        "params": Key(
            Table(_Any(), "a parameter", PARAM), "Parameters of nodes, as NODE.PARAMETER."
        ),
    }
)
LIMIT = Struct(
    {"least": Key(Raw(), "The lowest good value."), "most": Key(Raw(), "The highest good value.")}
)
CAMPAIGN = Struct(
    {
        "doc": Key(Text(), "The question that the campaign answers."),
        "graph": Key(Text(), "The graph file, relative to this one.", required=True),
        "board": Key(Text(), "A board with a simulated world. Default: sitl."),
        "flights": Key(Integer(1, MAX_FLIGHTS), "The number of flights. Default: 100."),
        "seed": Key(Integer(0), "The seed of all that is drawn. Default: 1."),
        "flight": Key(FLIGHT, "What each flight is flown with.", required=True),
        "success": Key(
            Struct(
                {
                    "by": Key(
                        Choice(("judgement", "invariants")),
                        "Whether all that `fly` judges counts (default), or the invariants only.",
                    ),
                    "limits": Key(
                        Table(LIMIT, "a column"), "Limits of columns of the results, as well."
                    ),
                }
            ),
            "What counts as success.",
        ),
        "find": Key(
            Struct(
                {
                    "input": Key(Text(), "The input that varies, such as wind.", required=True),
                    "failures": Key(Quantity("1", 0.0, 1.0), "The share of failed flights.", True),
                }
            ),
            "Find the value at which this share of flights fails.",
        ),
    }
)


@dataclass(frozen=True)
class DrawnFault:
    name: str
    chance: float
    at: Distribution | None
    lasts: Distribution | None
    value: Distribution | None


@dataclass(frozen=True)
class DrawnParam:
    name: str
    unit: str
    value: Distribution


@dataclass(frozen=True)
class Limit:
    column: str
    least: float | None
    most: float | None


@dataclass(frozen=True)
class Campaign:
    file: Path
    doc: str
    graph: Path
    board: str
    flights: int
    seed: int
    inputs: dict[str, Distribution]  # wind, wind_from, gusts, mission, pilot
    is_varied: bool
    duration_s: float | None
    faults: tuple[DrawnFault, ...]
    params: tuple[DrawnParam, ...]
    by: str
    limits: tuple[Limit, ...]
    find: tuple[str, float] | None
    plan: Plan = field(compare=False)

    @property
    def files(self) -> dict[str, Path]:
        """Missions and scripts, by the name in the file."""
        names = [n for key in ("mission", "pilot") for n in _words(self.inputs.get(key))]
        return {name: self.file.parent / name for name in names}


def _words(drawn: Distribution | None) -> list[str]:
    return [] if drawn is None else [str(value) for value in drawn.values]


def read_campaign(file: Path) -> Campaign:
    """Raises `Failed` with every error of the file, and of its graph."""
    report = Report()
    tree = yaml_tree.load(file, report)
    record: Record | None = None if tree is None else CAMPAIGN.read(tree, report)
    report.stop_on_errors()
    assert record is not None
    graph = (file.parent / record.value("graph")).resolve()
    if not graph.is_file():
        report.error(
            record.get("graph").mark,
            "file-missing",
            f"missing graph file '{record.value('graph')}'",
            "write its path relative to this file",
        )
        report.stop_on_errors()
    plan = make_plan(str(graph), record.value("board", "sitl"))
    campaign = _Reader(file, plan, report).read(record, graph)
    report.stop_on_errors()
    return campaign


class _Reader:
    """Reads what depends on the graph."""

    def __init__(self, file: Path, plan: Plan, report: Report) -> None:
        self._file, self._plan, self._report = file, plan, report
        self._faults = Faults(plan)

    def read(self, record: Record, graph: Path) -> Campaign:
        flight: Record = record.get("flight")
        success = record.get("success") or Record({}, record.mark, {}, record.mark)
        names = ("mission", "pilot", "wind", "wind_from", "gusts")
        inputs = {name: flight.value(name) for name in names if flight.get(name) is not None}
        for name in ("mission", "pilot"):
            self._check_files(flight, name)
        faults = [self._fault(row) for row in flight.value("faults", [])]
        table: Record = flight.get("params") or Record({}, record.mark, {}, record.mark)
        params = [self._param(name, tree, table.keys[name]) for name, tree in table.values.items()]
        limits: Record = success.get("limits") or Record({}, record.mark, {}, record.mark)
        return Campaign(
            file=self._file,
            doc=record.value("doc", ""),
            graph=graph,
            board=record.value("board", "sitl"),
            flights=record.value("flights", USUAL_FLIGHTS),
            seed=record.value("seed", 1),
            inputs=inputs,
            is_varied=flight.value("vehicle", "nominal") == "varied",
            duration_s=flight.value("duration"),
            faults=tuple(fault for fault in faults if fault is not None),
            params=tuple(param for param in params if param is not None),
            by=success.value("by", "judgement"),
            limits=tuple(
                self._limit(name, row, limits.keys[name]) for name, row in limits.values.items()
            ),
            find=self._find(record, flight),
            plan=self._plan,
        )

    def _check_files(self, flight: Record, name: str) -> None:
        leaf = flight.get(name)
        for word in [] if leaf is None else leaf.value.values:
            if not (self._file.parent / word).is_file():
                self._report.error(
                    leaf.mark,
                    "file-missing",
                    f"missing {name} file '{word}'",
                    "write its path relative to this file",
                )

    def _fault(self, row: Record) -> DrawnFault | None:
        leaf = row.get("fault")
        if leaf is None:
            return None
        drawn = DrawnFault(
            leaf.value,
            row.value("chance", 1.0),
            row.value("at"),
            row.value("lasts"),
            row.value("value"),
        )
        if leaf.value != RANDOM and drawn.at is None:
            self._report.error(
                row.mark, "missing-key", "missing key 'at'", "add `at`: when it begins"
            )
            return None
        try:
            for value in [None] if drawn.value is None else drawn.value.ends:
                if leaf.value != RANDOM:
                    self._faults.read(fault_text(leaf.value, value, 0.0, None))
        except UserError as error:
            what, _, hint = str(error).partition("\n")
            what = what.partition(": ")[2].partition(": ")[2]  # the fault has its place here
            self._report.error(leaf.mark, "wrong-type", what, hint.removeprefix("hint: "))
            return None
        return drawn

    def _param(self, name: str, tree: Tree, mark: Mark) -> DrawnParam | None:
        node, _, key = name.partition(".")
        found = self._plan.graph.nodes.get(node)
        param: Param | None = None if found is None else found.interface.params.get(key)
        if param is None:
            known = [f"{n.name}.{p}" for n in self._plan.graph.nodes.values() for p in n.params]
            self._report.error(
                mark,
                "param-unknown",
                f"unknown parameter '{name}'",
                self._report.nearest(name, known),
            )
            return None
        leaf = Drawn(_OfParam(param)).read(tree, self._report)
        if leaf is None:
            return None
        drawn: Distribution = leaf.value
        least, most = (None if b is None else float(b) for b in (param.least, param.most))
        return DrawnParam(name, param.unit, drawn.within(least, most))

    def _limit(self, name: str, row: Record, mark: Mark) -> Limit:
        if name not in LIMITED:
            self._report.error(
                mark, "unknown-key", f"unknown column '{name}'", self._report.nearest(name, LIMITED)
            )
            return Limit(name, None, None)
        if not row.values:
            self._report.error(
                mark, "missing-key", "missing key 'most' or 'least'", "add `most` or `least`"
            )
        quantity = Quantity(unit_of(name))
        bounds = {}
        for key in ("least", "most"):
            item = row.get(key)
            leaf = None if item is None else quantity.read(item, self._report)
            bounds[key] = None if leaf is None else leaf.value
        return Limit(name, bounds["least"], bounds["most"])

    def _find(self, record: Record, flight: Record) -> tuple[str, float] | None:
        find: Record | None = record.get("find")
        if find is None:
            return None
        name = find.value("input")
        params: Record | None = flight.get("params")
        known = [key for key in ("wind", "wind_from") if flight.get(key) is not None]
        known += [] if params is None else list(params.values)
        if name not in known:
            self._report.error(
                find.get("input").mark,
                "unknown-key",
                f"unknown input '{name}' of `flight`",
                self._report.nearest(name, known) or "vary a number, such as wind",
            )
        return name, find.value("failures")


@dataclass(frozen=True)
class _OfParam:
    """A value of a parameter, as a number in its own unit."""

    param: Param

    @property
    def unit(self) -> str:
        return self.param.unit

    def read(self, tree: Tree, report: Report) -> Leaf | None:
        found = scalar(tree, "a value", report)
        value = None if found is None else read_value(self.param, found, report)
        if value is None:
            return None
        is_number = isinstance(value, Fraction)
        return Leaf(float(value) if is_number else value, tree.mark)

    def schema(self) -> dict[str, Any]:
        return {"type": ["string", "number", "boolean"]}


def fault_text(name: str, value: object, at_s: float, lasts_s: float | None) -> str:
    """As `--fail` reads it."""
    strength = "" if value is None else f"={value:g}"
    return f"{name}{strength}@{at_s:g}" + ("" if lasts_s is None else f"+{lasts_s:g}")
