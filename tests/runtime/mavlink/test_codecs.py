"""Generated codecs and pymavlink write the same frames; the definitions are those of the others."""

from __future__ import annotations

import importlib.util
import random
import struct
import subprocess
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pytest
from pymavlink.dialects.v20 import common
from pymavlink.generator import mavgen, mavparse

ROOT = Path(__file__).resolve().parents[3]
sys.path.insert(0, str(ROOT / "codegen"))

from stator.build.mavlink_codecs import DEFINITIONS, definitions  # noqa: E402

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

ECHO = ROOT / "build" / "host" / "tests" / "runtime" / "mavlink" / "mavlink_echo"
# Of the definitions of https://github.com/mavlink/mavlink that pymavlink's package lacks.
CRC_EXTRA = {80: 14, 290: 251, 291: 10, 300: 217, 397: 182, 435: 134, 436: 193, 437: 30}
MESSAGES = {message.id: message for message in definitions().message}
RANGES = {f"{sign}int{bits}_t": (sign, bits) for sign in ("", "u") for bits in (8, 16, 32, 64)}


def test_each_definition_is_that_of_others() -> None:
    for number, message in MESSAGES.items():
        if number in CRC_EXTRA:
            assert message.crc_extra == CRC_EXTRA[number], message.name
            continue
        other = common.mavlink_map[number]
        assert message.name == other.msgname
        assert message.crc_extra == other.crc_extra, message.name
        names = [field.name for field in message.ordered_fields]
        assert names[: len(other.ordered_fieldnames)] == other.ordered_fieldnames, message.name
    assert set(CRC_EXTRA) <= set(MESSAGES)


def test_each_constant_is_that_of_others() -> None:
    """Values that only newer definitions have are not in pymavlink's package."""
    newer = {"MAV_PARAM_ERROR_TYPE_MISMATCH", "MAV_RESULT_CANCELLED"}
    newer.add("MAV_RESULT_COMMAND_UNSUPPORTED_MAV_FRAME")
    for enum in definitions().enum:
        for entry in enum.entry:
            if not entry.end_marker and entry.name not in newer:
                assert getattr(common, entry.name) == entry.value


@pytest.fixture(scope="module")
def dialect(tmp_path_factory: pytest.TempPathFactory) -> Any:
    """What pymavlink makes of our definitions."""
    file = tmp_path_factory.mktemp("dialect") / "stator_dialect.py"
    options = mavgen.Opts(
        str(file), wire_protocol=mavparse.PROTOCOL_2_0, language="Python3", validate=False
    )
    assert mavgen.mavgen(options, [str(DEFINITIONS)])
    spec = importlib.util.spec_from_file_location("stator_dialect", file)
    assert spec and spec.loader
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@pytest.fixture(scope="module")
def echo() -> Iterator[Callable[[bytes], bytes]]:
    assert ECHO.is_file(), "built by ./stator test; run that"
    with subprocess.Popen([ECHO], stdin=subprocess.PIPE, stdout=subprocess.PIPE) as process:

        def ask(frame: bytes) -> bytes:
            assert process.stdin and process.stdout
            process.stdin.write(f"{frame.hex()}\n".encode())
            process.stdin.flush()
            answer = process.stdout.readline().decode().strip()
            return b"" if answer == "bad" else bytes.fromhex(answer)

        yield ask
        assert process.stdin
        process.stdin.close()


def one_value(kind: str, draw: random.Random) -> Any:
    if kind == "float":
        return struct.unpack("<f", struct.pack("<f", draw.uniform(-1e6, 1e6)))[0]
    if kind == "double":
        return draw.uniform(-1e9, 1e9)
    sign, bits = RANGES[kind]
    return draw.randrange(0 if sign else -(2 ** (bits - 1)), 2 ** (bits if sign else bits - 1))


def value_of(field: Any, draw: random.Random) -> Any:
    if field.type == "char":
        return bytes(draw.randrange(1, 128) for _ in range(field.array_length))
    if field.array_length:
        return [one_value(field.type, draw) for _ in range(field.array_length)]
    return one_value(field.type, draw)


def zero_of(field: Any) -> Any:
    if field.type == "char":
        return b""
    return [0] * field.array_length if field.array_length else 0


def test_every_message_travels_as_pymavlink_sends_it(
    dialect: Any, echo: Callable[[bytes], bytes]
) -> None:
    draw = random.Random(1)
    for number, message in MESSAGES.items():
        kind = dialect.mavlink_map[number]
        fields = {field.name: field for field in message.ordered_fields}
        for filled in range(len(fields) + 1):  # the others are zero: those at the end do not travel
            sender = dialect.MAVLink(None, srcSystem=draw.randrange(256), srcComponent=7)
            sender.seq = draw.randrange(256)
            last = message.ordered_fields[:filled]
            values = {n: value_of(f, draw) if f in last else zero_of(f) for n, f in fields.items()}
            frame = bytes(kind(**{name: values[name] for name in kind.fieldnames}).pack(sender))
            assert echo(frame) == frame, (message.name, filled)
