"""The fault record that failed firmware leaves for the next run, as text."""

from __future__ import annotations

import re
import subprocess
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from stator.build.cpp_source import constant, layout
from stator.plan.hash import graph_hash
from stator.processes import environment

if TYPE_CHECKING:
    from pathlib import Path

    from stator.plan.plan import Plan, Task

HEADER = "runtime/cortex_m/stator/fault_record.hpp"
MAX_RESETS = constant(HEADER, "kMaxResets")  # after these, the firmware starts in safe mode
LAYOUT = layout(HEADER, "FaultRecord")
PRINTED = re.compile(r"^stator: record ([0-9a-f]+)$", re.MULTILINE)

FAULT, ASSERTION, WATCHDOG = 1, 2, 3
EXCEPTIONS = {2: "NMI", 3: "HardFault", 4: "MemManage", 5: "BusFault", 6: "UsageFault"}
# ARMv7-M Architecture Reference Manual (DDI 0403E), B3.2.15; and a text, if there is a useful one.
STATUS = {
    0: ("IACCVIOL", "executed data that is not code"),
    1: ("DACCVIOL", "accessed protected memory"),
    3: ("MUNSTKERR", ""),
    4: ("MSTKERR", "stack overflow"),
    5: ("MLSPERR", ""),
    7: ("MMARVALID", ""),
    8: ("IBUSERR", "executed at an address without memory"),
    9: ("PRECISERR", "accessed an address without memory"),
    10: ("IMPRECISERR", "wrote to an address without memory"),
    11: ("UNSTKERR", ""),
    12: ("STKERR", "stack overflow"),
    13: ("LSPERR", ""),
    15: ("BFARVALID", ""),
    16: ("UNDEFINSTR", "executed an undefined instruction"),
    17: ("INVSTATE", "branched to code that is not Thumb"),
    18: ("INVPC", "returned from an exception with a damaged stack"),
    19: ("NOCP", "used a disabled coprocessor"),
    24: ("UNALIGNED", "accessed unaligned memory"),
    25: ("DIVBYZERO", "divided by zero"),
}
# runtime/cortex_m/guards.cpp
NULL_PAGE_END = 0x08000000
CODE_END = BELOW_STACK = 0x0C000000
STACK_BEGIN = 0x10000000
MEMORY_ADDRESS_VALID, BUS_ADDRESS_VALID = 1 << 7, 1 << 15


@dataclass(frozen=True)
class FaultRecord:
    cause: int
    exception: int
    exc_return: int
    stack_pointer: int
    status: int
    hard_status: int
    memory_address: int
    bus_address: int
    frame: tuple[int, ...]  # r0 to r3, r12, lr, pc, xpsr; zeros if unreadable
    saved: tuple[int, ...]
    active_vectors: tuple[int, ...]
    nested: int
    silent_task: int | None
    resets: int
    uptime_us: int
    activations: tuple[tuple[int, int], ...]  # time in ticks modulo 2^24, task; the newest first
    what: str
    graph_hash: str
    build_id: str

    @property
    def program_counter(self) -> int:
        return self.frame[6]


def decode(data: bytes) -> FaultRecord:
    """Raises `ValueError` for a record of another length."""
    if len(data) != LAYOUT.packed.size:
        raise ValueError(f"expected a record of {LAYOUT.packed.size} bytes, found {len(data)}")
    fields: dict[str, Any] = LAYOUT.read(data)
    one = {name: values[0] for name, values in fields.items()}
    count, ring = one["activation_count"], fields["activations"]
    newest_first = (ring[(count - 1 - i) % len(ring)] for i in range(min(count, len(ring))))
    return FaultRecord(
        cause=one["cause"],
        exception=one["exception"],
        exc_return=one["exc_return"],
        stack_pointer=one["stack_pointer"],
        status=one["status"],
        hard_status=one["hard_status"],
        memory_address=one["memory_address"],
        bus_address=one["bus_address"],
        frame=fields["frame"],
        saved=fields["saved"],
        active_vectors=tuple(
            32 * i + bit
            for i, word in enumerate(fields["active"])
            for bit in range(32)
            if word >> bit & 1
        ),
        nested=one["nested"],
        silent_task=one["silent_task"] - 1 if one["silent_task"] else None,
        resets=one["resets"],
        uptime_us=one["uptime_us"],
        activations=tuple((entry >> 8, entry & 0xFF) for entry in newest_first),
        what=one["what"].rstrip(b"\0").decode(errors="replace"),
        graph_hash=one["graph_hash"].decode(errors="replace"),
        build_id=one["build_id"].hex(),
    )


