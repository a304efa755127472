"""What no image may hold: each fault, planted in a small image, is found; the quad has none."""

from __future__ import annotations

import os
import struct
import subprocess
from pathlib import Path

import pytest
from tests.codegen.image.planted import STRICT, image
from tests.emulation.firmware_tools import needs_toolchain

from stator import HOME
from stator.bench.counts import GRAPHS
from stator.build.cmake import NO_WALLS, build
from stator.graph.check import check
from stator.image.checks import faults_of, sections_of
from stator.image.memory import sizes_of, total_of
from stator.plan.plan import plan

CORE_VECTORS = 16  # ARMv7-M: the stack pointer and 15 exceptions
CLEAN = "volatile float a = 2.0f; int main() { a = a * a; return 0; }"


def test_an_image_without_faults_has_none(tmp_path: Path) -> None:
    assert faults_of(image(tmp_path, CLEAN)) == []


@pytest.mark.parametrize(
    ("code", "flags", "expected"),
    [
        (
            "#include <cstdlib>\nvoid* volatile p; int main() { p = malloc(4); }",
            [],
            "planted.cpp:2: error: main calls malloc: the heap",
        ),
        ("int* volatile p; int main() { p = new int; }", [], "main calls operator new: the heap"),
        ("int main(int n, char**) { if (n) throw n; }", ["-fexceptions"], "exceptions"),
        (
            "struct A { virtual int f() { return 1; } }; struct B : A { int f() override; };\n"
            "int B::f() { return 2; } A* volatile a; B b;\n"
            "int main() { a = &b; return dynamic_cast<B*>(a)->f(); }",
            ["-fno-exceptions", "-frtti"],
            "run-time type information",
        ),
        (
            "int f(); struct A { A(); int x; }; volatile int v; A::A() : x(v) {}\n"
            "int main() { static A a; return a.x; }",
            [],
            "a guard variable",
        ),
        (
            "#include <cmath>\nvolatile float a; int main() { a = sinf(a); }",
            [],
            "main calls sinf: a libm function",
        ),
        ("volatile double a; int main() { a = a * a; }", [], "main calls __aeabi_dmul: double"),
        (
            "volatile float a; volatile double b; int main() { b = a; }",
            [],
            "main calls __aeabi_f2d: double",
        ),
        (
            "namespace stator::stm32f4 { template <class, int n> struct DmaBuffer {\n"
            "inline static unsigned char bytes[n]; }; }\n"
            "using B = stator::stm32f4::DmaBuffer<int, 8>;\n"
            "volatile int v; int main() { B::bytes[v] = 1; }",
            [
                *STRICT,
                "-Wl,--defsym=stator_stack_begin=0",
                "-Wl,--defsym=stator_stack_end=0xf0000000",
            ],
            "bytes: it is in the memory of the stack",
        ),
        ('int main() { asm volatile("cpsid i"); }', [], "main masks all interrupts: cpsid"),
        ('int main() { asm volatile("msr primask, r0"); }', [], "main masks all interrupts: msr"),
        ('int main() { asm volatile("msr basepri, r0"); }', [], "main writes BASEPRI"),
    ],
)
def test_each_planted_fault_is_found(
    tmp_path: Path, code: str, flags: list[str], expected: str
) -> None:
    faults = faults_of(image(tmp_path, code, *flags))
    assert any(expected in fault for fault in faults), faults


