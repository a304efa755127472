"""The bound of the stack: figures that a person can add up, and each thing that has no bound."""

from __future__ import annotations

import json
from typing import TYPE_CHECKING

import pytest
from tests.codegen.image.planted import STRICT, image
from tests.emulation.firmware_tools import needs_toolchain

from stator import HOME
from stator.__main__ import main
from stator.image.stack import FPU_FRAME, PLAIN_FRAME, Root, Stack, stack_of
from stator.image.tools import addresses

if TYPE_CHECKING:
    from pathlib import Path

PLACES = ["-Wl,--defsym=stator_stack_begin=0", "-Wl,--defsym=stator_stack_end=4096"]


def planted(folder: Path, code: str, levels: dict[str, int] | None = None) -> Stack:
    """`levels`: of functions that interrupts start."""
    levels = {"main": 0, **(levels or {})}
    kept = [f"-Wl,-u,{name}" for name in levels]
    found = image(folder, code, *STRICT, "-fcallgraph-info=su", "-fno-inline", *kept, *PLACES)
    at = addresses(found)
    return stack_of(found, [Root(level, at[name] & ~1, name) for name, level in levels.items()])


# The compiler aligns to 8 bytes, and saves r4 and the return address before a call.
NESTED = """extern "C" {
volatile int v;
void use(volatile int* p) { *p = v; }
void leaf() { volatile int a[16]; use(a); }
void top() { volatile int a[32]; use(a); leaf(); }
void floats() { volatile int a[8]; use(a); volatile float f = 1.0f; f = f * f; }
void high() { leaf(); }
int main() { leaf(); return 0; }
}"""


