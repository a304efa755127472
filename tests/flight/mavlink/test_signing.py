"""Signed links, with pymavlink at the other end: keys, replayed frames, and what the log has of
it."""

from __future__ import annotations

import hashlib
import subprocess
from contextlib import closing
from typing import TYPE_CHECKING

from tests.flight.mavlink.vehicle import COMMAND, OUTDOOR, Lockstep, Station, flying, mavlink

if TYPE_CHECKING:
    from pathlib import Path

PHRASE = "a phrase for tests"
KEY = hashlib.sha256(PHRASE.encode()).digest()
OTHER_KEY = bytes(range(32))
TIME = 3_600_000_000_000  # of signatures: a year behind 2015
VERSION = mavlink.MAVLINK_MSG_ID_AUTOPILOT_VERSION
WAITS_S = 1.0


def use(station: Station, key: bytes, link: int, *, signs: bool = True) -> None:
    """From now on nothing counts that has no signature."""
    station.link.setup_signing(key, signs, lambda *_: False, initial_timestamp=TIME, link_id=link)


def request(station: Station) -> bytes:
    """A frame that has an answer."""
    mav = station.link.mav
    message = mav.command_long_encode(1, 1, mavlink.MAV_CMD_REQUEST_MESSAGE, 0, VERSION, *[0] * 6)
    return bytes(message.pack(mav))


def is_answered(station: Station, frame: bytes) -> bool:
    station.link.write(frame)
    answer = station.link.recv_match(type=["COMMAND_ACK"], blocking=True, timeout=WAITS_S)
    return answer is not None


def offer(station: Station, key: bytes, time: int = TIME) -> str:
    """What people read of it."""
    station.link.mav.setup_signing_send(1, 1, key, time)
    return str(station.wait("STATUSTEXT", lambda t: t.text.startswith("signing")).text)


def test_a_key_comes_by_the_trusted_line_and_is_in_no_log(tmp_path: Path) -> None:
    log = tmp_path / "signed.ulg"
    with (
        Lockstep() as clock,
        closing(Station(clock=clock)) as ground,
        closing(Station(system=251, clock=clock)) as companion,
        flying(log, "--mavlink", ground.line, "--mavlink", companion.line, clock=clock) as facts,
    ):
        ground.connect()
        companion.connect()
        assert offer(ground, KEY) == "signing: not allowed on this line"
        assert is_answered(ground, request(ground))
        assert offer(companion, KEY) == "signing: on, with a new key"
        clock.sleep(0.5)

        use(ground, KEY, 1, signs=False)
        use(companion, KEY, 2)
        assert not is_answered(ground, request(ground)), "no signature"
        ground.link.mav.signing.sign_outgoing = True
        frame = request(ground)
        assert is_answered(ground, frame)
        assert not is_answered(ground, frame), "replayed"
        assert not is_answered(companion, frame), "replayed on the other line"
        damaged = bytearray(request(ground))
        damaged[-1] ^= 1
        assert not is_answered(ground, bytes(damaged))
        ground.link.mav.signing.secret_key = OTHER_KEY
        wrong = request(ground)
        ground.link.mav.signing.secret_key = KEY
        assert not is_answered(ground, wrong), "another key"
        assert is_answered(ground, request(ground))

        ground.wait_until_armable()
        ground.take_off()
        assert offer(companion, OTHER_KEY) == "signing: refused while armed"
        ground.accept(mavlink.MAV_CMD_NAV_LAND)
        ground.wait_armed(False)
        assert ground.link.mav.signing.goodsig_count > 50
        assert ground.link.mav.signing.badsig_count == 0
    assert facts["success"], facts["reason"]
    logged = log.read_bytes()
    for at in range(len(KEY) - 8):
        assert KEY[at : at + 8] not in logged, "a key in the log"
    assert hashlib.sha256(KEY).digest()[:8] in logged
    replayed = subprocess.run(
        [*COMMAND, "replay", str(log)], capture_output=True, text=True, check=False
    )
    assert replayed.returncode == 0, replayed.stdout + replayed.stderr


def test_a_key_from_a_file_counts_from_the_start(tmp_path: Path) -> None:
    for text, key in ((PHRASE, KEY), (OTHER_KEY.hex(), OTHER_KEY)):
        file = tmp_path / "key.txt"
        file.write_text(text + "\n")
        with (
            Lockstep() as clock,
            closing(Station(clock=clock)) as ground,
            flying(
                tmp_path / "given.ulg",
                *("--mavlink", ground.line, "--signing-key", str(file), "--no-record"),
                clock=clock,
            ),
        ):
            ground.connect()
            assert not is_answered(ground, request(ground))
            use(ground, key, 1)
            ground.link.mav.signing.timestamp = 1
            assert is_answered(ground, request(ground))


def test_a_file_without_a_key_is_an_error(tmp_path: Path) -> None:
    file = tmp_path / "key.txt"
    file.write_text("\n")
    fly = [*COMMAND, "fly", str(OUTDOOR), "--signing-key", str(file)]
    alone = subprocess.run(fly, capture_output=True, text=True, check=False)
    assert alone.returncode == 2
    assert "error: --signing-key: missing --mavlink\n" in alone.stderr
    with closing(Station()) as ground:
        finished = subprocess.run(
            [*fly, "--mavlink", ground.line, "--no-record"],
            capture_output=True,
            text=True,
            check=False,
        )
    assert finished.returncode == 2
    assert "expected 64 hexadecimal digits, or a phrase" in finished.stderr
