"""What Python reads from C++ instead of repeating it."""

import struct

import pytest

from stator.build.cpp_source import constant, layout
from stator.flight.log import DISARMED, FAILSAFE_EVENTS, NAV_STATES
from stator.live.fault_record import decode

RECORD = "runtime/cortex_m/stator/fault_record.hpp"


def test_the_fields_of_a_fault_record_lie_where_the_header_puts_them() -> None:
    """Offsets counted by hand from the header: nine words, then the arrays."""
    found = layout(RECORD, "FaultRecord")
    assert found.packed.size == 360  # the header's static_assert
    data = bytearray(360)
    struct.pack_into("<I", data, 4 * (9 + 6), 0x0800_1234)  # the frame's program counter
    struct.pack_into("<I", data, 4 * (9 + 8 + 8 + 4 + 1), 3)  # 1 + the silent task
    data[360 - 20 :] = bytes(range(20))
    record = decode(bytes(data))
    assert record.program_counter == 0x0800_1234
    assert record.silent_task == 2
    assert record.build_id == bytes(range(20)).hex()


def test_a_record_of_another_length_is_refused() -> None:
    with pytest.raises(ValueError, match="360 bytes"):
        decode(bytes(359))


def test_constants() -> None:
    assert constant("boards/linux/main.cpp", "kRestart") == 3
    assert constant("apps/navigator/item.hpp", "kShortestEight") == 2.0
    with pytest.raises(AssertionError, match="has no number kNothing"):
        constant(RECORD, "kNothing")


def test_modes_and_events_are_those_of_the_message() -> None:
    """PX4's numbers, and two words of our own."""
    assert NAV_STATES[0] == "manual"
    assert (NAV_STATES[17], NAV_STATES[18]) == ("take-off", "landing")
    assert FAILSAFE_EVENTS[7] == "rc_lost"
    assert 0 not in FAILSAFE_EVENTS
    assert DISARMED == 1
