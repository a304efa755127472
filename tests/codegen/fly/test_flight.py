"""How a flight is judged, on flights whose errors are known by construction."""

import dataclasses
import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from stator.flight.judge import IN_WIND, Judgement, judge
from stator.flight.log import (
    Flight,
    Floats,
    Truth,
    UnreadableFlight,
    read_flight,
    read_truth,
    read_truth_columns,
)

TAKE_OFF_S, HOLD_S, LAND_S, TOUCHDOWN_S, END_S = 5.0, 10.0, 40.0, 48.0, 50.0
MANUAL, HOLD, TAKEOFF, LAND = 0, 4, 17, 18


def level(count: int) -> Floats:
    return np.tile([1.0, 0.0, 0.0, 0.0], (count, 1))


def rolled(angles: Floats) -> Floats:
    zero = np.zeros_like(angles)
    return np.column_stack([np.cos(angles / 2), np.sin(angles / 2), zero, zero])


def yawed(angle: float) -> Floats:
    return np.array([math.cos(angle / 2), 0.0, 0.0, math.sin(angle / 2)])


def product(a: Floats, b: Floats) -> Floats:
    """Hamilton's, row by row."""
    w, x, y, z = np.broadcast_to(a, b.shape).T
    v, i, j, k = b.T
    return np.column_stack(
        [
            w * v - x * i - y * j - z * k,
            w * i + x * v + y * k - z * j,
            w * j - x * k + y * v + z * i,
            w * k + x * j - y * i + z * v,
        ]
    )


def truth() -> Truth:
    time = np.arange(0.0, END_S, 0.01)
    up = np.interp(time, [TAKE_OFF_S, HOLD_S, LAND_S, TOUCHDOWN_S], [0.0, 2.0, 2.0, 0.0])
    position = np.column_stack([np.full_like(time, 1.0), np.full_like(time, -1.0), -up])
    return Truth(time, position, level(time.size), (time < TAKE_OFF_S) | (time >= TOUCHDOWN_S))


def flight(**changes: Any) -> Flight:
    """A good one: 0.05 m north of its setpoint, no error of attitude."""
    attitude_time = np.arange(0.0, END_S, 0.02)
    good = Flight(
        truth=truth(),
        attitude_time_s=attitude_time,
        attitude_q=level(attitude_time.size),
        setpoint_time_s=np.array([0.0, HOLD_S]),
        setpoint=np.array([[1.0, -1.0, 0.0], [0.95, -1.0, -2.0]]),
        status_time_s=np.array([0.0, TAKE_OFF_S, HOLD_S, LAND_S, END_S - 1.0]),
        nav_state=np.array([HOLD, TAKEOFF, HOLD, LAND, LAND]),
        arming_state=np.array([1, 2, 2, 2, 1]),
        landed=True,
        take_off_s=TAKE_OFF_S,
        touchdown_s=TOUCHDOWN_S,
        touchdown_m_s=0.4,
    )
    return dataclasses.replace(good, **changes)


def with_truth(**changes: Any) -> Flight:
    return flight(truth=dataclasses.replace(truth(), **changes))


def texts(judgement: Judgement) -> list[str]:
    return [problem.text for problem in judgement.problems]


def test_good_flight_has_no_problems() -> None:
    judgement = judge(flight())
    assert texts(judgement) == []
    assert judgement.hover is not None
    assert judgement.hover.max_error_m == pytest.approx(0.05)
    assert judgement.hover.rms_error_m == pytest.approx(0.05)
    assert judgement.hover.height_m == pytest.approx(2.0)
    assert judgement.hover.seconds == pytest.approx(LAND_S - HOLD_S, abs=0.02)
    assert judgement.tilt is not None
    assert judgement.tilt.rms_deg == pytest.approx(0.0, abs=1e-6)


def test_hover_error_says_where_and_when() -> None:
    position = truth().position
    position[2000] += [0.0, 0.2, 0.0]  # at 20 s
    judgement = judge(with_truth(position=position))
    assert texts(judgement) == [
        "hover: 0.206 m from the setpoint at 20.00 s, "
        "1.00 m north, -0.80 m east, 2.00 m up (limit 0.15 m)"
    ]


