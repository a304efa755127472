"""Where values come from: a vehicle that runs, through its link, or a log."""

from __future__ import annotations

import random
import struct
import time
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from stator import HOME
from stator.diagnostics import UserError, shown_path
from stator.graph.messages import own_field
from stator.live.link import Link, plan_of
from stator.params.table import Row, Value, bits_of, table_of, value_of_bits

if TYPE_CHECKING:
    from stator.graph.model import Field, Graph, Message
    from stator.plan.plan import Plan

SET = dict(own_field("ParameterRequest", "action").values)["set"]
TYPES = dict(own_field("ParameterRequest", "type").values)
RESULTS = {number: name for name, number in own_field("ParameterValue", "result").values}
ARMED = dict(own_field("VehicleStatus", "arming_state").values)["armed"]
STATES = {number: name for name, number in own_field("ParameterStatus", "state").values}
PROGRESS = ("none", "pending", "busy", "done")
NO_ANSWER = 255
LOOK_S, ANSWER_S, KEPT_S = 0.01, 5.0, 5.0
FORMS = {"bool": "?", "float": "f", "double": "d"}
FORMS |= {"int8": "b", "int16": "h", "int32": "i", "int64": "q"}
FORMS |= {f"u{name}": form.upper() for name, form in FORMS.items() if name.startswith("int")}


@dataclass(frozen=True)
class Written:
    result: str  # as in ParameterValue; no_node: nothing in the graph changes parameters
    value: Value  # that counts from now on


class Vehicle:
    """A graph that runs."""

    def __init__(self, link: Link, graph: Path | None) -> None:
        self._link = link
        self._plan: Plan = plan_of(link.info(), graph, link.path)
        self._topics = list(self._plan.topics)
        self.graph: Graph = self._plan.graph
        self.table = table_of(self.graph)
        self._tag = random.randrange(1 << 16)

    def values(self) -> dict[str, Value]:
        """Of all parameters, by id."""
        samples = {
            row.node.name: self._sample(f"{row.node.name}_params") or {} for row in self.table
        }
        return {
            row.id: row.stored(samples[row.node.name].get(row.param.name, row.default))
            for row in self.table
        }

    def set(self, row: Row, value: Value) -> Written:
        """Raises `UserError` if there is no answer."""
        self._tag = (self._tag + 1) % (1 << 16)
        kind = TYPES[row.param.type]
        request = struct.pack("<HBBI", self._tag, SET, kind, bits_of(row, value))
        end = time.monotonic() + ANSWER_S
        while time.monotonic() < end:
            progress, result, bits = struct.unpack(
                "<BBI", self._link.ask_parameter(row.index, request)
            )
            if PROGRESS[progress] == "none":
                return Written("no_node", row.default)
            if PROGRESS[progress] == "done" and result != NO_ANSWER:
                return Written(RESULTS[result], value_of_bits(row, bits))
            if PROGRESS[progress] == "done":
                break
            time.sleep(LOOK_S)
        raise UserError(
            f"error: no answer about {row.id}\n"
            "hint: check that the graph has parts/parameters.yaml and is not stopped"
        )

    def is_armed(self) -> bool:
        status = self._sample_of("VehicleStatus")
        return status is not None and status["arming_state"] == ARMED

    def report(self) -> dict[str, Any] | None:
        """How parameters do that outlive a restart; None: the graph has no node for that."""
        return self._sample_of("ParameterStatus")

    def kept(self) -> dict[str, Any] | None:
        """The report, once no change is pending or the time is over."""
        end = time.monotonic() + KEPT_S
        time.sleep(LOOK_S)
        while (report := self.report()) and report["pending"] and time.monotonic() < end:
            time.sleep(LOOK_S)
        return report

    def _sample_of(self, message: str) -> dict[str, Any] | None:
        """The newest sample of the first topic with this message."""
        topics = self._plan.topics.values()
        name = next((topic.name for topic in topics if topic.message.name == message), None)
        return None if name is None else self._sample(name)

    def _sample(self, topic: str) -> dict[str, Any] | None:
        _, data = self._link.sample(self._topics.index(topic))
        return decode(self._plan.topics[topic].message, data) if data else None


def decode(message: Message, data: bytes) -> dict[str, Any]:
    """Values by field name."""
    values: dict[str, Any] = {}
    offset = 0
    for field in message.fields:
        found = struct.unpack_from(f"<{field.count or 1}{_form(field)}", data, offset)
        values[field.name] = found[0] if field.count is None else list(found)
        offset += field.bytes
    return values


def _form(field: Field) -> str:
    return FORMS[field.type]


class Log:
    """A flight that is over."""

    def __init__(self, path: Path, graph: Path | None) -> None:
        from pyulog import ULog
        from pyulog.exceptions import ULogException

        from stator.pipeline import make_plan

        try:
            self._log = ULog(str(path))
        except (OSError, ULogException, TypeError, ValueError, struct.error) as error:
            why = getattr(error, "strerror", None) or "not a ULog file"
            raise UserError(f"error: cannot read '{shown_path(path)}': {why}") from None
        name = self._log.msg_info_dict.get("graph", "")
        file = graph or HOME / "graph" / f"{name}.yaml"
        if not file.is_file():
            raise UserError(
                f"error: missing file '{shown_path(file)}' of the graph '{name}' that flew\n"
                "hint: give its file: --graph FILE"
            )
        self.graph: Graph = make_plan(str(file), None).graph
        self.table = table_of(self.graph)

    def values(self) -> dict[str, Value]:
        """At the end of the flight, by id."""
        found = dict(self._log.initial_parameters)
        found |= {name: value for _, name, value in self._log.changed_parameters}
        return {row.id: _typed(row, found.get(row.name, row.default)) for row in self.table}


def _typed(row: Row, value: Value) -> Value:
    return bool(value) if row.param.type == "bool" else row.stored(value)
