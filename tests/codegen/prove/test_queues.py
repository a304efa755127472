"""How many samples can be unread at once."""

from __future__ import annotations

from pathlib import Path

from tests.codegen.prove.graphs import proved


def needed(folder: Path, text: str) -> dict[str, int | None]:
    return {queue.topic: queue.needed for queue in proved(folder, text).queues}


def test_a_trigger_needs_what_comes_within_its_response(tmp_path: Path) -> None:
    assert needed(
        tmp_path,
        """
        nodes:
          sensor0: {device: sensor0, trigger: {irq: ready, min_interarrival: 1 ms}, priority: 9,
            budget: 10 us, outputs: {sample: s}}
          hog: {app: stage, trigger: {every: 10 ms}, priority: 8, budget: 2500 us}
          last: {app: stage, trigger: {topic: s}, priority: 2, budget: 10 us, inputs: {a: s}}
        """,
    ) == {"s": 3}


def test_a_burst_waits_where_the_reader_is_less_urgent(tmp_path: Path) -> None:
    text = """
        nodes:
          source: {{app: stage, trigger: {{every: 10 ms}}, priority: {0}, budget: 10 us,
            outputs: {{three: s}}}}
          sink: {{app: stage, trigger: {{topic: s}}, priority: {1}, budget: 10 us,
            inputs: {{a: s}}}}
        """
    assert needed(tmp_path, text.format(2, 1)) == {"s": 3}
    assert needed(tmp_path, text.format(1, 1)) == {"s": 3}
    # A more urgent reader runs inside each publication.
    assert needed(tmp_path, text.format(1, 2)) == {"s": 1}


def test_a_queue_needs_what_comes_between_two_looks(tmp_path: Path) -> None:
    proof = proved(
        tmp_path,
        """
        topics: {s: {depth: 8}}
        nodes:
          source: {app: stage, trigger: {every: 1 ms}, priority: 9, budget: 10 us,
            outputs: {out: s}}
          other: {app: stage, trigger: {every: 4 ms}, priority: 8, budget: 3500 us}
          sink: {app: stage, trigger: {every: 4 ms}, priority: 1, budget: 300 us,
            inputs: {a: {topic: s, read: queue}}}
        """,
    )
    (queue,) = proof.queues
    # One period of 4 ms, and a response just below 4 ms.
    assert (queue.reader, queue.depth, queue.needed, queue.lost) == ("sink", 8, 8, 0)


def test_what_a_small_depth_can_lose(tmp_path: Path) -> None:
    proof = proved(
        tmp_path,
        """
        nodes:
          sensor0: {device: sensor0, trigger: {irq: ready, min_interarrival: 1 ms}, priority: 9,
            budget: 10 us, outputs: {sample: s}}
          hog: {app: stage, trigger: {every: 10 ms}, priority: 8, budget: 2500 us}
          last: {app: stage, trigger: {topic: s}, priority: 2, budget: 10 us, inputs: {a: s}}
        """,
    )
    assert [queue.lost for queue in proof.queues] == [2]
