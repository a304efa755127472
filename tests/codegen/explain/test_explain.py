"""What `./stator explain` says of nodes and topics."""

import pytest

from stator import HOME
from stator.commands.explain import explain
from stator.pipeline import make_plan
from stator.plan.plan import Plan


@pytest.fixture(scope="module")
def plan() -> Plan:
    return make_plan(str(HOME / "graph" / "quad_outdoor.yaml"), None)


def test_lines_fit_a_terminal(plan: Plan) -> None:
    for name in (*plan.graph.nodes, *plan.topics):
        for line in explain(plan, name) or []:
            assert len(line) <= 100, line


def test_nothing_is_lost_where_a_row_goes_on_below(plan: Plan) -> None:
    text = " ".join(" ".join(explain(plan, "commander") or []).split())
    above = [task.node.name for task in plan.tasks if task.level > plan.task("commander").level]
    assert "preempted by " + ", ".join(above) + " preempts" in text


def test_a_node_says_what_its_topics_take(plan: Plan) -> None:
    names = ("vehicle_thrust_setpoint", "vehicle_torque_setpoint", "rate_control_params")
    owned = [plan.topics[name] for name in names]
    expected = sum(topic.slots * topic.message.bytes for topic in owned)
    lines = explain(plan, "rate_control") or []
    assert any(f" {expected} bytes of slots" in line for line in lines), lines


def test_what_is_neither(plan: Plan) -> None:
    assert explain(plan, "nothing") is None


def test_a_message_and_its_topics_show_the_fields(plan: Plan) -> None:
    row = "field xyz float[3], m/s^2, frame B: Specific force; -9.81 along z at rest."
    for name in ("sensor_accel", "SensorAccel"):
        assert row in " ".join(" ".join(explain(plan, name) or []).split())
    lines = explain(plan, "VehicleStatus") or []
    assert "  topics                vehicle_status" in lines
    assert any("disarmed 1, armed 2" in line for line in lines)


def test_a_chain_goes_from_node_to_node(plan: Plan) -> None:
    (chain,) = plan.graph.chains
    text = " ".join(" ".join(explain(plan, chain.name) or []).split())
    assert text.startswith("gyro_to_motor: a chain of 4 nodes")
    assert "deadline 500 us, from the release of imu0" in text
    assert "begins imu0 (level 14): irq data_ready" in text
    assert "then rate_control (level 13) by sensor_gyro (each activation reads one" in text
    assert "and vehicle_thrust_setpoint (latest)" in text
    assert "waits for no other node" in text
