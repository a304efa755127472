"""Makes vectors.inc: values, payloads and frames of every generated codec, by the package
`dronecan`, an implementation that is not ours.

    .venv/bin/python tests/runtime/dronecan/make_vectors.py > tests/runtime/dronecan/vectors.inc
"""

from __future__ import annotations

import math
import random
import sys
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parents[3]
sys.path[:0] = [str(ROOT / "codegen"), str(Path(__file__).parent)]

from dronecan.dsdl.parser import PrimitiveType  # noqa: E402
from dronecan.transport import CompoundValue, Transfer  # noqa: E402
from dronecan_values import limits, make, modes, pack, service_or_message, single, unpack  # noqa: E402

from stator.build.dronecan_codecs import TYPES  # noqa: E402
from stator.names import upper_camel  # noqa: E402

CASES = 6  # of each type: all least, all most, the rest at random


def literal(value: float | int | bool) -> str:
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, int):
        return "INT64_MIN" if value == -(2**63) else f"{value}{'U' if value > 2**63 - 1 else ''}"
    if math.isinf(value):
        return ("-" if value < 0 else "") + "std::numeric_limits<float>::infinity()"
    return float.hex(value) + "F"


def statements(value: Any, path: str) -> list[str]:
    """C++ that sets `path` to the value."""
    lines = []
    fields = value._fields
    if value._is_union:
        name = value._union_field or next(iter(fields))
        fields = {name: fields[name]}
        lines.append(f"{path}.tag = std::decay_t<decltype({path})>::Tag::k{upper_camel(name)};")
    for name, field in fields.items():
        if name.startswith("_void_"):
            continue
        if isinstance(field, CompoundValue):
            lines += statements(field, f"{path}.{name}")
        elif hasattr(field, "_pack") and hasattr(field, "append"):
            lines += _array(field, f"{path}.{name}")
        else:
            lines.append(f"{path}.{name} = {literal(field.value)};")
    return lines


def _array(array: Any, path: str) -> list[str]:
    dynamic = array._type.mode == array._type.MODE_DYNAMIC
    lines = [f"{path}.count = {len(array)};"] if dynamic else []
    items = f"{path}.items" if dynamic else path
    for index, item in enumerate(array):
        if isinstance(item, CompoundValue):
            lines += statements(item, f"{items}[{index}]")
        else:
            lines.append(f"{items}[{index}] = {literal(item)};")
    return lines


def value_of(kind: Any, mode: str | None, case: int, draw: random.Random) -> Any:
    def primitive(of: Any) -> Any:
        edges = limits(of)
        if case == 0:
            return edges[0]
        if case == 1:
            return edges[1]
        if of.kind == PrimitiveType.KIND_FLOAT:
            return draw.choice([draw.choice(edges), single(draw.gauss(0, 300))])
        if of.kind == PrimitiveType.KIND_BOOLEAN:
            return draw.choice(edges)
        return draw.choice([draw.choice(edges), draw.randint(*of.value_range)])

    def length(most: int) -> int:
        return (0, most)[case] if case < 2 else draw.randint(0, most)

    return make(kind, mode, primitive, length, lambda count: draw.randrange(count))


def frames(value: Any, case: int) -> list[tuple[int, bytes]]:
    service = value._mode is not None
    transfer = Transfer(
        transfer_id=case * 7 % 32,
        source_node_id=1 + case * 25,
        dest_node_id=127 - case if service else None,
        payload=value,
        transfer_priority=case * 6,
        service_not_message=service,
        request_not_response=value._mode == "request",
    )
    return [(frame.message_id, bytes(frame.bytes)) for frame in transfer.to_frames()]


def block(name: str, kind: Any, mode: str | None, case: int, draw: random.Random) -> str:
    value = value_of(kind, mode, case, draw)
    payload = pack(value)
    received = unpack(kind, mode, payload)
    cpp = "::".join(name.split(".")[1:]) + (f"::{mode.capitalize()}" if mode else "")
    label = cpp.replace("::", "_") + f"_{case}"
    frame_rows = ", ".join(
        f"{{0x{message_id:08X}, {len(data)}, {{{', '.join(f'0x{b:02X}' for b in data)}}}}}"
        for message_id, data in frames(value, case)
    )
    # What was set may be out of range; what was received has come through the bits.
    sent = value_of(kind, mode, case, random.Random(f"{name}{mode}{case}"))
    assert pack(sent) == payload
    return "\n".join(
        [
            f"TEST(DroneCanVectors, {label}) {{",
            f"    {cpp} value;",
            *(f"    {line}" for line in statements(received, "value")),
            "    const std::vector<uint8_t> payload{"
            + ", ".join(f"0x{byte:02X}" for byte in payload)
            + "};",
            f"    const std::vector<Frame> frames{{{frame_rows}}};",
            f"    check(value, payload, frames, {case});",
            "}",
        ]
    )


def main() -> None:
    print("// Made by make_vectors.py with the package dronecan.")
    for name in TYPES:
        kind = service_or_message(name)
        for mode in modes(kind):
            for case in range(CASES):
                print(block(name, kind, mode, case, random.Random(f"{name}{mode}{case}")))


main()
