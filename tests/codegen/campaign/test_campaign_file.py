"""Files of campaigns: what a row is drawn to be, and what is said of a wrong file."""

from __future__ import annotations

import shlex
from pathlib import Path

import pytest

from stator import HOME
from stator.campaign.definition import Campaign, read_campaign
from stator.campaign.draw import row_of
from stator.diagnostics import Failed

QUAD = HOME / "graph" / "quad.yaml"


def read(text: str, folder: Path) -> Campaign:
    file = folder / "campaign.yaml"
    file.write_text(f"graph: {QUAD}\n{text}", encoding="utf-8")
    return read_campaign(file)


def refusal(text: str, folder: Path) -> str:
    with pytest.raises(Failed) as failed:
        read(text, folder)
    return "\n".join(error.text() for error in failed.value.errors)


FULL = """
seed: 7
flight:
  vehicle: varied
  wind: {uniform: [2 m/s, 36 km/h]}
  wind_from: {each: [0 deg, 90 deg, 180 deg]}
  gusts: {choice: [none, light]}
  faults:
    - {fault: imu0.stuck, chance: 50 %, at: {uniform: [4 s, 8 s]}, lasts: 200 ms}
    - {fault: random, chance: 20 %, value: 2}
  params:
    rate_control.roll_p: {normal: {mean: 0.15 s/rad, deviation: 0.05 s/rad}}
    rate_control.derivative_cutoff: {choice: [30 Hz, 0.04 kHz]}
"""


def test_a_row_is_drawn_from_what_the_file_says(tmp_path: Path) -> None:
    campaign = read(FULL, tmp_path)
    rows = [row_of(campaign, number) for number in range(300)]
    columns = [row.columns for row in rows]
    wind = [row["wind_m_s"] for row in columns]
    assert 2.0 <= min(wind) < 2.5
    assert 9.5 < max(wind) <= 10.0
    assert [row["wind_from_deg"] for row in columns[:4]] == [0.0, 90.0, 180.0, 0.0]
    assert {row["gusts"] for row in columns} == {"none", "light"}
    assert 100 < sum("imu0.stuck" in row["faults"] for row in columns) < 200
    assert 30 < sum("random=2" in row["faults"] for row in columns) < 90
    gains = [row["rate_control.roll_p"] for row in columns]
    assert 0.13 < sum(gains) / len(gains) < 0.17
    assert min(gains) >= 0.0
    assert {row["rate_control.derivative_cutoff"] for row in columns} == {30.0, 40.0}
    assert len({row["seed"] for row in columns}) == len(rows)


def test_a_row_depends_on_its_number_and_the_seed_only(tmp_path: Path) -> None:
    campaign = read(FULL, tmp_path)
    alone = row_of(campaign, 123)
    assert row_of(read(FULL, tmp_path), 123) == alone
    assert row_of(read(FULL.replace("seed: 7", "seed: 8"), tmp_path), 123) != alone


def test_one_more_input_leaves_the_others(tmp_path: Path) -> None:
    before = row_of(read("flight: {wind: {uniform: [1 m/s, 9 m/s]}}", tmp_path), 5).columns
    more = "flight: {gusts: {choice: [none, light]}, wind: {uniform: [1 m/s, 9 m/s]}}"
    after = row_of(read(more, tmp_path), 5).columns
    assert after | {"gusts": "none"} == before


def test_the_words_of_a_row_are_those_of_fly(tmp_path: Path) -> None:
    campaign = read(
        "flight: {wind: 3.5 m/s, duration: 1 min, params: {rate_control.derivative_cutoff: 40 Hz}}",
        tmp_path,
    )
    words = shlex.join(row_of(campaign, 0).words)
    assert words.endswith("--duration 60 --wind 3.5 --param 'rate_control.derivative_cutoff=40 Hz'")


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("fly: {}", "campaign.yaml:2:1: error: unknown key 'fly'"),
        ("flights: 3", "missing key 'flight'"),
        ("flight: {wind: 3}", ":2:16: error: expected a number with its unit, found '3'"),
        ("flight: {wind: {uniform: [5 m/s, 5 m/s]}}", "expected a lower and a higher bound"),
        ("flight: {wind: {uniform: [5 m/s, 70 m/s]}}", "expected a value of 50 m/s or less"),
        ("flight: {wind: {uniform: [5 m/s]}}", "expected a list of 2 items, found 1"),
        ("flight: {wind: {log_uniform: [0 m/s, 5 m/s]}}", "a higher bound above 0"),
        ("flight: {wind: {normal: {mean: 5 m/s}}}", "missing key 'deviation'"),
        ("flight: {wind: {evenly: [1 m/s]}}", ":2:17: error: unknown key 'evenly'"),
        (
            "flight: {wind: {each: [1 m/s], choice: [2 m/s]}}",
            "expected one way to draw, found 2",
        ),
        ("flight: {gusts: strong}", "expected none, light, moderate or severe, found 'strong'"),
        ("flight: {mission: square.yaml}", ":2:19: error: missing mission file 'square.yaml'"),
        ("flight: {faults: [{fault: imu0.stuck}]}", "missing key 'at'"),
        ("flight: {faults: [{fault: imu0.stock, at: 3 s}]}", "unknown fault 'stock' of imu0"),
        ("flight: {faults: [{fault: imu7.stuck, at: 3 s}]}", "unknown part 'imu7' of this graph"),
        (
            "flight: {params: {rate_control.roll: 1}}",
            "unknown parameter 'rate_control.roll'",
        ),
        (
            "flight: {params: {rate_control.derivative_cutoff: 40}}",
            "expected a number with its unit for 'derivative_cutoff', found '40'",
        ),
        ("flight: {}\nsuccess: {limits: {coridor_m: {most: 1 m}}}", "did you mean 'corridor_m'?"),
        ("flight: {}\nsuccess: {limits: {corridor_m: {most: 1}}}", "write 1 m"),
        ("flight: {}\nsuccess: {limits: {corridor_m: {}}}", "missing key 'most' or 'least'"),
        ("flight: {}\nfind: {input: wind, failures: 1 %}", "unknown input 'wind' of `flight`"),
    ],
)
def test_what_is_wrong_in_a_file(text: str, message: str, tmp_path: Path) -> None:
    assert message in refusal(text, tmp_path)


def test_a_graph_that_is_not_there(tmp_path: Path) -> None:
    file = tmp_path / "campaign.yaml"
    file.write_text("graph: quad.yml\nflight: {}\n", encoding="utf-8")
    with pytest.raises(Failed) as failed:
        read_campaign(file)
    assert ":1:8: error: missing graph file 'quad.yml'" in failed.value.errors[0].text()


def test_the_example_of_the_documents_is_right(tmp_path: Path) -> None:
    text = (HOME / "docs" / "campaigns.md").read_text(encoding="utf-8")
    file = tmp_path / "example.yaml"
    example = text.partition("```yaml\n")[2].partition("```")[0]
    file.write_text(example.replace("../", f"{HOME}/graph/"), encoding="utf-8")
    campaign = read_campaign(file)
    assert [fault.name for fault in campaign.faults] == ["gnss0.loss"]
    assert campaign.find == ("wind", 0.01)


@pytest.mark.parametrize(
    "file", sorted((HOME / "graph" / "campaigns").glob("*.yaml")), ids=lambda file: file.stem
)
def test_our_own_campaigns_are_right(file: Path) -> None:
    assert read_campaign(file).doc
