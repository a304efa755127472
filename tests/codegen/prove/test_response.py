"""Laws of response times, on random sets; the one of a single level each is written down a second
time here, as the papers have it."""

from __future__ import annotations

import random
from dataclasses import replace

from stator.prove.response import Job, Processor, responses
from stator.prove.streams import Stream

SEEDS = range(150)


def random_jobs(seed: int, levels: int = 0) -> list[Job]:
    """`levels`: how many; 0: one for each job."""
    dice = random.Random(seed)
    count = dice.randint(2, 6)
    ranks = sorted((dice.randint(1, max(levels, 1)) for _ in range(count)), reverse=True)
    jobs = []
    for i in range(count):
        period = dice.randint(10, 300)
        cost = max(1, int(period * dice.uniform(0.02, 0.9 / count)))
        stream = Stream(period, dice.choice((0, 0, dice.randint(0, 2 * period))))
        level = ranks[i] if levels else count - i
        jobs.append(Job(str(i), level, cost, (stream,), dice.choice((0, 0, dice.randint(1, 20)))))
    return jobs


def preemptive(jobs: list[Job], i: int) -> int:
    """Tindell, Burns and Wellings 1994, with arbitrary deadlines."""
    job, stream = jobs[i], jobs[i].streams[0]
    worst = q = 0
    while True:
        q += 1
        window = before = 0
        while window != before or not window:
            before = window
            others = (
                -(-(window + s.jitter) // s.period) * j.cost for j in jobs[:i] for s in j.streams
            )
            window = job.section + q * job.cost + sum(others)
        worst = max(worst, window - (q - 1) * stream.period + stream.jitter)
        if window <= q * stream.period - stream.jitter:
            return worst


def test_one_job_in_each_level_is_the_preemptive_case() -> None:
    for seed in SEEDS:
        jobs = random_jobs(seed)
        for i, found in enumerate(responses(jobs)):
            assert found is not None
            assert found.from_source == preemptive(jobs, i), jobs


def more_of(job: Job) -> list[Job]:
    stream = job.streams[0]
    return [
        replace(job, cost=job.cost + 1),
        replace(job, section=job.section + 5),
        replace(job, streams=(replace(stream, jitter=stream.jitter + 7),)),
        replace(job, streams=(replace(stream, count=2),)),
        replace(job, streams=(stream, Stream(1000))),
    ]


def test_more_of_anything_never_shortens_a_response() -> None:
    for seed in SEEDS:
        jobs = random_jobs(seed, levels=2)
        known = responses(jobs)
        i = seed % len(jobs)
        for worse in more_of(jobs[i]):
            changed = [*jobs[:i], worse, *jobs[i + 1 :]]
            for before, after in zip(known, responses(changed), strict=True):
                assert before is not None
                assert after is None or after.from_arrival >= before.from_arrival, (jobs, worse)


def test_two_that_keep_apart_take_less_than_two_that_meet() -> None:
    low = Job("low", 1, 30, (Stream(1000),))
    apart = [Job("high", 2, 10, (Stream(100, 95, distance=60),)), low]
    meeting = [Job("high", 2, 10, (Stream(100, 95),)), low]
    ends = [found.from_arrival for found in (responses(apart)[1], responses(meeting)[1]) if found]
    assert ends == [40, 50]


def test_shares_add_up_to_the_response() -> None:
    jobs = [
        Job("high", 3, 3, (Stream(7),)),
        Job("first", 2, 3, (Stream(40),)),
        Job("second", 2, 5, (Stream(60),)),
        Job("third", 2, 2, (Stream(90),)),
    ]
    processor = Processor(jobs)
    second = processor.response(2)
    assert second is not None
    parts = {share.name: share.cost for share in processor.shares(2, second)}
    # It waits for third, which has just begun, and for first; high comes three times.
    assert parts == {"second": 5, "third": 2, "first": 3, "high": 9}
    assert sum(parts.values()) == second.from_arrival