def test_hover_in_wind_is_judged_by_rms() -> None:
    position = truth().position
    position[2000] += [0.0, 5.0, 2.0]
    assert texts(judge(with_truth(position=position), IN_WIND)) == []
    position += [0.0, 0.9, 0.6]
    problems = texts(judge(with_truth(position=position), IN_WIND))
    assert len(problems) == 1
    assert problems[0].startswith("hover: 0.60 m RMS vertically (limit 0.5 m), at most ")
    position += [0.6, 0.0, 0.0]
    problems = texts(judge(with_truth(position=position), IN_WIND))
    assert problems[0].startswith("hover: 1.12 m RMS horizontally (limit 1 m), at most ")


def test_wind_tilts_the_estimate_and_hardens_the_touchdown() -> None:
    tilted = rolled(np.full(flight().attitude_time_s.size, math.radians(1.4)))
    assert texts(judge(flight(attitude_q=tilted, touchdown_m_s=0.9), IN_WIND)) == []
    tilted = rolled(np.full(flight().attitude_time_s.size, math.radians(1.6)))
    assert len(texts(judge(flight(attitude_q=tilted, touchdown_m_s=1.1), IN_WIND))) == 2


def test_error_outside_of_hold_does_not_count() -> None:
    position = truth().position
    position[700] += [9.0, 0.0, 0.0]  # climbing
    position[4500] += [9.0, 0.0, 0.0]  # landing
    assert texts(judge(with_truth(position=position))) == []


def test_free_component_of_a_setpoint_does_not_count() -> None:
    free = np.array([[1.0, -1.0, 0.0], [math.nan, -1.0, -2.0]])
    hover = judge(flight(setpoint=free)).hover
    assert hover is not None
    assert hover.max_error_m == pytest.approx(0.0, abs=1e-12)


def test_flight_that_never_holds_in_the_air_has_not_hovered() -> None:
    on_ground_only = np.array([HOLD, TAKEOFF, TAKEOFF, LAND, LAND])
    judgement = judge(flight(nav_state=on_ground_only))
    assert judgement.hover is None
    assert texts(judgement) == ["no hover: vehicle_status had no hold mode in flight"]


def test_tilt_error_is_the_angle_between_verticals() -> None:
    count = flight().attitude_time_s.size
    judgement = judge(flight(attitude_q=rolled(np.full(count, math.radians(1.0)))))
    assert judgement.tilt is not None
    assert judgement.tilt.rms_deg == pytest.approx(1.0)
    assert texts(judgement)[0].startswith("estimated tilt: RMS error 1.00 deg (limit 0.5 deg), ")
    assert texts(judgement)[0].endswith("greatest error 1.00 deg at 5.00 s")


def test_heading_error_is_no_tilt_error() -> None:
    time = truth().time_s
    q = rolled(np.full(time.size, 0.3))
    estimate = product(yawed(2.0), rolled(np.full(flight().attitude_time_s.size, 0.3)))
    judgement = judge(
        flight(
            truth=dataclasses.replace(truth(), q=q, on_ground=truth().on_ground),
            attitude_q=estimate,
        )
    )
    assert judgement.tilt is not None
    assert judgement.tilt.max_deg == pytest.approx(0.0, abs=1e-6)


def test_sign_of_a_quaternion_means_nothing() -> None:
    q = rolled(np.full(truth().time_s.size, 0.1))
    q[1::3] *= -1.0
    estimate = rolled(np.full(flight().attitude_time_s.size, 0.1))
    estimate[::2] *= -1.0
    judgement = judge(flight(truth=dataclasses.replace(truth(), q=q), attitude_q=estimate))
    assert judgement.tilt is not None
    assert judgement.tilt.max_deg == pytest.approx(0.0, abs=1e-6)


def test_truth_is_interpolated_between_its_rows() -> None:
    time = np.arange(TAKE_OFF_S, TOUCHDOWN_S - 0.02, 0.0137)
    judgement = judge(
        flight(
            truth=dataclasses.replace(truth(), q=rolled(np.sin(truth().time_s))),
            attitude_time_s=time,
            attitude_q=rolled(np.sin(time)),
        )
    )
    assert judgement.tilt is not None
    # Against sin(t), a chord over h = 10 ms is h^2 / 8 off at most: 0.0007 deg.
    assert judgement.tilt.max_deg < 0.001


def test_hard_touchdown() -> None:
    assert texts(judge(flight(touchdown_m_s=0.8))) == [
        "touchdown: 0.80 m/s down at 48.00 s (limit 0.7 m/s)"
    ]


