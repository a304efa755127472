"""Frames of the link: what goes in comes out, and damage never gets through."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from stator.live.link import frame, unframe


@pytest.mark.parametrize(
    "body",
    [
        b"",
        b"\0",
        b"\0\0\0",
        b"\1" * 249,
        b"\1" * 250,
        b"\1" * 251,
        b"\1" * 600,
        b"\1" * 254 + b"\0",
    ],
)
def test_a_body_comes_through(body: bytes) -> None:
    coded = frame(body)
    assert coded.count(b"\0") == 1
    assert unframe(coded[:-1]) == body


@given(st.binary(max_size=700))
def test_every_body_comes_through(body: bytes) -> None:
    assert unframe(frame(body)[:-1]) == body


@given(st.binary(max_size=100))
def test_garbage_is_no_frame(garbage: bytes) -> None:
    for part in garbage.split(b"\0"):
        body = unframe(part)
        assert body is None or frame(body)[:-1] == part


@given(st.binary(min_size=1, max_size=60), st.data())
def test_a_damaged_frame_is_no_frame(body: bytes, data: st.DataObject) -> None:
    coded = bytearray(frame(body)[:-1])
    at = data.draw(st.integers(0, len(coded) - 1))
    coded[at] ^= data.draw(st.integers(1, 255))
    assert all(unframe(part) is None for part in bytes(coded).split(b"\0"))


def test_the_bytes_that_the_firmware_makes() -> None:
    """As tests/runtime/link/link_test.cpp has them. CRC-32 of "123456789": 0xCBF43926."""
    assert frame(b"123456789").hex() == "0e3132333435363738392639f4cb00"
