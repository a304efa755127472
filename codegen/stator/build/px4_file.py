"""The .px4 file that ground stations upload: JSON with the image and the board's id."""

from __future__ import annotations

import base64
import json
import zlib
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from pathlib import Path

    from stator.plan.plan import Plan

WORD = 4


def padded(image: bytes) -> bytes:
    """The image in whole words, which the bootloader needs; erased flash reads as ones."""
    return image + b"\xff" * (-len(image) % WORD)


def write_px4(plan: Plan, image: bytes, file: Path, graph_hash: str, *, is_proven: bool) -> None:
    """Writes no time and no place of the build: the same graph gives the same bytes."""
    assert plan.board.upload is not None
    assert plan.board.chip is not None
    image = padded(image)
    fields = {
        "magic": "PX4FWv1",
        "board_id": plan.board.upload.board_id,
        "board_revision": 0,
        "summary": plan.board.name,
        "description": f"Stator, graph {plan.graph.name}{'' if is_proven else ', NOT PROVEN'}",
        "version": graph_hash[:12],
        "git_identity": graph_hash,
        "build_time": 0,
        "image_size": len(image),
        "image_maxsize": plan.board.chip.memory["flash"].bytes,
        "image": base64.b64encode(zlib.compress(image, 9)).decode("ascii"),
    }
    file.write_text(json.dumps(fields, indent=4) + "\n", encoding="utf-8")


def image_in(file: Path) -> bytes:
    """The bytes that an upload of the file writes into the flash."""
    image = json.loads(file.read_text(encoding="utf-8"))["image"]
    return zlib.decompress(base64.b64decode(image))