@pytest.mark.parametrize(
    ("graph", "board", "flash_kb", "ram_kb"),
    [
        # 9 KB of it: IMU, bus, DMA, motor outputs, motion capture, log; 16 KB of RAM for its line.
        ("quad", "fmu_v2", 72, 34),
        ("quad", "qemu_f405", 80, 16),
        ("quad_can", "fmu_v2", 160, 68),
    ],
)
def test_the_quad_has_no_fault(graph: str, board: str, flash_kb: int, ram_kb: int) -> None:
    needs_toolchain()
    quad = build(HOME / "graph" / f"{graph}.yaml", board, executor="cortex_m")
    assert faults_of(quad) == []
    flash, ram = total_of(quad)
    assert flash < flash_kb * 1024
    assert ram < ram_kb * 1024
    parts = sizes_of(quad)
    runtime = parts["runtime/cortex_m"]
    assert runtime[0] < 6 * 1024
    for part in (0, 1):
        assert sum(sizes[part] for sizes in parts.values()) == (flash, ram)[part]
    unnamed = parts["texts and gaps"]
    assert all(0 <= size < flash / 12 for size in unnamed), unnamed
    golden = Path(__file__).parent / "golden" / f"{graph}-{board}.txt"
    rows = [*parts.items(), ("image", (flash, ram))]
    text = "".join(f"{name:24} {size[0]:6} {size[1]:6}\n" for name, size in rows)
    if os.environ.get("STATOR_UPDATE"):
        golden.parent.mkdir(exist_ok=True)
        golden.write_text(text, encoding="utf-8")
    assert text == golden.read_text(encoding="utf-8"), text


def test_mavlink_and_parameters_fit() -> None:
    needs_toolchain()
    graph = HOME / "graph" / "quad_outdoor.yaml"
    image = build(graph, "fmu_v2", executor="cortex_m")
    assert faults_of(image, plan(*check(graph)).graph.nodes) == []
    flash, ram = total_of(image)
    assert flash < 276 * 1024  # the goal is 256 KB
    assert ram < 80 * 1024  # 16 KB of it for the line that takes the log
    assert sizes_of(image)["mavlink"][0] < 40 * 1024


def vectors_of(image: Path, folder: Path) -> list[str]:
    """What each of the chip's own vectors starts; the table is the image's begin."""
    command = ["arm-none-eabi-nm", "-C", str(image)]
    lines = subprocess.run(command, check=True, capture_output=True, text=True).stdout.splitlines()
    names = {
        int(row[0], 16): row[2] for row in (line.split(maxsplit=2) for line in lines) if row[2:]
    }
    raw = folder / "image.bin"
    subprocess.run(["arm-none-eabi-objcopy", "-O", "binary", image, raw], check=True)
    handlers = struct.unpack_from("<91I", raw.read_bytes(), 4 * CORE_VECTORS)
    return [names[handler & ~1] for handler in handlers]


def test_the_can_lines_of_fmu_v2_have_their_vectors(tmp_path: Path) -> None:
    needs_toolchain()
    quad = build(HOME / "graph" / "quad_can.yaml", "fmu_v2", executor="cortex_m")
    vectors = vectors_of(quad, tmp_path)
    # RM0090, table 62: CAN1's are 19 to 22, CAN2's 63 to 66.
    lines = ["tx", "rx0", "rx1", "sce"]
    assert [name.split("::")[-1] for name in vectors[19:23]] == [
        f"dispatch_can1_{line}()" for line in lines
    ]
    assert vectors[63:67] == ["stator_fault"] * 4
    task = plan(*check(HOME / "graph" / "quad_can.yaml")).task("can1").vector
    assert task is not None
    assert vectors[task] == "stator::tasks::can1::run()"


def test_the_quad_masks_nothing() -> None:
    needs_toolchain()
    quad = build(HOME / "graph" / "quad.yaml", "qemu_f405", executor="cortex_m")
    code = subprocess.run(
        ["arm-none-eabi-objdump", "-d", quad], check=True, capture_output=True, text=True
    ).stdout
    assert sections_of(quad) == {}
    assert "basepri" not in code.lower()


def test_a_task_and_its_topic_take_few_bytes() -> None:
    """Beyond its samples: of a node with one trigger, and of a topic of depth 1. What `top` shows
    of a task's time takes 16 bytes more (TaskCounters)."""
    needs_toolchain()
    image = build(GRAPHS / "counts.yaml", None, NO_WALLS, executor="cortex_m")
    lines = subprocess.run(
        ["arm-none-eabi-nm", "-S", "-C", image], check=True, capture_output=True, text=True
    ).stdout.splitlines()
    rows = [line.split(maxsplit=3) for line in lines]
    bytes_of = {row[3]: int(row[1], 16) for row in rows if len(row) == 4}
    task = bytes_of["stator::tasks::sink::state"] - 16
    topic = bytes_of["stator::topics::awaited_parts::storage"] - 2 * 32
    assert task + topic < 48, (task, topic)
