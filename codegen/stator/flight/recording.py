"""Reads the recording in a flight log, and how much of it is intact: docs/recording.md."""

from __future__ import annotations

import struct
import zlib
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from stator.diagnostics import UserError, shown_path

if TYPE_CHECKING:
    from pathlib import Path

FILE_HEAD = 16
MESSAGE_HEAD = 3
RECORDING = ord("X")
PACKED = b"M\0\x10stator recording"  # in front of what is among the definitions
VERSION = 2  # of the recordings that can be replayed: `VERSION` of emit/recording.py
STREAM, DEFINITION, GAP, CHECK = 0x00, 0x10, 0x20, 0x30

# ULog type -> format of struct
FORMATS = {
    "bool": "?",
    "float": "f",
    "double": "d",
    **{
        f"{sign}int{bits}_t": code
        for bits, codes in ((8, "bB"), (16, "hH"), (32, "iI"), (64, "qQ"))
        for sign, code in zip(("", "u"), codes, strict=True)
    },
}


@dataclass
class Recording:
    log: Path
    data: bytes
    good_bytes: int = 0  # from the start of the log, confirmed by checks
    hash: str = ""
    lines: list[str] = field(default_factory=list)
    gaps: dict[int, int] = field(default_factory=dict)  # level -> activations lost
    replaced: dict[str, float] = field(default_factory=dict)  # parameters that an option replaced
    problem: str = ""  # why the rest of the file is not used; empty: all of it is

    def graph(self) -> tuple[str, str, str]:
        """Its name, the board, and the file's name."""
        line = next(line for line in self.lines if line.startswith("graph "))
        _, name, board, file = line.split(" ", 3)
        return name, board, file

    def version(self) -> int:
        """Of its format; 1 does not name itself."""
        line = next((line for line in self.lines if line.startswith("recording ")), "recording 1")
        return int(line.removeprefix("recording "))

    def layouts(self) -> dict[str, str]:
        """Topic -> its fields, in ULog's format."""
        topics = (line.split(" ", 2) for line in self.lines if line.startswith("topic "))
        return {name: layout for _, name, layout in topics}


def read_recording(log: Path) -> Recording:
    """Raises `UserError` for a file that has no recording, or whose beginning is damaged."""
    try:
        data = log.read_bytes()
    except OSError as error:
        raise UserError(f"error: cannot read '{log}': {error.strerror}") from error
    if data[:4] != b"ULog":
        raise UserError(
            f"error: expected a flight log (ULog), found another file '{shown_path(log)}'\n"
            "hint: ./stator fly and ./stator emulate print the path of their log"
        )
    recording = Recording(log, data)
    seen_any = _walk(recording)
    if not recording.good_bytes and not recording.problem and not seen_any:
        raise UserError(
            f"error: missing recording in '{shown_path(log)}'\n"
            "hint: fly without --no-record, and with a graph that has a logger"
        )
    if not recording.good_bytes or not any(line.startswith("graph ") for line in recording.lines):
        what = recording.problem or "the file ends before the first check"
        raise UserError(f"error: cannot replay '{shown_path(log)}': {what}")
    if (version := recording.version()) != VERSION:
        raise UserError(
            f"error: expected a recording of version {VERSION}, found version {version} in "
            f"'{shown_path(log)}'\n"
            "hint: fly again, or replay the log with the Stator that flew it"
        )
    return recording


