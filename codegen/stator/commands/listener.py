"""`./stator listener`: the newest samples of a topic of a running vehicle, field by field."""

from __future__ import annotations

import argparse
import contextlib
import json
import math
import struct
import time
from typing import TYPE_CHECKING

from stator.diagnostics import UserError, nearest
from stator.live.arguments import add_link_arguments
from stator.live.link import Link, plan_of

if TYPE_CHECKING:
    from stator.graph.model import Field, Message

CODES = {"bool": "?", "float": "f", "double": "d"}
CODES |= {"int8": "b", "int16": "h", "int32": "i", "int64": "q"}
CODES |= {f"u{name}": code.upper() for name, code in CODES.items() if name.startswith("int")}
LOOK_S = 0.02  # between two requests for a new sample
Value = float | int | bool | list[float | int | bool]


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("topic", help="topic of the graph")
    parser.add_argument(
        "--count", type=_count, metavar="N", help="end after N samples (default: no end)"
    )
    add_link_arguments(parser)


def _count(text: str) -> int:
    if text.isascii() and text.isdigit() and int(text) > 0:
        return int(text)
    raise argparse.ArgumentTypeError(f"expected a whole number above 0, found '{text}'")


def main(arguments: argparse.Namespace) -> int:
    with Link(arguments.link) as link:
        plan = plan_of(link.info(), arguments.graph, arguments.link)
        names = list(plan.topics)
        if arguments.topic not in names:
            raise UserError(
                f"error: unknown topic '{arguments.topic}' of {plan.graph.name}\n"
                f"hint: {nearest(arguments.topic, names)}"
            )
        index = names.index(arguments.topic)
        message = plan.topics[arguments.topic].message
        if arguments.count is not None:
            _listen(link, index, message, arguments)
        else:
            with contextlib.suppress(KeyboardInterrupt):  # the usual end of this command
                _listen(link, index, message, arguments)
    return 0


def _listen(link: Link, index: int, message: Message, arguments: argparse.Namespace) -> None:
    before: tuple[int, int] | None = None  # number and timestamp
    left = arguments.count
    while left != 0:
        number, data = link.sample(index)
        if not data or (before is not None and number == before[0]):
            time.sleep(LOOK_S)
            continue
        values = decode(message, data)
        timestamp = int(values["timestamp"])  # type: ignore[arg-type]
        rate_hz = None
        if before is not None and timestamp > before[1]:
            rate_hz = (number - before[0]) % 2**32 * 1e6 / (timestamp - before[1])
        if arguments.json:
            fields = {key: _plain(value) for key, value in values.items()}
            print(json.dumps({"number": number, "rate_hz": rate_hz, "fields": fields}), flush=True)
        else:
            _print(arguments.topic, message, number, rate_hz, values)
        before = (number, timestamp)
        left = None if left is None else left - 1


def decode(message: Message, data: bytes) -> dict[str, Value]:
    """Values by field name, without padding. Raises `UserError` if the sample is cut."""
    values: dict[str, Value] = {}
    offset = 0
    for field in message.fields:
        if offset + field.bytes > len(data):
            raise UserError(
                f"error: cannot show {message.name}: its samples are too long for the link"
            )
        read = struct.unpack_from(f"<{field.count or 1}{CODES[field.type]}", data, offset)
        offset += field.bytes
        if not field.name.startswith("_padding"):
            values[field.name] = read[0] if field.count is None else list(read)
    return values


def _plain(value: Value) -> object:
    """JSON has no infinity and no NaN."""
    if isinstance(value, list):
        return [_plain(item) for item in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value


def _print(
    topic: str, message: Message, number: int, rate_hz: float | None, values: dict[str, Value]
) -> None:
    rate = "" if rate_hz is None else f", {rate_hz:.1f} Hz"
    print(f"{topic} #{number}{rate}")
    width = max(map(len, values))
    fields = {field.name: field for field in message.fields}
    for name, value in values.items():
        print(f"  {name:{width}}  {_shown(fields[name], value)}", flush=True)


def _shown(field: Field, value: Value) -> str:
    unit = field.unit if field.unit not in ("", "1") else ""
    if isinstance(value, list):
        return f"[{', '.join(_number(item) for item in value)}] {unit}".rstrip()
    named = next((name for name, number in field.values if number == value), "")
    return f"{_number(value)} {named or unit}".rstrip()


def _number(value: float | int | bool) -> str:
    return f"{value:.6g}" if isinstance(value, float) else str(value)