def test_the_levels_add_up(tmp_path: Path) -> None:
    """Of two handlers of one level only the larger counts; an interrupt pushes 36 bytes, and 108
    on what uses the FPU."""
    found = planted(tmp_path, NESTED, {"top": 3, "floats": 3, "high": 7})
    assert found.faults == ()
    bytes_of = {row.root.name: row.bytes for row in found.roots}
    leaf = 72  # 64, and the return address; use() needs none
    assert bytes_of["main"] == 8 + leaf
    assert bytes_of["high"] == 8 + leaf
    assert bytes_of["top"] == 136 + leaf
    assert bytes_of["floats"] == 48
    assert [row.root.name for row in found.roots if row.uses_fpu] == ["floats"]
    assert found.worst_of(3).root.name == "top"
    expected = (80 + PLAIN_FRAME) + max(208 + PLAIN_FRAME, 48 + FPU_FRAME) + (80 + PLAIN_FRAME)
    assert found.bytes == -(-expected // 8) * 8
    assert found.worst_of(3).path == ("top", "leaf")


def test_a_level_that_uses_the_fpu_pushes_more(tmp_path: Path) -> None:
    found = planted(tmp_path, NESTED, {"floats": 3})
    assert found.bytes == 80 + PLAIN_FRAME + 48 + FPU_FRAME + 0


def test_a_stack_that_is_too_small(tmp_path: Path) -> None:
    found = planted(tmp_path, "int main() { volatile char a[5000]; a[1] = 2; return a[1]; }")
    assert found.faults == ()
    assert found.limit == 4096
    (error,) = found.overflows()
    assert error.startswith("error: the stack may need 5,0")
    assert "and has 4,096" in error


def test_a_switch_by_a_table_and_a_library_without_source_have_a_bound(tmp_path: Path) -> None:
    cases = "".join(f"case {i}: use({i * i + 7}); return use(v) + {i};" for i in range(12))
    code = f"""volatile int v; volatile double d; volatile unsigned long long u;
    int use(int i) {{ v = i; return i; }}
    int main() {{ d = d / 3.0; u = u / 7; switch (v) {{ {cases} }} return 0; }}"""
    found = planted(tmp_path, code)
    assert found.faults == ()
    assert found.roots[0].bytes > 16


@pytest.mark.parametrize(
    ("code", "expected"),
    [
        (
            "int f(int n) { return n ? f(n / 2) * 3 + n : 1; } {main} return f(v); }",
            "error: f calls itself",
        ),
        (
            "void g(); void f() { if (v--) g(); v++; } void g() { if (v--) f(); v--; } "
            "{main} f(); }",
            "error: f calls itself: f -> g -> f: the stack has no bound",
        ),
        ("{main} volatile char* p = (char*)__builtin_alloca(v); p[1] = 2; }", "no bound"),
        ("int f(int n) { volatile char a[n]; return *a; } {main} return f(v); }", "no bound"),
        ("void (*volatile f)(); {main} f(); }", "main calls through a pointer"),
        (
            "struct A { virtual void f() = 0; }; A* volatile a; {main} a->f(); }",
            "main calls through a pointer",
        ),
        (
            'asm(".global nowhere; .set nowhere, 0x100"); extern "C" void nowhere(); '
            "{main} nowhere(); }",
            "main calls what is not a function: its stack has no size",
        ),
        (
            '{main} asm volatile("push {r0-r3}\\n pop {r0-r3}"); }',
            "main has inline assembly that moves the stack pointer: 16 bytes, and 0 of",
        ),
        ('{main} asm volatile("sub sp, sp, r0\\n add sp, sp, r0"); }', "main moves the stack"),
        ('{main} asm volatile("mov sp, r0"); }', "main moves the stack pointer: mov sp, r0"),
        ('{main} asm volatile("msr msp, r0"); }', "main moves the stack pointer to another stack"),
        ('{main} asm volatile("1: push {r0}\\n bne 1b"); }', "differs between two ways"),
    ],
)
def test_what_has_no_bound_is_refused(tmp_path: Path, code: str, expected: str) -> None:
    code = "volatile int v;\n" + code.replace("{main}", 'extern "C" int main() {')
    faults = planted(tmp_path, code).faults
    assert any(expected in fault for fault in faults), faults
    assert all(fault.startswith(f"{tmp_path}/planted.cpp:2: error: ") for fault in faults), faults


def test_the_proof_of_the_quad_has_its_stack_and_its_memory(
    capsys: pytest.CaptureFixture[str],
) -> None:
    """The sums of the parts are the whole."""
    needs_toolchain()
    assert main(["prove", str(HOME / "graph" / "quad.yaml"), "--board", "fmu_v2", "--json"]) == 0
    facts = json.loads(capsys.readouterr().out)
    assert facts["image_errors"] == []
    levels = {row["level"] for row in facts["stack"]}
    worst = {
        level: max(r["bytes"] + r["frame_bytes"] for r in facts["stack"] if r["level"] == level)
        for level in levels
    }
    assert 0 <= facts["stack_bytes"] - sum(worst.values()) < 8
    assert facts["stack_bytes"] < facts["stack_limit_bytes"] == 64 * 1024
    assert facts["fault_stack_bytes"] < facts["fault_stack_limit_bytes"] == 1024
    names = {row["name"] for row in facts["stack"]}
    assert {"start and monitor", "the timer's handler", "rate_control", "logger"} <= names

    memory = facts["memory"]
    assert memory["flash_bytes"] < memory["flash_limit_bytes"] == 2_080_768
    assert memory["ram_bytes"] < memory["ram_limit_bytes"]
    parts = [memory[part] for part in ("topics", "tasks", "apps", "drivers", "others")]
    for key in ("flash_bytes", "ram_bytes"):
        known = sum(sizes[key] for part in parts for sizes in part.values())
        assert 0 <= memory[key] - known < memory[key] / 12  # gaps, and texts without a symbol
    for topic, slots in memory["topic_bytes"].items():
        if topic in memory["topics"]:
            assert memory["topics"][topic]["ram_bytes"] >= slots
    assert set(memory["nodes"]) == {task["name"] for task in facts["tasks"]}
    assert memory["nodes"]["rate_control"]["flash_bytes"] > 500
