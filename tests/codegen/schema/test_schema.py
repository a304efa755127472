"""The published JSON Schema agrees with the checker: good files fit it, misshapen ones do not.

Files are read here as editors read them, by YAML's own rules for types.
"""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import jsonschema
import pytest
import yaml

from stator.__main__ import main
from stator.schema.json_schema import KINDS, schema

ROOT = Path(__file__).resolve().parents[3]
BAD = ROOT / "tests" / "codegen" / "language" / "bad"

GRAPHS = [*ROOT.glob("graph/*.yaml"), *ROOT.glob("graph/examples/*.yaml")]
FILES = {
    "graph": [*GRAPHS, *ROOT.glob("graph/examples/parts/*.yaml"), *BAD.glob("parts/filter.yaml")],
    "message": [*ROOT.glob("graph/messages/*.yaml"), *ROOT.glob("graph/examples/messages/*.yaml")],
    "interface": [
        *(path for path in ROOT.glob("apps/*/*.yaml") if path.stem == path.parent.name),
        *ROOT.glob("graph/examples/apps/*/*.yaml"),
        *ROOT.glob("drivers/*/*.yaml"),
    ],
    "board": [*ROOT.glob("boards/*/board.yaml"), *ROOT.glob("graph/examples/boards/*/board.yaml")],
    "chip": [path for path in ROOT.glob("boards/*/*.yaml") if path.name != "board.yaml"],
    "failsafe": [*ROOT.glob("apps/*/failsafe.yaml")],
    "mission": [*ROOT.glob("graph/missions/*.yaml")],
    "vehicle": [*ROOT.glob("graph/vehicles/*.yaml")],
    "budgets": [*ROOT.glob("graph/budgets/*.yaml"), *ROOT.glob("graph/examples/budgets/*.yaml")],
}

# Bad graphs whose mistake a schema can see: what a file is made of, not what it means.
STRUCTURAL = [
    "unknown_key", "unknown_key_at_top", "unknown_key_instead_of_required", "missing_trigger",
    "missing_nodes", "missing_topic_of_input", "shape_list_for_mapping", "shape_text_for_mapping",
    "shape_mapping_for_text", "shape_text_for_list", "shape_nothing_for_mapping",
    "shape_nothing_for_text", "shape_whole_graph", "type_choice", "type_whole_number",
    "range_priority", "range_priority_below", "range_chain_of_one", "range_triggers_none",
    "bad_name_node", "bad_name_topic", "bad_name_unicode", "bad_name_long", "unit_missing",
    "unit_unknown", "type_time", "depth_range", "include_absolute", "include_prefix",
    "variable_at_top", "several_errors",
]  # fmt: skip


def load(path: Path) -> Any:
    return yaml.safe_load(path.read_text(encoding="utf-8"))


def cases() -> list[Any]:
    return [
        pytest.param(kind, path, id=str(path.relative_to(ROOT)))
        for kind, paths in FILES.items()
        for path in sorted(paths)
    ]


@pytest.mark.parametrize("kind", KINDS)
def test_is_a_schema(kind: str) -> None:
    jsonschema.Draft202012Validator.check_schema(schema(kind))


@pytest.mark.parametrize(("kind", "path"), cases())
def test_good_files_fit(kind: str, path: Path) -> None:
    jsonschema.validate(load(path), schema(kind), cls=jsonschema.Draft202012Validator)


@pytest.mark.parametrize("name", STRUCTURAL)
def test_misshapen_graphs_do_not(name: str) -> None:
    with pytest.raises(jsonschema.ValidationError):
        jsonschema.validate(
            load(BAD / f"{name}.yaml"), schema("graph"), cls=jsonschema.Draft202012Validator
        )


def test_each_key_has_its_words() -> None:
    """What an editor shows beside a key."""
    node = schema("graph")["then"]["properties"]["nodes"]["patternProperties"]
    (only,) = node.values()
    assert only["properties"]["trigger"]["description"]
    assert all(value["description"] for value in only["properties"].values())


def test_is_published(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["schema"]) == 0
    assert json.loads(capsys.readouterr().out) == schema("graph")


def test_a_folder_of_schemas_and_the_setting_of_an_editor(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    assert main(["schema", "--folder", ".schema"]) == 0
    setting = json.loads(capsys.readouterr().out)["yaml.schemas"]
    for file in setting:
        title = json.loads((tmp_path / file).read_text())["title"]
        assert title == f"Stator {Path(file).stem}"
    assert setting["./.schema/mission.json"] == ["missions/*.yaml"]
    assert main(["schema", "mission"]) == 0
    assert json.loads(capsys.readouterr().out)["title"] == "Stator mission"
