"""Whether a recording fits what the logger can write is known before the flight."""

from __future__ import annotations

import math
import re
from dataclasses import replace
from fractions import Fraction
from pathlib import Path

import pytest

from stator import HOME
from stator.diagnostics import UserError
from stator.emit.recording import (
    blocks_with_recording,
    bytes_per_second,
    check_recording_rate,
    storage_bytes_per_second,
    stream_bytes,
)
from stator.pipeline import make_plan
from stator.plan.log_rate import blocks_at_once
from stator.plan.plan import Plan
from stator.plan.rates import Rates

TOPICS = 230


def planned(folder: Path, period: str) -> Plan:
    """A graph with 230 topics at 100 Hz."""
    (folder / "messages").mkdir()
    (folder / "messages" / "Count.yaml").write_text(
        "doc: A number.\nfields: {value: {type: uint32, doc: It.}}\n"
    )
    (folder / "apps" / "tick").mkdir(parents=True)
    (folder / "apps" / "tick" / "tick.yaml").write_text(
        "doc: It counts.\noutputs: {count: {message: Count, doc: So far.}}\n"
    )
    nodes = "".join(
        f"  n{i}: {{app: tick, trigger: {{every: 10 ms}}, outputs: {{count: t{i}}}}}\n"
        for i in range(TOPICS)
    )
    (folder / "many.yaml").write_text(
        f"board: sitl\nnodes:\n{nodes}"
        f"  logger: {{trigger: {{every: {period}}}, outputs: {{block: log_block}}}}\n"
        "  log_sink:\n    device: log_storage\n    trigger: {topic: log_block}\n"
        "    inputs: {block: log_block}\n"
    )
    return make_plan(str(folder / "many.yaml"), None)


def test_a_recording_that_the_logger_cannot_write_is_refused_with_a_period_that_can(
    tmp_path: Path,
) -> None:
    (tmp_path / "slow").mkdir()
    (tmp_path / "fast").mkdir()
    with pytest.raises(UserError) as refused:
        check_recording_rate(planned(tmp_path / "slow", "8 ms"))
    text = str(refused.value)
    assert "many.yaml:233:29: error: with the recording, the log takes up to 8" in text
    assert "--no-record flies without the recording" in text
    hinted = re.search(r"hint: write `every: (\d+ ms)`", text)
    assert hinted is not None
    check_recording_rate(planned(tmp_path / "fast", hinted[1]))


def test_streams_hold_four_periods_of_the_logger_and_more_where_levels_are_threads(
    tmp_path: Path,
) -> None:
    plan = planned(tmp_path, "5 ms")
    ticks = plan.task("n0").level
    record_bytes = 8 + 2 + 4  # its head, and the tag, the number and the hash of one output
    at_once = TOPICS * record_bytes
    assert stream_bytes(plan)[ticks] == power_of_two(at_once * (1 + 20 / 10))
    imu = plan_of("quad").task("imu0").level
    one_core, threads = (
        stream_bytes(make_plan(str(HOME / "graph" / "quad.yaml"), board))[imu]
        for board in ("fmu_v2", "linux")
    )
    assert threads >= 500 / 20 * one_core / 2  # powers of two


def power_of_two(least: float) -> int:
    return int(2 ** math.ceil(math.log2(least)))


def test_an_activation_of_the_logger_writes_somewhat_more_than_the_log_takes() -> None:
    """A third more, in whole blocks, and one: at 5 ms, of 0.19 and 0.95 kB of samples, or 3.8 kB
    with the recording."""
    quad, outdoor = plan_of("quad"), plan_of("quad_outdoor")
    assert blocks_at_once(quad.graph, quad.topics) == 2
    assert blocks_at_once(outdoor.graph, outdoor.topics) == 3
    assert blocks_with_recording(outdoor) == 7


def test_the_storage_has_a_record_for_each_block(tmp_path: Path) -> None:
    """Of which the logger publishes several at once: about 800 a second, not one each 5 ms."""
    plan = planned(tmp_path, "5 ms")
    stored = plan.task("log_sink").level
    assert stream_bytes(plan)[stored] >= (8 + 800 * 20e-3) * 10


def plan_of(name: str) -> Plan:
    return make_plan(str(HOME / "graph" / f"{name}.yaml"), None)


@pytest.mark.parametrize("name", ["quad", "quad_outdoor"])
def test_the_card_of_the_board_takes_it(name: str) -> None:
    graph = plan_of(name)
    stored = storage_bytes_per_second(graph)
    assert stored is not None
    assert bytes_per_second(graph, usual=True) < stored


def test_an_output_that_is_published_seldom_counts_with_its_interval() -> None:
    graph = plan_of("quad_outdoor")
    worst, usual = Rates(graph.graph), Rates(graph.graph, usual=True)
    assert usual.topic("mission_items") == 100_000
    assert worst.topic("mission_items") == worst.node("mission0")
    # Stations, terminals, consoles and calibration ask the node of parameters.
    assert usual.topic("parameter_request") == Fraction(100_000, 4)
    assert usual.topic("sensor_gyro") == worst.topic("sensor_gyro")
    assert bytes_per_second(graph, usual=True) < bytes_per_second(graph)


def test_a_longer_interval_takes_less_by_its_samples() -> None:
    """Of a log piece: tag, number and 264 bytes, 10 times a second; none of it is logged."""
    graph = plan_of("quad_outdoor")
    sink = graph.graph.nodes["log_sink"]
    output = sink.outputs["piece"]
    seldom = replace(output, port=replace(output.port, min_interval_us=200_000))
    before = bytes_per_second(graph, usual=True)
    sink.outputs["piece"] = seldom
    assert before - bytes_per_second(graph, usual=True) == pytest.approx(5 * 266, abs=1)
