"""What every executor has to do with the graphs of this folder: written by hand from the rules of
triggers, topics and modes, each with its reason. The form of a line is in README.md."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Scenario:
    nodes: tuple[str, ...]  # the others of the graph belong to other scenarios
    trace: str


def _lines(*lines: str) -> str:
    return "\n".join(lines)


# Both peers are pending when `waker` ends: the plan decides, not who was woken first.
ORDER_IN_A_LEVEL = """\
0 waker 1
0 early 1 a=waker.2*
0 late 1 a=waker.1*
240 waker 2
240 early 2 a=waker.4*
240 late 2 a=waker.3*
"""

# `low` is interrupted by `high`; `middle`, woken by `high`, has to let it end, but does not wait
# for `low`; `peer` does. What `high` answered is there when `low` runs again.
NESTING = """\
0 +low 1
0 high 1 a=low.1*
0 middle 1 a=high.1*
0 -low
0 peer 1 a=low.1*
240 +low 2 c=high.1*
240 high 2 a=low.2*
240 middle 2 a=high.2*
240 -low
240 peer 2 a=low.2*
"""

# Six samples, a depth of four: the two oldest are lost, counted at the first that is left. A
# trigger takes one sample for each activation, a queue all that there are, once.
QUEUES = """\
0 flood 1
0 drain 1 a=flood.3*-2
0 drain 2 a=flood.4*
0 drain 3 a=flood.5*
0 drain 4 a=flood.6*
20 collector 1 b=flood.3,flood.4,flood.5,flood.6-2
140 collector 2
240 flood 2
240 drain 5 a=flood.9*-2
240 drain 6 a=flood.10*
240 drain 7 a=flood.11*
240 drain 8 a=flood.12*
260 collector 3 b=flood.9,flood.10,flood.11,flood.12-2
380 collector 4
"""

# `feed` publishes two samples at 20, 80, 140, ... ms: the newer one is new once, and one passed
# unread; before 20 ms there is none.
NEWEST = _lines(
    "0 newest 1 a=ticker.1*",
    *(
        f"{20 * tick} newest {tick + 1} a=ticker.{tick + 1}*"
        + f" c=feed.{2 * ((tick + 2) // 3)}{'*-1' if tick % 3 == 1 else ''}"
        for tick in range(1, 24)
    ),
)

# The same samples, which are 0, 20 and 40 ms old: the last is older than 30 ms.
AGE = _lines(
    *(
        f"{20 * tick} young {tick + 1} a=ticker.{tick + 1}*"
        + ("", f" c=feed.{2 * ((tick + 2) // 3)}*-1", f" c=feed.{2 * ((tick + 2) // 3)}")[tick % 3]
        for tick in range(24)
    ),
)

# 20 ms thinned to 50 ms: the first sample at or after each multiple of 50 ms, so that the mean rate
# stays; two or one pass between.
THINNING = """\
0 thin 1 a=ticker.1*
60 thin 2 a=ticker.4*-2
100 thin 3 a=ticker.6*-1
160 thin 4 a=ticker.9*-2
200 thin 5 a=ticker.11*-1
260 thin 6 a=ticker.14*-2
300 thin 7 a=ticker.16*-1
360 thin 8 a=ticker.19*-2
400 thin 9 a=ticker.21*-1
460 thin 10 a=ticker.24*-2
"""

# All readers see the samples of both publishers in one order. `between` interrupts `left`, and
# waits for `right`.
PUBLISHERS = _lines(
    *(
        f"""\
{120 * turn} +left {turn + 1}
{120 * turn} above {2 * turn + 1} a=left.{turn + 1}*
{120 * turn} between {2 * turn + 1} a=left.{turn + 1}*
{120 * turn} -left
{120 * turn + 40} +starter {turn + 1}
{120 * turn + 40} +right {turn + 1} a=starter.{turn + 1}*
{120 * turn + 40} above {2 * turn + 2} a=right.{turn + 1}*
{120 * turn + 40} -right
{120 * turn + 40} between {2 * turn + 2} a=right.{turn + 1}*
{120 * turn + 40} -starter"""
        for turn in range(4)
    )
)

# What fires while `finger0` runs, or at the same instant, is one activation that sees all of it:
# the line, the second timer of the list (t2; the first is t1), and the sample.
TRIGGERS = """\
40 finger0 1 t1
40 button0 1 pressed t2 a=finger0.1*
60 button0 2 t1
120 finger0 2 t1
120 button0 3 pressed a=finger0.2*
200 finger0 3 t1
200 button0 4 pressed t2 a=finger0.3*
280 finger0 4 t1
280 button0 5 pressed a=finger0.4*
300 button0 6 t1
360 finger0 5 t1
360 button0 7 pressed t2 a=finger0.5*
440 finger0 6 t1
440 button0 8 pressed a=finger0.6*
"""

# At 100 ms `doomed` wishes for mode two, is interrupted by the switch, and still publishes what
# `watcher` reads; `never` is pending then and does not run. `beta` begins with what comes after the
# switch, at its next multiple of 80 ms plus 60. At 260 ms the same the other way: `alpha` counts
# from 1 again and has lost nothing; `both`, in both modes, goes on. At 420 ms `doomed` and at 460
# ms `beta` are new ones.
MODES = """\
0 +beat 1
0 alpha 1 a=beat.1*
0 both 1 a=beat.1*
0 -beat
40 +beat 2
40 alpha 2 a=beat.2*
40 both 2 a=beat.2*
40 -beat
80 +beat 3
80 alpha 3 a=beat.3*
80 both 3 a=beat.3*
80 -beat
100 +doomed 1
100 pilot to 1
100 watcher 1 a=doomed.2*
100 -doomed
120 +beat 4
120 both 4 a=beat.4*
120 -beat
140 beta 1 b=beat.4
160 +beat 5
160 both 5 a=beat.5*
160 -beat
200 +beat 6
200 both 6 a=beat.6*
200 -beat
220 beta 2 b=beat.5,beat.6
240 +beat 7
240 both 7 a=beat.7*
240 -beat
260 +returner 1
260 pilot to 0
260 watcher 2 a=returner.2*
260 -returner
280 +beat 8
280 alpha 1 a=beat.8*
280 both 8 a=beat.8*
280 -beat
320 +beat 9
320 alpha 2 a=beat.9*
320 both 9 a=beat.9*
320 -beat
360 +beat 10
360 alpha 3 a=beat.10*
360 both 10 a=beat.10*
360 -beat
400 +beat 11
400 alpha 4 a=beat.11*
400 both 11 a=beat.11*
400 -beat
420 +doomed 1
420 pilot to 1
420 watcher 3 a=doomed.2*
420 -doomed
440 +beat 12
440 both 12 a=beat.12*
440 -beat
460 beta 1 b=beat.12
"""

SCENARIOS = {
    "order_in_a_level": Scenario(("waker", "early", "late"), ORDER_IN_A_LEVEL),
    "nesting": Scenario(("low", "peer", "high", "middle"), NESTING),
    "queues": Scenario(("flood", "drain", "collector"), QUEUES),
    "newest": Scenario(("newest",), NEWEST),
    "age": Scenario(("young",), AGE),
    "thinning": Scenario(("thin",), THINNING),
    "publishers": Scenario(("left", "starter", "right", "above", "between"), PUBLISHERS),
    "triggers": Scenario(("finger0", "button0"), TRIGGERS),
    "modes": Scenario(
        (
            *("beat", "pilot", "doomed", "returner", "watcher"),
            *("never", "alpha", "beta", "both"),
        ),
        MODES,
    ),
}
