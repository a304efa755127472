"""The language as JSON Schema, for editors: the same description that the checker uses."""

from __future__ import annotations

from typing import Any

from stator import language


def graph_schema() -> dict[str, Any]:
    return {
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "title": "Stator graph",
        **language.GRAPH.schema(),
    }
