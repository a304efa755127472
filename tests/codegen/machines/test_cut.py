"""How the compiler cuts a graph at its links, and what it computes of them."""

from __future__ import annotations

import random
from dataclasses import replace
from fractions import Fraction
from pathlib import Path

import pytest

from stator import HOME
from stator import __main__ as cli
from stator.graph.model import Link
from stator.machines.links import Carried, bound_us, directions, link_lines
from stator.pipeline import make_plan
from stator.plan.hash import graph_hash

COMPANION = HOME / "graph" / "quad_companion.yaml"


def test_readers_on_another_machine_read_copies() -> None:
    nodes = make_plan(str(COMPANION), "sitl").graph.nodes
    moved, standby = nodes["position_control"], nodes["position_control_standby"]
    assert moved.inputs["position"].topic == "vehicle_local_position_on_companion"
    assert moved.triggers[0].name == "vehicle_local_position_on_companion"
    assert standby.inputs["position"].topic == "vehicle_local_position"
    assert (moved.machine, standby.machine) == ("companion", "fmu")
    assert moved.params == standby.params
    # What reads on the publisher's machine is as it was.
    assert nodes["attitude_control"].inputs["setpoint"].topic == "vehicle_attitude_setpoint"
    assert set(nodes["fmu_companion_sender"].inputs) == {
        "vehicle_local_position",
        "vehicle_status",
        "trajectory_setpoint",
    }


def test_one_line_moves_a_node(tmp_path: Path) -> None:
    graph = tmp_path / "moved.yaml"
    graph.write_text(
        f"include: [{{file: {COMPANION.name}}}]\nboard: fmu_v2\n"
        "nodes: {position_control: {machine: fmu, standby: null}}\n"
    )
    nodes = make_plan(str(graph), "sitl").graph.nodes
    assert nodes["position_control"].inputs["position"].topic == "vehicle_local_position"
    assert "position_control_selector" not in nodes
    assert nodes["fmu_companion_sender"].inputs == {}


def test_the_hash_sees_where_a_node_runs(tmp_path: Path) -> None:
    graph = tmp_path / "quad_companion.yaml"
    text = COMPANION.read_text()
    hashes = set()
    for baud in ("every: 10 ms", "every: 12 ms"):
        graph.write_text(text.replace("every: 10 ms", baud))
        hashes.add(graph_hash(make_plan(str(graph), "sitl")))
    assert len(hashes) == 2


def test_the_most_urgent_topic_goes_first() -> None:
    plan = make_plan(str(COMPANION), "sitl")
    there, back = directions(plan.graph)
    assert [c.topic for c in there.topics] == [
        "vehicle_local_position",
        "vehicle_status",
        "trajectory_setpoint",
    ]
    assert [c.topic for c in back.topics] == ["vehicle_attitude_setpoint_by_companion"]
    # 136 bytes, of which none is padding at the end, and 9 of the frame; 10 bits each.
    position = there.topics[0]
    assert (position.bytes, position.period_us) == (145, 10_000)
    assert position.wire_us == Fraction(1_450_000_000, 921_600) + 5
    assert link_lines(plan.graph)[0].startswith("link fmu -> companion: 921600 baud, load 21 %")


def test_the_bound_of_a_topic_alone_is_its_wire_and_what_may_block_it() -> None:
    carried = [
        Carried(name, 0, Fraction(us), Fraction(10_000)) for name, us in (("a", 100), ("b", 300))
    ]
    assert bound_us(0, carried, 0) == 300 + 100
    assert bound_us(1, carried, 50) == 100 + 300 + 50


def test_there_is_no_bound_beyond_the_wire() -> None:
    carried = [Carried(name, 0, Fraction(60), Fraction(100)) for name in "ab"]
    assert bound_us(0, carried, 0) is not None
    assert bound_us(1, carried, 0) is None


def simulated(carried: list[Carried], phases: list[int], until_us: int) -> list[Fraction]:
    """The longest way of each topic: one frame at a time, the most urgent that waits first."""
    due = [Fraction(phase) for phase in phases]
    waiting: dict[int, Fraction] = {}
    worst = [Fraction(0)] * len(carried)
    now = Fraction(0)
    while now < until_us:
        for i, item in enumerate(carried):
            while due[i] <= now:
                waiting.setdefault(i, due[i])  # a newer one would only be younger
                due[i] += item.period_us
        if not waiting:
            now = min(due)
            continue
        first = min(waiting)
        now += carried[first].wire_us
        worst[first] = max(worst[first], now - waiting.pop(first))
    return worst


@pytest.mark.parametrize("seed", range(8))
def test_no_simulated_way_is_longer_than_its_bound(seed: int) -> None:
    draw = random.Random(seed)
    reached = Fraction(0)
    for _ in range(25):
        count = draw.randint(2, 6)
        periods = [draw.choice((1, 2, 4, 5, 10, 20)) * 1000 for _ in range(count)]
        load = draw.uniform(0.3, 0.95)
        shares = [draw.random() + 0.05 for _ in range(count)]
        wires = [
            max(1, int(load * share / sum(shares) * period))
            for share, period in zip(shares, periods, strict=True)
        ]
        carried = [
            Carried(f"t{i}", 0, Fraction(wire), Fraction(period))
            for i, (wire, period) in enumerate(zip(wires, periods, strict=True))
        ]
        bounds = [bound_us(i, carried, 0) for i in range(count)]
        for phases in ([0] * count, [draw.randint(0, period) for period in periods]):
            for way, bound in zip(simulated(carried, phases, 100_000), bounds, strict=True):
                assert bound is not None
                assert way <= bound
                reached = max(reached, way / bound)
    assert reached > Fraction(9, 10)


def test_a_link_of_another_speed_has_other_times() -> None:
    plan = make_plan(str(COMPANION), "sitl")
    (wire,) = plan.graph.wires
    link: Link = replace(wire.link, baud=3_000_000)
    faster = replace(plan.graph, wires=(replace(wire, link=link),))
    for before, after in zip(directions(plan.graph), directions(faster), strict=True):
        assert after.load < before.load / 2


@pytest.mark.parametrize(
    ("command", "message"),
    [
        (["build"], "several machines, which fly in virtual time only"),
        (["run"], "several machines, which fly in virtual time only"),
        (["prove"], "it has several machines, and the proof is for one"),
        (["fly", "--times", "random"], "expected a graph of one machine, found several"),
        (["fly", "--fail", "compagnon.kill@3"], "unknown part 'compagnon' of this graph"),
    ],
    ids=["build", "run", "prove", "times", "fail"],
)
def test_what_cannot_be_done_is_refused(
    command: list[str], message: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert cli.main([command[0], str(COMPANION), *command[1:]]) != 0
    assert message in capsys.readouterr().err
