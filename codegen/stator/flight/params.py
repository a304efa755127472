"""`--param NODE.PARAMETER=VALUE`: other values of parameters for one flight, without a build."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING

from stator.diagnostics import Failed, Mark, Report, UserError, nearest
from stator.emit.rows import literal
from stator.graph.value import as_written, read_value
from stator.params.table import table_of
from stator.quantities import CONVERSIONS, split

if TYPE_CHECKING:
    import argparse

    from stator.graph.model import Graph, Param, Value


@dataclass(frozen=True)
class Replaced:
    """A parameter that flies with another value than the graph's."""

    node: str
    param: Param
    value: Value
    graph_value: Value

    @property
    def name(self) -> str:
        return f"{self.node}.{self.param.name}"

    @property
    def option(self) -> str:
        """For the program that flies."""
        return f"{self.name}={literal(self.value).removesuffix('F')}"

    def as_json(self) -> dict[str, object]:
        unit = self.param.unit
        values = {"value": _plain(self.value), "graph_value": _plain(self.graph_value)}
        return {"name": self.name, **values, "unit": unit}


def add_param_argument(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--param",
        action="append",
        default=[],
        metavar="NODE.PARAMETER=VALUE",
        help="another value of a parameter than the graph's, with its unit, such as "
        "rate_control.roll_p=0.1 or 'rate_control.derivative_cutoff=40 Hz'; use it once for each "
        "parameter",
    )


def read_params(graph: Graph, texts: list[str]) -> list[Replaced]:
    """Checked as a value in the graph is. Values that the graph has already are left out. Raises
    `UserError` with all errors."""
    errors: list[str] = []
    found: dict[str, Replaced] = {}
    for text in texts:
        try:
            replaced = _read(graph, text)
            if replaced.name in found:
                raise UserError("the parameter is given twice\nhint: keep one of them")
            found[replaced.name] = replaced
        except UserError as error:
            errors.append(f"error: --param '{text}': {error}")
    if errors:
        raise UserError("\n".join(errors))
    return [row for row in found.values() if literal(row.value) != literal(row.graph_value)]


def with_params(graph: Graph, replaced: list[Replaced]) -> Graph:
    """The graph as it flies."""
    nodes = dict(graph.nodes)
    for row in replaced:
        node = nodes[row.node]
        nodes[row.node] = replace(node, params=node.params | {row.param.name: row.value})
    return replace(graph, nodes=nodes)


def param_options(replaced: list[Replaced]) -> list[str]:
    """Options of the program that flies."""
    return [word for row in replaced for word in ("--param", row.option)]


def param_facts(replaced: list[Replaced]) -> dict[str, object]:
    return {"params": [row.as_json() for row in replaced]}


def param_rows(facts: dict[str, object]) -> list[tuple[str, str]]:
    """What the report says of them."""
    rows = facts.get("params", [])
    assert isinstance(rows, list)
    texts = []
    for row in rows:
        unit = "" if row["unit"] == "1" else f" {row['unit']}"
        value, before = (in_words(row[key]) for key in ("value", "graph_value"))
        texts.append(f"{row['name']} = {value}{unit} (graph: {before}{unit})")
    return [("param", text) for text in texts]


def in_words(value: float | bool) -> str:
    return str(value).lower() if isinstance(value, bool) else f"{value:g}"


def _plain(value: Value) -> float | bool:
    return value if isinstance(value, (bool, int)) else float(value)


def _read(graph: Graph, text: str) -> Replaced:
    name, equals, value = text.partition("=")
    ids = {row.id: row.name for row in table_of(graph)}
    node, dot, key = ids.get(name.strip(), name.strip()).partition(".")
    if not equals or not dot:
        raise UserError(
            "expected NODE.PARAMETER=VALUE\nhint: write for example --param rate_control.roll_p=0.1"
        )
    known = {f"{n.name}.{p}" for n in graph.nodes.values() for p in n.params}
    if f"{node}.{key}" not in known:
        raise UserError(_unknown(graph, node, key, sorted(known)))
    param = graph.nodes[node].interface.params[key]
    report = Report()
    item = as_written(param, _with_unit(param, value.strip()), Mark(Path("--param"), 1, 1))
    read = read_value(param, item, report)
    try:
        report.stop_on_errors()
    except Failed as failed:
        error = failed.errors[0]
        raise UserError(f"{error.message}\nhint: {error.hint}") from None
    assert read is not None
    return Replaced(node, param, read, graph.nodes[node].params[key])


def _unknown(graph: Graph, node: str, key: str, known: list[str]) -> str:
    if node not in graph.nodes:
        return f"unknown node '{node}' of {graph.name}\nhint: {nearest(f'{node}.{key}', known)}"
    own = graph.nodes[node].params
    if not own:
        return f"unknown parameter '{key}' of '{node}', which has none\nhint: use another node"
    return f"unknown parameter '{key}' of '{node}'\nhint: {nearest(key, own)}"


def _with_unit(param: Param, value: str) -> str:
    """A bare number is clear where its unit has no other one to mix it up with: gains, mostly."""
    parts = split(value)
    if parts is None or parts[1] or param.unit in CONVERSIONS:
        return value
    return f"{value} {param.unit}"
