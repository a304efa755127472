"""Plans of random graphs against the full search; the same graphs run with random preemption."""

from __future__ import annotations

import json
import subprocess
from random import Random
from typing import TYPE_CHECKING

import pytest
from tests.codegen.plan.needed import compiler, needed_slots
from tests.codegen.plan.random_graphs import (
    RUN,
    Part,
    Services,
    graph_text,
    make_part,
    make_services,
    source_part,
    write_apps,
    write_code,
)

from stator import HOME
from stator.diagnostics import Failed
from stator.emit.emit import write
from stator.pipeline import make_files, make_plan

if TYPE_CHECKING:
    from pathlib import Path

    from stator.plan.plan import Plan
    from stator.plan.topics import TopicPlan

PERIODS_MS = (5, 10, 20)
MAX_DEPTH = 4  # that the search is asked about


def shape(plan: Plan, topic: TopicPlan, parts: list[Part], services: Services) -> str:
    """What each node does with the topic, as `needed_slots.cpp` spells it: from the graph as it was
    made, not from what the compiler made of it."""
    holds: dict[str, str] = {}
    published: dict[str, str] = {}
    made = next((t for part in parts for t in part.topics if t.name == topic.name), None)
    if made is not None:
        for reader in made.readers:
            holds[reader.node] = "n" if reader.way in ("latest", "thinned") else "o"
        for name in made.publishers:
            app = next(n.app for part in parts for n in part.nodes if n.name == name)
            published[name] = f"p{app[-1]}"
    elif topic.name == "mode":
        published["switcher"] = "p1"
    else:
        holds[topic.owner] = "n"
        published["tuner"] = "cp0"
    if services.logger is not None and (topic.log_us is not None or topic.owner):
        name = services.logger.name
        holds[name] = holds.get(name, "") + ("O" if topic.log_us == 0 else "N")
    levels = {task.node.name: task.level for task in plan.tasks}
    names = sorted({*holds, *published}, key=lambda name: (levels[name], name))
    # Only the order of the levels counts.
    ranks = {level: i for i, level in enumerate(sorted({levels[n] for n in names}), start=1)}
    ranked = sorted({f"{ranks[levels[n]]}{holds.get(n, '')}{published.get(n, '')}" for n in names})
    return f"{topic.depth} {' '.join(ranked)}"


def random_graph(seed: int, folder: Path) -> tuple[Plan, list[Part], Services] | None:
    """None: the compiler refuses it, for a queue whose rates do not fit."""
    rng = Random(seed)
    parts = [make_part(rng, "", PERIODS_MS)]
    services = make_services(rng, parts)
    graph = folder / "graph.yaml"
    graph.write_text(graph_text(parts, services), encoding="utf-8")
    try:
        return make_plan(str(graph), None), parts, services
    except Failed as failed:
        rules = {error.rule for error in failed.errors}
        assert rules <= {"depth-small", "depth-rate-unknown", "slots-many"}, failed.errors
        return None


def expect_exact_plans(count: int, folder: Path) -> None:
    write_apps(folder)
    planned: dict[str, set[int]] = {}
    good = 0
    for seed in range(100 * count):
        found = random_graph(seed, folder)
        if found is None:
            continue
        plan, parts, services = found
        for topic in plan.topics.values():
            if topic.publishers and topic.depth <= MAX_DEPTH:
                planned.setdefault(shape(plan, topic, parts, services), set()).add(topic.slots)
        good += 1
        if good == count:
            break
    needed = needed_slots(planned)
    wrong = {topic: (planned[topic], slots) for topic, slots in needed.items()}
    assert {topic: pair for topic, pair in wrong.items() if pair[0] != {pair[1]}} == {}
    print(f"{good} graphs, {len(planned)} shapes of topics")


def test_plans_of_random_graphs_are_exact(tmp_path: Path) -> None:
    expect_exact_plans(500, tmp_path)


@pytest.mark.long
def test_plans_of_many_random_graphs_are_exact(tmp_path: Path) -> None:
    expect_exact_plans(20_000, tmp_path)


# --- the same graphs, run ---

LONG_PERIODS_MS = (40, 60, 70, 100)  # many graphs share the one processor
GRAPHS_OF_A_PROGRAM = 50
RUNTIME = (
    *("core", "host", "virtual", "recording/off", "recording"),
    *("log", "watch", "bytes", "parameters"),
)


def is_good(part: Part, folder: Path) -> bool:
    services = make_services(Random(0), [], all_of_them=True)
    (folder / "part.yaml").write_text(graph_text([part], services), encoding="utf-8")
    try:
        make_plan(str(folder / "part.yaml"), None)
    except Failed:
        return False
    return True


def made_program(seed: int, folder: Path) -> Path:
    """Many random graphs with a logger, a publisher of parameters and modes, as one program."""
    write_apps(folder)
    write_code(folder)
    rng = Random(seed)
    parts: list[Part] = []
    while len(parts) < GRAPHS_OF_A_PROGRAM:
        part = make_part(rng, f"g{len(parts)}_", LONG_PERIODS_MS)
        if is_good(part, folder):
            parts.append(part)
    parts.append(source_part())
    services = make_services(rng, parts, all_of_them=True)
    graph = folder / "graph.yaml"
    graph.write_text(graph_text(parts, services), encoding="utf-8")
    files = make_files(str(graph), None, record=False)
    out = folder / "generated"
    write(files, out)
    topics = make_plan(str(graph), None).topics
    checks = "".join(
        f'    require(topics::{name}.state->free.load() == all_slots({topic.slots}), "{name}");\n'
        for name, topic in topics.items()
        if not topic.takes_turns  # then nothing is marked
    )
    idle = '#include "topics.hpp"\nnamespace stator {\ninline void check_idle() {\n'
    (out / "idle.hpp").write_text(f"#pragma once\n{idle}{checks}}}\n}}\n", encoding="utf-8")
    tasks = [name for name in files if name.startswith("tasks/")]
    # In one piece: that takes a tenth of the time.
    (out / "all.cpp").write_text("".join(f'#include "{t}"\n' for t in tasks), encoding="utf-8")
    sources = [out / name for name in files if name.endswith(".cpp") and name not in tasks]
    sources += [out / "all.cpp", RUN / "main.cpp", HOME / "runtime" / "virtual" / "virtual.cpp"]
    ports = sorted({(out / name).parent for name in files if name.startswith("ports/")})
    includes = [out, out / "include", folder, RUN, *ports, *(HOME / "runtime" / r for r in RUNTIME)]
    includes.append(HOME / "runtime" / "parameters" / "port")
    program = folder / "program"
    subprocess.run(
        [
            *(compiler(), "-std=c++20", "-O1", "-DSTATOR_PREEMPTION_POINTS"),
            *(f"-I{folder}" for folder in includes),
            *(*map(str, sources), "-o", str(program)),
        ],
        check=True,
    )
    return program


def expect_to_run(seed: int, folder: Path) -> None:
    program = made_program(seed, folder)
    for run in (1, 2):
        result = subprocess.run([program, str(run)], capture_output=True, text=True, check=False)
        assert result.returncode == 0, result.stderr
        facts = json.loads(result.stdout)
        assert facts["activations"] > 10_000
        assert facts["refused"] > 100  # some nodes try to publish too often


def test_random_graphs_run_under_random_preemption(tmp_path: Path) -> None:
    expect_to_run(1, tmp_path)


@pytest.mark.long
@pytest.mark.parametrize("seed", range(2, 21))
def test_many_random_graphs_run_under_random_preemption(seed: int, tmp_path: Path) -> None:
    expect_to_run(seed, tmp_path)