def active_tasks(record: FaultRecord, plan: Plan) -> list[Task]:
    """The task of each level that was running, the most urgent first."""
    return [task for task in plan.tasks if task.vector in record.active_vectors]


def records_in(text: str) -> list[FaultRecord]:
    """The records that firmware printed on the emulator's console."""
    return [decode(bytes.fromhex(found)) for found in PRINTED.findall(text)]


def in_words(text: str, plan: Plan, image: Path) -> str:
    """The console's text with its records explained."""
    return PRINTED.sub(
        lambda found: "\n".join(explain(decode(bytes.fromhex(found[1])), plan, image)), text
    )


def explain(record: FaultRecord, plan: Plan, image: Path | None = None) -> list[str]:
    """Lines for a person. `image`: to name the function."""
    if record.graph_hash != graph_hash(plan)[: len(record.graph_hash)]:
        return [
            f"error: the firmware ended: {what_happened(record)} (it was built from another graph)"
        ]
    running = active_tasks(record, plan)
    where = f" in task {running[0].node.name}" if running else " outside tasks"
    rows = [f"error: the firmware ended{where}: {what_happened(record)}"]
    if record.silent_task is not None:
        rows.append(f"  missing life sign of task {plan.tasks[record.silent_task].node.name}")
    at = f"{record.program_counter:#010x}"
    rows.append(f"  at {at} {_function(image, record.program_counter)}".rstrip())
    rows.append(
        f"  after {record.uptime_us * 1e-6:.6f} s; reset {record.resets} within 10 s "
        f"(safe mode after {MAX_RESETS})"
    )
    rows.append(f"  {_exception(record)}")
    if record.nested:
        rows.append(f"  second fault in the fault handler: {_name(record.nested)}")
    levels = ", ".join(f"{task.level} {task.node.name}" for task in running)
    rows.append(f"  running by level: {levels or 'none'}")
    if record.activations:
        rows.append(f"  last activations, the newest first: {_activations(record, plan)}")
    return rows


def what_happened(record: FaultRecord) -> str:
    if record.cause == ASSERTION:
        return record.what
    if record.cause == WATCHDOG:
        return "the watchdog was not reset in time"
    address = _address(record)
    if address is not None and record.status & 0x2:
        if address < NULL_PAGE_END:
            return f"accessed {address:#010x} through a null pointer"
        if address < CODE_END:
            return f"wrote to {address:#010x}, which is code"
        if BELOW_STACK <= address < STACK_BEGIN:
            return "stack overflow"
    texts = [text for bit, (_, text) in STATUS.items() if record.status >> bit & 1 and text]
    where = "" if address is None else f", address {address:#010x}"
    return "; ".join(texts) + where if texts else f"unexpected {_name(record.exception)}"


def _address(record: FaultRecord) -> int | None:
    if record.status & MEMORY_ADDRESS_VALID:
        return record.memory_address
    return record.bus_address if record.status & BUS_ADDRESS_VALID else None


def _name(exception: int) -> str:
    return EXCEPTIONS.get(exception, f"vector {exception - 16}")


def _exception(record: FaultRecord) -> str:
    bits = [name for bit, (name, _) in STATUS.items() if record.status >> bit & 1]
    text = f"exception {record.exception} ({_name(record.exception)})"
    return f"{text}, CFSR {record.status:#010x} {' '.join(bits)}".rstrip()


def _activations(record: FaultRecord, plan: Plan) -> str:
    names = [plan.tasks[task].node.name for _, task in record.activations if task < len(plan.tasks)]
    return ", ".join(names)


def _function(image: Path | None, address: int) -> str:
    if image is None or address == 0:
        return ""
    command = ["arm-none-eabi-addr2line", "-f", "-C", "-e", str(image), hex(address)]
    found = subprocess.run(command, env=environment(), check=False, capture_output=True, text=True)
    name = found.stdout.splitlines()[:1]
    return "" if not name or name[0] == "??" else name[0]