def test_flight_that_did_not_end_says_where_it_was() -> None:
    unfinished = flight(
        landed=False, nav_state=np.array([HOLD, TAKEOFF, HOLD, HOLD, HOLD]), touchdown_m_s=None
    )
    assert texts(judge(unfinished))[-1] == (
        "not landed and disarmed: at 49.99 s in mode hold, 1.00 m north, -1.00 m east, 0.00 m up"
    )


def test_flight_that_never_took_off() -> None:
    judgement = judge(flight(take_off_s=None, touchdown_s=None, touchdown_m_s=None))
    assert texts(judgement) == [
        "no take-off: at 49.99 s in mode landing, 1.00 m north, -1.00 m east, 0.00 m up"
    ]


def test_motors_that_stop_in_the_air() -> None:
    in_the_air = np.zeros_like(truth().on_ground)
    problems = texts(judge(with_truth(on_ground=in_the_air)))
    assert problems[0].startswith("the motors stopped in the air: at 49.99 s")


def test_vehicle_on_its_side() -> None:
    q = level(truth().time_s.size)
    q[-1] = rolled(np.array([math.radians(80.0)]))[0]
    assert texts(judge(with_truth(q=q))) == ["landed on its side: tilted 80 deg (limit 20 deg)"]


def test_vehicle_that_stays_armed() -> None:
    assert texts(judge(flight(arming_state=np.array([1, 2, 2, 2, 2])))) == [
        "vehicle_status was not disarmed at the end"
    ]


def test_several_problems_are_all_told() -> None:
    assert len(texts(judge(flight(touchdown_m_s=0.8, arming_state=np.array([2, 2, 2, 2, 2]))))) == 2


@pytest.mark.parametrize("take_off_s", [None, TAKE_OFF_S])
def test_an_attitude_that_is_not_a_number_is_the_first_problem(take_off_s: float | None) -> None:
    q = level(flight().attitude_time_s.size)
    q[5:, 2] = math.nan
    found = texts(judge(flight(attitude_q=q, take_off_s=take_off_s, landed=False)))
    assert "vehicle_attitude.q is not a number at 0.10 s" in found
    assert not any("nan" in text for text in found)


def test_positions_that_are_no_numbers() -> None:
    position = truth().position
    position[-1, 0] = math.nan
    assert texts(judge(with_truth(position=position))) == [
        "the state of the simulated vehicle is not finite"
    ]


# Another order and fewer columns than the board writes: names decide.
HEAD = "time_us position_n position_e position_d q_w q_x q_y q_z wind_n on_ground "
ROW = [10000, 1, 2, 3, 0.5, -0.5, 0.5, -0.5, 8, 1]


def write_truth(file: Path, head: str, rows: list[list[float]]) -> None:
    file.write_bytes(head.encode() + b"\n" + np.array(rows, dtype="<f8").tobytes())


def test_truth_file(tmp_path: Path) -> None:
    file = tmp_path / "flight.truth"
    write_truth(file, HEAD, [ROW, ROW])
    read = read_truth(file)
    assert read.time_s.tolist() == [0.01, 0.01]
    assert read.position[0].tolist() == [1, 2, 3]
    assert read.q[1].tolist() == [0.5, -0.5, 0.5, -0.5]
    assert read.on_ground.tolist() == [True, True]
    assert read_truth_columns(file)["wind_n"].tolist() == [8, 8]


@pytest.mark.parametrize("content", [b"", b"time_us\n", b"time_us q_w\n" + bytes(8), bytes(80)])
def test_truth_file_of_a_wrong_size(tmp_path: Path, content: bytes) -> None:
    file = tmp_path / "flight.truth"
    file.write_bytes(content)
    with pytest.raises(UnreadableFlight, match="expected a true flight"):
        read_truth(file)


def test_truth_file_without_a_column(tmp_path: Path) -> None:
    file = tmp_path / "flight.truth"
    write_truth(file, HEAD.replace("on_ground", "landed"), [ROW])
    with pytest.raises(UnreadableFlight, match="missing column 'on_ground'"):
        read_truth(file)


class _Log:
    data_list: list[Any] = []  # noqa: RUF012


def test_log_without_a_topic_is_named() -> None:
    with pytest.raises(UnreadableFlight, match="missing topic vehicle_attitude"):
        read_flight(_Log(), truth(), {})
