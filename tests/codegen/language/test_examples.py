"""The graphs of graph/examples: each shows one feature of the language, and here what it means."""

from __future__ import annotations

from pathlib import Path

import pytest

from stator.graph.check import check
from stator.plan.plan import Plan, plan

EXAMPLES = Path(__file__).resolve().parents[3] / "graph" / "examples"


def planned(name: str) -> Plan:
    return plan(*check(EXAMPLES / f"{name}.yaml"))


def levels(result: Plan) -> dict[str, int]:
    return {task.node.name: task.level for task in result.tasks}


@pytest.mark.parametrize("path", sorted(EXAMPLES.glob("*.yaml")), ids=lambda path: path.stem)
def test_is_good(path: Path) -> None:
    planned(path.stem)


@pytest.mark.parametrize("path", sorted(EXAMPLES.glob("*.yaml")), ids=lambda path: path.stem)
def test_says_what_it_shows(path: Path) -> None:
    assert path.read_text(encoding="utf-8").startswith("# ")


def test_timer() -> None:
    (trigger,) = planned("timer").graph.nodes["counter"].triggers
    assert (trigger.period_us, trigger.offset_us) == (10_000, 2_000)


def test_topic() -> None:
    adder = planned("topic").graph.nodes["adder"]
    assert adder.inputs["extra"].max_age_us == 50_000
    assert adder.trigger_of("fast_count") is not None
    assert adder.trigger_of("slow_count") is None


def test_thinned() -> None:
    (trigger,) = planned("thinned").graph.nodes["adder"].triggers
    assert trigger.is_thinned
    assert trigger.min_interval_us == 4_000


def test_queue_depth_follows_from_the_rates() -> None:
    # 40 ms / 10 ms, one more for the phase, the next power of two.
    assert planned("queue").topics["count"].depth == 8


def test_several_triggers() -> None:
    triggers = planned("several_triggers").graph.nodes["adder"].triggers
    assert [trigger.kind for trigger in triggers] == ["topic", "every", "every"]
    assert triggers[0].max_interval_us == 100_000


def test_device_is_bound_by_the_board() -> None:
    result = planned("device")
    assert result.graph.nodes["imu0"].interface.name == "imu"
    assert result.board.devices["imu0"].driver == "imu/sim"


def test_priorities() -> None:
    assert levels(planned("priorities")) == {"urgent": 15, "patient": 1}


def test_deadlines_give_levels() -> None:
    assert levels(planned("deadlines")) == {"hurried": 2, "counter": 1, "adder": 1}


def test_params_are_in_the_unit_of_the_interface() -> None:
    params = planned("params").graph.nodes["counter"].params
    assert params == {"first": 100, "rest": pytest.approx(0.25)}


def test_publishers() -> None:
    assert planned("publishers").topics["count"].publishers == ("left", "right")


def test_modes() -> None:
    modes = planned("modes").graph.modes
    assert modes is not None
    assert modes.sets == {"slow": ("careful",), "fast": ("bold",)}
    assert (modes.initial, modes.publisher) == ("slow", "mode_switch")


def test_budgets_of_the_board_and_of_the_graph() -> None:
    nodes = planned("chain").graph.nodes
    assert nodes["counter"].budget_us == 20  # budgets/desk.yaml
    assert nodes["adder"].budget_us == 30  # the graph's own, not the 25 us of the file


def test_include() -> None:
    nodes = planned("include").graph.nodes
    assert list(nodes) == ["left_counter", "left_adder", "right_counter"]
    assert nodes["left_counter"].triggers[0].period_us == 10_000
    assert nodes["right_counter"].triggers[0].period_us == 20_000
    assert nodes["right_counter"].params["first"] == 10
    assert nodes["left_adder"].inputs["count"].topic == "left_count"
    assert nodes["left_adder"].inputs["count"].max_age_us == 20_000


def test_log() -> None:
    topics = planned("log").topics
    logged = {name: topics[name].log_us for name in ("every_one", "at_a_rate", "not_at_all")}
    assert logged == {"every_one": 0, "at_a_rate": 100_000, "not_at_all": None}
    assert topics["log_block"].log_us is None  # the logger's own
    # The sink does not outrank the logger here, so a whole burst of blocks is kept.
    assert topics["log_block"].depth == 8
    assert topics["first_params"].log_us is None  # logged as parameters


def test_publishers_that_modes_exchange_do_not_add_up() -> None:
    # careful publishes every 10 ms or bold every 5 ms, never both.
    assert planned("modes").topics["count"].period_us == 5_000


def test_parameters_change_where_a_node_publishes_them() -> None:
    assert planned("params").topics["counter_params"].publishers == ()
    changed = planned("param_change").topics["counter_params"]
    assert changed.publishers == changed.kept_by == ("parameters",)
    # The one that counts, which the publisher copies and the more urgent counter may read, and the
    # next.
    assert changed.slots == 2
