"""Names that a graph cannot use: C++, the C library or the runtime uses them already."""

# ruff: noqa: SIM905 - a list of words reads best as text
from __future__ import annotations

from stator.macros import MACROS

_CPP_KEYWORDS = frozenset(
    """alignas alignof and and_eq asm auto bitand bitor bool break case catch char char8_t char16_t
    char32_t class compl concept const consteval constexpr constinit const_cast continue co_await
    co_return co_yield decltype default delete do double dynamic_cast else enum explicit export
    extern false float for friend goto if inline int long mutable namespace new noexcept not not_eq
    nullptr operator or or_eq private protected public register reinterpret_cast requires return
    short signed sizeof static static_assert static_cast struct switch template this thread_local
    throw true try typedef typeid typename union unsigned using virtual void volatile wchar_t while
    xor xor_eq final override import module typeof""".split()
)
_RUNTIME = frozenset("std stator now fired params timestamp main step".split())
# Namespaces and functions that generated code names without qualification beside nodes and topics,
# its own header files, and CMake targets.
_GENERATED = frozenset(
    """tasks topics lines board boards modes apps drivers math dronecan testing messages executor
    log_table parameter_table metadata streams replay interfaces generated all_slots served_now
    later nominal_time_us set_pending clear_pending has_unread count_activation lost_samples preempt
    take_latest release count_refused add_to_counter""".split()
)
_SEEN_BY_DRIVERS = frozenset("math dronecan world".split())  # its own namespace would hide them
_BESIDE_DEVICES = frozenset("world samples sensors give hand_over".split())  # in namespace board
_CLASSES = ("a node", "an app", "a device class")  # most nodes have the name of their app
_IN_GENERATED = ("a node", "an app", "a topic", "a device", "a device class")

# Types in namespace stator, which messages and app classes cannot be called.
_TYPES = frozenset(
    """Shared Topic TopicState Thinned ThinnedState Pin Loan Input Output Pend Section Executor
    Timer TimerState Line LineState Task TaskCounters Program RandomTimes Random LogTable LogTopic
    Params Ports Fired Device SharedTime Interrupt Register Level LevelFacts Lock Mutex
    Ending PendingWord Refusal RingEntry Settings SlotState Activation ActivationRing FaultRecord
    FrameReader Kept KeptRecord Link LogEvent LogEvents ModeGate TickSource Transport WatchState
    Watched ParameterPort ParameterRow ParameterRows ParameterTable ParameterTopic
    ParameterType Metadata MetadataFile RefusedPublications""".split()
)


def reserved_reason(name: str, what: str = "") -> str:
    """Why the name is reserved; empty if it is free."""
    if what == "a board":
        return ""  # never a name in C++
    if name in _CPP_KEYWORDS:
        return "it is a C++ keyword"
    if name in MACROS or upper_camel(name) in MACROS:  # a class, or the type of a field
        return "the C library uses this name"
    if name.endswith("_t"):
        return "names that end in _t are reserved for the C library"
    if (what in _IN_GENERATED and name in _GENERATED) or _is_variable(name, what):
        return "generated code uses this name"
    if what == "a device" and name in _BESIDE_DEVICES:
        return "generated code uses this name"
    if what in ("a driver", "a device class") and name in _SEEN_BY_DRIVERS:
        return "the runtime uses this name"
    if name in _RUNTIME or (what in _CLASSES and upper_camel(name) in _TYPES):
        return "the runtime uses this name"
    if "__" in name or name.endswith("_"):
        return "it must not contain __ or end in _"
    return ""


def _is_variable(name: str, what: str) -> bool:
    """Whether a task or its ports have a variable of this name."""
    if what == "a line":
        return name == "timers"
    return what == "an input" and name.startswith("every_") and name[6:].isdigit()


def reserved_type_reason(name: str) -> str:
    """Why a message or a class cannot have this name; empty if it can."""
    if name in MACROS:
        return "the C library uses this name"
    return "the runtime uses this name" if name in _TYPES else ""


def upper_camel(name: str) -> str:
    """rate_control -> RateControl"""
    return "".join(part[:1].upper() + part[1:] for part in name.split("_"))


def snake(name: str) -> str:
    """SensorGyro -> sensor_gyro; a run of capitals is one word: GPSFix -> gps_fix"""
    text = ""
    for i, char in enumerate(name):
        before = name[i - 1] if i else ""
        after = name[i + 1] if i + 1 < len(name) else ""
        if char.isupper() and i and (not before.isupper() or after.islower()):
            text += "_"
        text += char.lower()
    return text
