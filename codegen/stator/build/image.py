"""The image of a graph: build, check, file formats."""

from __future__ import annotations

import subprocess
from pathlib import Path
from typing import TYPE_CHECKING

from stator.build.cmake import RECORDING, build
from stator.build.px4_file import write_px4
from stator.diagnostics import BuildFailed, UserError, shown_path
from stator.emit.recording import check_recording_rate, is_recordable
from stator.image.checks import faults_of
from stator.image.handlers import stack_of_graph
from stator.image.tools import TOOLS
from stator.pipeline import make_buildable_plan
from stator.plan.hash import graph_hash
from stator.processes import environment

if TYPE_CHECKING:
    import argparse
    from collections.abc import Mapping

    from stator.plan.plan import Plan


def add_record_argument(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--record",
        action="store_true",
        help="the image writes a recording for ./stator replay into its log (docs/recording.md)",
    )


def recording_of(plan: Plan) -> dict[str, str]:
    """The CMake variables of an image that records. Raises `UserError` if it has no logger, or one
    that is too slow."""
    if not is_recordable(plan):
        raise UserError(
            f"error: --record: missing node of app 'logger' in {shown_path(plan.graph.file)}\n"
            "hint: omit --record"
        )
    check_recording_rate(plan)
    return RECORDING


def build_image(graph: Path, board: str | None, variant: Mapping[str, str] | None = None) -> Path:
    """Builds the image for bare metal. Raises `BuildFailed` if it breaks a rule of images."""
    image = build(graph, board, variant, executor="cortex_m")
    plan = make_buildable_plan(str(graph), board)
    stack = stack_of_graph(plan, image)
    faults = [*faults_of(image, plan.graph.nodes), *stack.faults, *stack.overflows()]
    if faults:
        raise BuildFailed("\n".join(faults))
    return image


def image_files(plan: Plan, image: Path, *, is_proven: bool = True) -> dict[str, Path]:
    """The image in all file formats; .px4, for ground stations, only if the board has an id."""
    files = {
        "elf": image,
        "bin": flashed_file(image),
        "hex": _convert(image, "ihex", ".hex"),
    }
    if plan.board.upload is not None:
        files["px4"] = image.with_name(f"{plan.graph.name}.px4")
        write_px4(
            plan, files["bin"].read_bytes(), files["px4"], graph_hash(plan), is_proven=is_proven
        )
    return files


def flashed_file(image: Path) -> Path:
    """The bytes of the image, as they lie in the flash."""
    return _convert(image, "binary", ".bin")


def _convert(image: Path, kind: str, suffix: str) -> Path:
    result = image.with_suffix(suffix)
    command = [TOOLS + "objcopy", "-O", kind, str(image), str(result)]
    subprocess.run(command, env=environment(), check=True)
    return result
