"""Words that readers stumble over are not used: docs, help texts, messages and comments."""

from __future__ import annotations

import re
from bisect import bisect_right
from itertools import accumulate
from typing import TYPE_CHECKING

import pytest

from stator import HOME

if TYPE_CHECKING:
    from collections.abc import Iterator
    from pathlib import Path

# Files whose text is checked. To check another folder, add its pattern.
CHECKED = (
    "stator",
    "codegen/*.py",
    "codegen/cmake/*.cmake",
    "codegen/stator/**/*.py",
    "codegen/stator/**/README.md",
    "codegen/stator/commands/new_templates/*",
    "apps/**/*.yaml",
    "drivers/**/*.yaml",
    "graph/**/*.yaml",
)
# The word or phrase -> what to write instead.
BANNED = {
    r"\banew\b": "again",
    r"\bwhoever\b": "name the subject",
    r"\bsomebody\b": "name the subject",
    r"\bnobody\b[^.;]*\bbut\b": "only ...",
    r"(?<!there) is no (?!longer\b|more than\b)": "is not a ..., or expected ..., found ...",
    r"\bwhat is told of\b": "name the subject",
    r"\bthat will do\b": "that fits",
}


def files() -> Iterator[Path]:
    for pattern in CHECKED:
        found = [path for path in sorted(HOME.glob(pattern)) if path.is_file()]
        assert found, f"no file matches {pattern}"
        yield from found


def banned_in(text: str) -> list[tuple[int, str, str]]:
    """Line, the words found, what to write instead. A phrase may continue in the next line."""
    lines = [line.strip(" \t#/*") for line in text.splitlines()]
    ends = list(accumulate(len(line) + 1 for line in lines))
    return [
        (bisect_right(ends, match.start()) + 1, match[0], instead)
        for pattern, instead in BANNED.items()
        for match in re.finditer(pattern, " ".join(lines), re.IGNORECASE)
    ]


def test_no_banned_word_is_used() -> None:
    found = [
        f"{path.relative_to(HOME)}:{line}: '{words.strip()}'; write: {instead}"
        for path in files()
        for line, words, instead in banned_in(path.read_text(encoding="utf-8"))
    ]
    assert not found, "\n".join(found)


@pytest.mark.parametrize(
    "text",
    [
        "planned anew",
        "Whoever looks costs nothing",
        "asked for by somebody who may",
        "nobody runs but the logger",
        "'float32' is no type of a field",
        "what is told\nof a level",
        "# it is\n    # no file",
        "another one that will do",
    ],
)
def test_banned_words_are_found(text: str) -> None:
    assert banned_in(text)


def test_plain_text_is_accepted() -> None:
    assert not banned_in("there is no graph; it is not a file; nobody reads it; is no longer used")