def _walk(recording: Recording) -> bool:
    """Reads the messages up to the last correct check. The rest does not count."""
    data = recording.data
    at, covered_from = FILE_HEAD, 0
    seen_any = False
    lines: list[str] = []
    gaps: dict[int, int] = {}
    values: dict[str, float] = {}
    while at < len(data):
        end = at + MESSAGE_HEAD + int.from_bytes(data[at : at + 2], "little")
        if at + MESSAGE_HEAD > len(data) or end > len(data):
            recording.problem = f"it is incomplete or damaged at byte {at}"
            break
        kind = data[at + 2]
        is_packed = data.startswith(PACKED, at + 2)
        first = at + 2 + (len(PACKED) if is_packed else 1)
        if (kind == RECORDING or is_packed) and end > first:
            seen_any = True
            what, level = data[first] & 0xF0, data[first] & 0x0F
            content = data[first + 1 : end]
            if what == DEFINITION:
                lines.append(content.decode(errors="replace"))
            elif what == GAP and len(content) == 4:
                gaps[level] = int.from_bytes(content, "little")
            elif what == CHECK:
                if content != zlib.crc32(data[covered_from : first + 1]).to_bytes(4, "little"):
                    recording.problem = f"it is damaged between bytes {covered_from} and {end}"
                    break
                covered_from = recording.good_bytes = end
                recording.lines, recording.gaps = list(lines), dict(gaps)
        elif kind == ord("I"):
            _read_info(recording, data[at + MESSAGE_HEAD : end])
        elif kind == ord("P"):
            values |= _parameter(data[at + MESSAGE_HEAD : end])
        elif kind == ord("Q"):  # a default that does not count in this flight; behind its value
            for name in _parameter(data[at + MESSAGE_HEAD + 1 : end]).keys() & values.keys():
                recording.replaced.setdefault(name, values[name])
        at = end
    return seen_any


def _read_info(recording: Recording, content: bytes) -> None:
    key = content[1 : 1 + content[0]] if content else b""
    if key.endswith(b" ver_sw"):
        recording.hash = content[1 + content[0] :].decode(errors="replace")


def _parameter(content: bytes) -> dict[str, float]:
    """Name and value."""
    key = content[1 : 1 + content[0]].decode(errors="replace") if content else ""
    kind, _, name = key.partition(" ")
    value = content[1 + len(key) :]
    if kind not in ("float", "int32_t") or len(value) != 4:
        return {}
    return {name: struct.unpack("<" + FORMATS[kind], value)[0]}


def fields_of(layout: str, sample: bytes) -> dict[str, int | float | bool]:
    """Name -> value of each field and element; without padding."""
    values: dict[str, int | float | bool] = {}
    offset = 0
    for part in layout.rstrip(";").split(";"):
        kind, name = part.split(" ")
        single, _, rest = kind.partition("[")
        count = int(rest.rstrip("]")) if rest else 1
        form = "<" + str(count) + FORMATS[single]
        found = struct.unpack_from(form, sample, offset)
        offset += struct.calcsize(form)
        if not name.startswith("_padding"):
            names = [f"{name}[{i}]" for i in range(count)] if rest else [name]
            values |= zip(names, found, strict=True)
    return values


def sample_hash(sample: bytes) -> int:
    """The same as in runtime/bytes/stator/sample_hash.hpp."""
    result = 0
    for (word,) in struct.iter_unpack("<I", sample):
        result = (result ^ word) * 0x9E3779B1 & 0xFFFFFFFF
        result ^= result >> 15
    return result


def logged_sample(recording: Recording, topic: str, wanted: int) -> bytes | None:
    """The sample with this hash, if the flight log has it."""
    size = _bytes_of(recording.layouts()[topic])
    data, at, number = recording.data, FILE_HEAD, None
    while at + MESSAGE_HEAD <= recording.good_bytes:
        end = at + MESSAGE_HEAD + int.from_bytes(data[at : at + 2], "little")
        kind = data[at + 2]
        if kind == ord("A") and data[at + 6 : end] == topic.encode():
            number = data[at + 4 : at + 6]
        elif kind == ord("D") and data[at + 3 : at + 5] == number:
            sample = data[at + 5 : end].ljust(size, b"\0")
            if sample_hash(sample) == wanted:
                return sample
        at = end
    return None


def _bytes_of(layout: str) -> int:
    total = 0
    for part in layout.rstrip(";").split(";"):
        single, _, rest = part.split(" ")[0].partition("[")
        count = int(rest.rstrip("]")) if rest else 1
        total += count * struct.calcsize("<" + FORMATS[single])
    return total
