"""The documents as a whole: links, length of lines, words to avoid, and what has to be listed."""

from __future__ import annotations

import re
from itertools import chain
from pathlib import Path

import pytest

from stator import HOME

FOLDERS = ("apps", "boards", "codegen", "docs", "drivers", "graph", "runtime", "tests")
ROOT = tuple(HOME / name for name in ("README.md", "CHANGELOG.md", "CONTRIBUTING.md"))
ROOMS = sorted(path.parent for path in (HOME / "codegen" / "stator").glob("*/__init__.py"))
DECISIONS = HOME / "docs" / "decisions"
DOCUMENTS = [
    path
    for path in sorted(chain(ROOT, *((HOME / folder).rglob("*.md") for folder in FOLDERS)))
    if "build" not in path.relative_to(HOME).parts
]
COLUMNS = 100
# Words that hide the subject or that readers do not know; documents use plain ones.
AVOIDED = re.compile(
    r"\b(anew|whoever|somebody|nobody|as a rule|what is told|(?:is|are) no [a-z]+ of"
    r"|round for ever|stands? here|but for|outlives?)\b",
    re.IGNORECASE,
)
PATH = re.compile(rf"`((?:{'|'.join(FOLDERS)})/[\w./*-]+)`")
PLACEHOLDER = re.compile(r"[A-Z]{3,}")  # boards/NAME
LINK = re.compile(r"\]\(([^)#:\s]*)(#[^)\s]+)?\)")


def name_of(path: Path) -> str:
    return str(path.relative_to(HOME))


def prose(path: Path) -> list[tuple[int, str]]:
    """Lines with their numbers, without code."""
    lines, is_code = [], False
    for number, line in enumerate(path.read_text(encoding="utf-8").splitlines(), 1):
        if line.startswith("```"):
            is_code = not is_code
        elif not is_code and not line.startswith("    "):
            lines.append((number, line))
    return lines


def anchors(path: Path) -> set[str]:
    """Of its headings, as forges make them."""
    heads = [line.lstrip("#").strip() for _, line in prose(path) if line.startswith("#")]
    return {"#" + re.sub(r"[^\w\- ]", "", head.lower()).replace(" ", "-") for head in heads}


def test_every_document_is_looked_at() -> None:
    assert {"README.md", "docs/guide.md", "docs/decisions/README.md"} <= set(
        map(name_of, DOCUMENTS)
    )


@pytest.mark.parametrize("path", DOCUMENTS, ids=name_of)
def test_links_lead_somewhere(path: Path) -> None:
    for target, anchor in LINK.findall(path.read_text(encoding="utf-8")):
        file = (path.parent / target).resolve() if target else path
        assert file.exists(), target
        if anchor:
            assert anchor in anchors(file), f"{target}{anchor}"


@pytest.mark.parametrize("path", DOCUMENTS, ids=name_of)
def test_files_that_are_named_exist(path: Path) -> None:
    named = set(PATH.findall(path.read_text(encoding="utf-8")))
    missing = {n for n in named if not PLACEHOLDER.search(n) and not list(HOME.glob(n))}
    assert not missing


@pytest.mark.parametrize("path", DOCUMENTS, ids=name_of)
def test_prose_fits_100_columns(path: Path) -> None:
    long = [n for n, line in prose(path) if len(line) > COLUMNS and not line.startswith("|")]
    assert not long, f"lines {long}"


@pytest.mark.parametrize("path", DOCUMENTS, ids=name_of)
def test_words_are_plain(path: Path) -> None:
    found = [(n, match.group()) for n, line in prose(path) for match in AVOIDED.finditer(line)]
    assert not found


@pytest.mark.parametrize("folder", FOLDERS)
def test_each_folder_says_what_lives_there(folder: str) -> None:
    lines = (HOME / folder / "README.md").read_text(encoding="utf-8").splitlines()
    assert lines[0].startswith("# ")
    assert 3 <= len([line for line in lines[1:] if line]) <= 9


def test_the_index_has_every_decision_by_number_and_title() -> None:
    rows = re.findall(
        r"^\| \[(\d{4})\]\(([^)]+)\) \| ([^|]+) \| [^|]+ \| (accepted|replaced by \d{4}) \|$",
        (DECISIONS / "README.md").read_text(encoding="utf-8"),
        re.MULTILINE,
    )
    files = sorted(DECISIONS.glob("[0-9]*.md"))
    titles = [file.read_text(encoding="utf-8").splitlines()[0].lstrip("# ") for file in files]
    assert [(row[0], row[1], row[2]) for row in rows] == [
        (file.name[:4], file.name, title) for file, title in zip(files, titles, strict=True)
    ]


@pytest.mark.parametrize("room", ROOMS, ids=name_of)
def test_each_room_of_the_compiler_says_what_lives_there(room: Path) -> None:
    assert (room / "README.md").is_file()
