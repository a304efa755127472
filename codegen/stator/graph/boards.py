"""Reads a board: its executor, chip and devices, and the driver that each device is bound to."""

from __future__ import annotations

import re
from dataclasses import replace
from typing import TYPE_CHECKING

from stator.graph.interfaces import find_device_class
from stator.graph.model import (
    Board,
    BoardInterrupt,
    Chip,
    Costs,
    Device,
    Interface,
    Memory,
    Upload,
)
from stator.language import keys as language
from stator.language.shapes import Leaf, Record, check_name, items, quoted

if TYPE_CHECKING:
    from pathlib import Path

    from stator.diagnostics import Mark, Report
    from stator.graph.sources import Sources

_PIN = re.compile(language.PIN)


def read_board(sources: Sources, name: str, path: Path) -> Board | None:
    record = sources.read(path, language.BOARD)
    if record is None or record.value("executor") is None:
        return None
    chip = record.get("chip")
    if record.value("executor") == "cortex_m" and "chip" not in record.keys:
        sources.report.error(
            record.get("executor").mark,
            "chip-missing",
            "missing key 'chip': the executor cortex_m needs it",
            "add it, for example `chip: stm32f4/stm32f427`",
        )
    found = None if chip is None else _chip(sources, chip.value, chip.mark, path)
    if found is not None:
        found = replace(found, memory=found.memory | _memories(record))
    upload = record.get("upload")
    reserved: list[Leaf] = record.value("reserved_vectors", [])
    interrupts: list[Leaf] = record.value("interrupts", [])
    if found is not None:
        for leaf in (*reserved, *interrupts):
            _check_vector(found, leaf, sources.report)
    return Board(
        name=name,
        file=path,
        executor=record.value("executor"),
        chip=found,
        reserved_vectors=tuple(leaf.value for leaf in (*reserved, *interrupts)),
        interrupts=tuple(leaf.value for leaf in interrupts),
        devices={
            key: device
            for key, value in items(record, "devices")
            if (device := _device(sources, key, value, found)) is not None
        },
        upload=None
        if upload is None
        else Upload(upload.value("board_id"), upload.value("pyocd_target")),
        costs=_costs(record.get("costs")),
    )


def _costs(record: Record | None) -> Costs | None:
    if record is None:
        return None
    return Costs(
        source=record.value("from", language.PROVENANCES[0]),
        task_ns=record.value("task_ns", 0),
        release_ns=record.value("release_ns", 0),
        timer_ns=record.value("timer_ns", 0),
        dispatch_ns=record.value("dispatch_ns", 0),
        line_ns=record.value("line_ns", 0),
        section_ns=record.value("section_ns", 0),
        clock_ns=record.value("clock_ns", 0),
        instruction_ns=record.value("instruction_ns"),
        interrupts={
            name: BoardInterrupt(row.value("min_interarrival", 1), row.value("budget_ns", 0))
            for name, row in items(record, "interrupts")
        },
    )


def _memories(record: Record) -> dict[str, Memory]:
    return {
        key: Memory(int(memory.value("at") or "0", 16), memory.value("bytes") or 0)
        for key, memory in items(record, "memory")
    }


def _device(sources: Sources, name: str, record: Record, chip: Chip | None) -> Device | None:
    driver, stated = record.get("driver"), record.get("class")
    if driver is None:
        return None
    if driver.value == "none" and stated is None:
        sources.report.error(
            record.owner,
            "missing-key",
            f"missing key 'class': device '{name}' has no driver",
            "add it, for example `class: imu`",
        )
        return None
    of_driver = driver.value.split("/")[0]
    # The folder is a namespace, too.
    if driver.value != "none" and not all(
        check_name(part, driver.mark, what, sources.report)
        for part, what in zip(driver.value.split("/"), ("a device class", "a driver"), strict=True)
    ):
        return None
    if driver.value != "none" and driver.value not in sources.drivers():
        sources.report.error(
            driver.mark,
            "driver-unknown",
            f"unknown driver '{driver.value}'",
            sources.report.nearest(driver.value, sources.drivers()),
        )
        return None
    if driver.value != "none" and stated is not None and stated.value != of_driver:
        sources.report.error(
            stated.mark,
            "class-mismatch",
            f"expected class '{of_driver}' for driver '{driver.value}', found '{stated.value}'",
            "remove the key `class`",
        )
        return None
    chosen: Leaf = driver if stated is None else stated
    device_class = of_driver if stated is None else stated.value
    interface = find_device_class(sources, device_class, chosen.mark)
    if interface is not None:
        _check_lines(record, interface, chip, sources.report)
    lines = {key: tuple(w.value for w in wires.value) for key, wires in items(record, "lines")}
    bus, speed = record.value("bus", ""), record.value("bytes_per_s")
    return Device(name, driver.value, device_class, lines, bus, interface, speed)


def _check_lines(record: Record, interface: Interface, chip: Chip | None, report: Report) -> None:
    for line, wires in items(record, "lines"):
        if line not in interface.lines:
            report.error(
                record.get("lines").keys[line],
                "line-unknown",
                f"unknown line '{line}' of device class '{interface.name}'",
                report.nearest(line, interface.lines) or "remove it: this class has no lines",
            )
            continue
        for wire in wires.value:
            if chip is not None and not _PIN.fullmatch(wire.value):
                _check_vector(chip, wire, report)


def _check_vector(chip: Chip, leaf: Leaf, report: Report) -> None:
    if leaf.value not in chip.vectors:
        report.error(
            leaf.mark,
            "vector-unknown",
            f"unknown pin or vector {quoted(leaf.value)} of {chip.name}",
            report.nearest(leaf.value.lower(), chip.vectors),
        )


def _chip(sources: Sources, name: str, mark: Mark, board: Path) -> Chip | None:
    path = sources.chips(board).get(name)
    if path is None:
        sources.report.error(
            mark,
            "file-missing",
            f"missing file 'boards/{name}.yaml' of the chip",
            sources.report.nearest(name, sources.chips(board)) or "write it beside the board",
        )
        return None
    record = sources.read(path, language.CHIP)
    if record is None:
        return None
    return Chip(
        name=name,
        clock_hz=int((record.value("clock") or "0").split()[0]) * 1_000_000,
        memory=_memories(record),
        vectors={key: leaf.value for key, leaf in items(record, "vectors")},
    )


def find_board(sources: Sources, name: str, mark: Mark, note: str = "") -> Board | None:
    path = sources.boards().get(name)
    if path is None:
        sources.report.error(
            mark,
            "board-unknown",
            f"unknown board '{name}'{note}",
            sources.report.nearest(name, sources.boards()),
        )
        return None
    found: Board | None = sources.once("board", name, lambda: read_board(sources, name, path))
    return found
