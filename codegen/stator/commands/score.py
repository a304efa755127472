"""`./stator score`: the error of an estimator on recorded sensor data with known truth."""

from __future__ import annotations

import argparse
import json
import subprocess
from pathlib import Path

from stator.diagnostics import UserError
from stator.score import navigation
from stator.score.attitude import PLANES, SUFFIX, Score, mean_of, score


def show(scores: list[Score], mean: Score, peers: dict[str, list[Score]]) -> None:
    peer_means = sorted(
        (mean_of(f"{name} ({len(rows)} of {len(scores)})", rows) for name, rows in peers.items()),
        key=lambda score: score.total_deg,
    )
    width = max(len(score.name) for score in [*scores, mean, *peer_means])

    def line(score: Score) -> str:
        return (
            f"{score.name:<{width}}  {score.total_deg:8.2f}  {score.heading_deg:8.2f}"
            f"  {score.inclination_deg:11.2f}"
        )

    print("RMSE in degrees while moving")
    print(f"{'':<{width}}  {'total':>8}  {'heading':>8}  {'inclination':>11}")
    print("\n".join(line(score) for score in [*scores, mean]))
    if peer_means:
        print("\nOther filters, mean over the same recordings")
        print("\n".join(line(score) for score in peer_means))


def as_json(scores: list[Score], mean: Score, peers: dict[str, list[Score]]) -> str:
    def row(score: Score) -> dict[str, str | float]:
        return {"name": score.name, **score.figures()}

    return json.dumps(
        {
            "recordings": [row(score) for score in scores],
            "mean": mean.figures(),
            "peers": {
                name: {
                    "recordings": [row(score) for score in rows],
                    "mean": mean_of(name, rows).figures(),
                }
                for name, rows in peers.items()
            },
        },
        indent=2,
    )


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.formatter_class = argparse.RawDescriptionHelpFormatter
    parser.epilog = f"""\
attitude: a recording is NAME{SUFFIX}, a gzip file of float32, little-endian, {PLANES} planes of N
values at 285.714 Hz: gyro xyz [rad/s], accelerometer xyz [m/s^2], magnetometer xyz [uT], true
attitude wxyz (sensor to east-north-up, NaN where unknown), moving (0 or 1).

{navigation.EPILOG}"""
    parser.add_argument("estimator", choices=["attitude", "navigation"], help="the estimator")
    parser.add_argument(
        "folder",
        type=Path,
        metavar="DIR",
        help="folder of recordings; results of other software in it are scored as well",
    )
    parser.add_argument("--json", action="store_true", help="print the result as JSON")


def main(arguments: argparse.Namespace) -> int:
    try:
        if arguments.estimator == "navigation":
            navigation.main(arguments.folder, as_json=arguments.json)
            return 0
        scores, peers = score(arguments.folder)
    except subprocess.CalledProcessError as problem:
        raise UserError(
            f"error: the playback program ended with status {problem.returncode}\n"
            "hint: see its message above"
        ) from None
    mean = mean_of("mean", scores)
    if arguments.json:
        print(as_json(scores, mean, peers))
    else:
        show(scores, mean, peers)
    return 0
