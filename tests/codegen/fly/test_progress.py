"""How far a flight is, from the record of the true flight."""

from pathlib import Path

from stator.flight.progress import seconds_flown


def test_seconds_are_hundreds_of_rows(tmp_path: Path) -> None:
    truth = tmp_path / "flight.truth"
    assert seconds_flown(truth) == 0.0
    truth.write_bytes(b"time_us position_n on_ground \n" + bytes(3 * 8 * 250))
    assert seconds_flown(truth) == 2.5
