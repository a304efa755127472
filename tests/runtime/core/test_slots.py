"""The slot formula of the compiler and that of the explorer are the same, on every topology."""

import shutil
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[3]
sys.path.insert(0, str(ROOT / "codegen"))

from stator.diagnostics import Mark  # noqa: E402
from stator.graph.model import Message, Topic, TopicConfig  # noqa: E402
from stator.plan.topics import slots_needed  # noqa: E402

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
    """What the compiler computes for a line such as `1r 2w 3q depth 2: 4`, and what it says."""
    mark = Mark(ROOT, 1, 1)
    users, _, rest = line.partition(" depth ")
    depth, _, slots = rest.partition(": ")
    roles = {f"user{i}": (int(user[0]), user[1]) for i, user in enumerate(users.split())}
    publishers = tuple(name for name, (_, role) in roles.items() if role in "wbB")
    readers = tuple((name, "input") for name, (_, role) in roles.items() if role in "rqbB")
    topic = Topic(
        "topic",
        Message("Message", "", (), mark),
        publishers,
        readers,
        TopicConfig(None, int(depth), True, None),
    )
    levels = {name: level for name, (level, _) in roles.items()}
    reading = [levels[name] for name, _ in readers]
    return slots_needed(topic, levels, reading, int(depth)), int(slots)


def test_formulas_agree(listed: list[str]) -> None:
    assert len(listed) == 5 * (3 + 21 + 117 + 528 + 8 + 97)
    for line in listed:
        compiled, explored = slots_of(line)
        assert compiled == explored, line
