"""What the links between machines carried in a flight, as its log has it."""

from __future__ import annotations

from typing import TYPE_CHECKING

from stator.flight.arguments import plan_of
from stator.flight.log import UnreadableFlight, open_log, topic

if TYPE_CHECKING:
    import argparse
    from pathlib import Path

    import numpy as np
    from numpy.typing import NDArray

COUNTS = ("received", "lost", "damaged", "repeated", "too_old", "refused", "sent", "replaced")


def link_facts(arguments: argparse.Namespace, log: Path) -> dict[str, object]:
    """Of each end of a link, and of each selector. Nothing for a graph of one machine."""
    plan = plan_of(arguments)
    if not plan.graph.wires:
        return {}
    try:
        data = open_log(log)
    except UnreadableFlight:
        return {"links": [], "standbys": []}
    links: list[dict[str, object]] = []
    standbys: list[dict[str, object]] = []
    for node in plan.graph.nodes.values():
        bridge = node.interface.bridge
        for port, output in node.outputs.items():
            if bridge is None or port not in ("link_status", "selection"):
                continue
            try:
                samples = topic(data, output.topic)
            except UnreadableFlight:
                continue
            if port == "link_status":
                counts = {key: int(samples[key][-1]) for key in COUNTS}
                age = {"oldest_us": int(samples["oldest_us"].max())}
                links.append({"end": bridge.link, **counts, **age})
            else:
                standbys.append({"node": bridge.link, **_turns(samples)})
    return {"links": links, "standbys": standbys}


def _turns(samples: dict[str, NDArray[np.generic]]) -> dict[str, object]:
    """When the node on the other machine acted, and how often the standby took over."""
    times = [float(time) * 1e-6 for time in samples["timestamp"]]
    acts = [bool(value) for value in samples["is_remote"]]
    changes = [(times[i], acts[i]) for i in range(len(acts)) if i == 0 or acts[i] != acts[i - 1]]
    fallbacks = [time for (time, is_remote) in changes[1:] if not is_remote]
    return {"fallbacks": int(samples["fallbacks"][-1]), "fallback_s": fallbacks}


def link_rows(facts: dict[str, object]) -> list[tuple[str, str]]:
    rows = []
    links, standbys = facts.get("links"), facts.get("standbys")
    for link in links if isinstance(links, list) else []:
        here, _, there = link["end"].partition("_")
        bad = ", ".join(
            f"{link[key]:,} {key.replace('_', ' ')}"
            for key in ("lost", "damaged", "repeated", "too_old", "refused")
            if link[key]
        )
        text = f"{here} from {there}: {link['received']:,} samples, {bad or 'none lost'}; "
        rows.append(("link", f"{text}the oldest {link['oldest_us'] / 1000:.1f} ms old"))
    for standby in standbys if isinstance(standbys, list) else []:
        times = ", ".join(f"{time:.3f} s" for time in standby["fallback_s"])
        if times:
            rows.append(("standby", f"of {standby['node']} took over at {times}"))
    return rows
