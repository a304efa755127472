"""The slot formula of the compiler and that of the explorer are the same, on every topology."""

import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[3]
sys.path.insert(0, str(ROOT / "codegen"))

from stator.plan.topics import Use, slots_needed  # noqa: E402

EXPLORER = ROOT / "tests" / "runtime" / "core" / "explorer"
LIST = """
#include <cstdio>
#include "topology.hpp"
using namespace stator::explorer;
int main() {
    for (unsigned depth : {1U, 2U, 4U, 8U, 16U}) {
        for (unsigned levels = 1; levels <= 4; ++levels) {
            auto all = all_topologies(levels, depth);
            if (levels < 3) {
                for (const auto& shared : shared_level_topologies(levels, depth)) {
                    all.push_back(shared);
                }
            }
            const auto once = all;
            for (unsigned burst : {2U, 3U, 5U, 16U}) {
                for (const auto& often : with_burst(once, burst)) all.push_back(often);
            }
            for (const auto& t : all) std::printf("%s: %u\\n", t.name().c_str(), t.slots());
        }
    }
}
"""


@pytest.fixture(scope="module")
def listed(tmp_path_factory: pytest.TempPathFactory) -> list[str]:
    compiler = shutil.which("c++") or shutil.which("g++") or shutil.which("clang++")
    assert compiler is not None, "a C++ compiler is needed; ./stator setup installs one"
    folder = tmp_path_factory.mktemp("slots")
    (folder / "list.cpp").write_text(LIST, encoding="utf-8")
    program = folder / "list"
    subprocess.run(
        [
            compiler,
            "-std=c++20",
            f"-I{EXPLORER}",
            str(folder / "list.cpp"),
            str(EXPLORER / "topology.cpp"),
            "-o",
            str(program),
        ],
        check=True,
    )
    output = subprocess.run([program], check=True, capture_output=True, text=True)
    return output.stdout.splitlines()


def slots_of(line: str) -> tuple[int, int]:
    """What the compiler computes for a line such as `1r 2b3 3q depth 2: 4`, and what it says."""
    users, _, rest = line.partition(" depth ")
    depth, _, slots = rest.partition(": ")
    uses = [
        Use(
            int(level),
            held=int(role in "rqbB"),
            reads_queue=role in "qB",
            publications=int(burst or 1) if role in "wbB" else 0,
        )
        for level, role, burst in re.findall(r"(\d)(\w)(\d*)", users)
    ]
    return slots_needed(uses, int(depth)), int(slots)


def test_formulas_agree(listed: list[str]) -> None:
    assert len(listed) == 5 * (3 + 21 + 117 + 528 + 8 + 97 + 4 * 669)
    for line in listed:
        compiled, explored = slots_of(line)
        assert compiled == explored, line
