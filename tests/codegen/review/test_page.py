"""`proof.html`: one page without anything from outside, with the figures of the proof."""

from __future__ import annotations

import json
import re
import shutil
from html.parser import HTMLParser
from typing import TYPE_CHECKING

import pytest
from tests.codegen.prove.graphs import written

from stator import HOME
from stator.__main__ import main

if TYPE_CHECKING:
    from pathlib import Path

VOID = frozenset(("meta", "br", "hr", "img", "input", "link"))
OUTSIDE = frozenset(("script", "link", "img", "iframe", "object", "embed"))


class Page(HTMLParser):
    """Its text, and what is wrong with its tags."""

    def __init__(self, file: Path) -> None:
        super().__init__()
        self.text = ""
        self.wrong: list[str] = []
        self.styles: list[str] = []
        self._open: list[str] = []
        self.feed(file.read_text(encoding="utf-8"))
        self.close()
        self.wrong += [f"open: {tag}" for tag in self._open]

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        if tag in OUTSIDE:
            self.wrong.append(f"from outside: {tag}")
        for key, value in attrs:
            if key in ("src", "href", "xlink:href"):
                self.wrong.append(f"from outside: {key}={value}")
            if key == "style":
                self.styles.append(value or "")
        if tag not in VOID:
            self._open.append(tag)

    def handle_startendtag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.handle_starttag(tag, attrs)
        if tag not in VOID:
            self._open.pop()

    def handle_endtag(self, tag: str) -> None:
        if not self._open or self._open.pop() != tag:
            self.wrong.append(f"closed: {tag}")

    def handle_data(self, data: str) -> None:
        self.text += data


def test_the_page_of_the_quad(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    quad = str(HOME / "graph" / "quad.yaml")
    assert main(["prove", quad, "--board", "fmu_v2", "--no-image", "-o", str(tmp_path)]) == 0
    assert "proof.html: written" in capsys.readouterr().out
    facts = json.loads((tmp_path / "proof.json").read_text())
    page = Page(tmp_path / "proof.html")
    assert page.wrong == []
    assert "PROVEN ONLY IF GUESSES HOLD" in page.text
    for task in facts["tasks"]:
        assert f"slack {task['slack_ns'] / 1e6:.4g} ms" in page.text or (
            f"slack {task['slack_ns'] / 1e3:.4g} us" in page.text
        )
        for name in task["shares"]:
            assert name in page.text
    chain = facts["chains"][0]
    width = 100 * chain["reaction_ns"] / chain["deadline_ns"]
    assert f"width:{width:.2f}%" in page.styles
    # Each timeline is full from its left to its right edge.
    pieces = [re.fullmatch(r"left:([\d.]+)%;width:([\d.]+)%;.*", style) for style in page.styles]
    rows = [(float(piece[1]), float(piece[2])) for piece in pieces if piece]
    begins = [i for i, (left, _) in enumerate(rows) if left == 0]
    assert len(begins) == len(facts["tasks"])
    for begin, end in zip(begins, [*begins[1:], len(rows)], strict=True):
        assert sum(width for _, width in rows[begin:end]) == pytest.approx(100, abs=0.1)
    html = (tmp_path / "proof.html").read_text()
    assert ("<svg" in html) == (shutil.which("dot") is not None)


def test_the_page_says_what_is_late(tmp_path: Path) -> None:
    graph = written(
        tmp_path,
        """
        nodes:
          one: {app: stage, trigger: {every: 1 ms}, priority: 2, budget: 900 us}
          two: {app: stage, trigger: {every: 1 ms}, priority: 1, budget: 900 us}
        """,
    )
    assert main(["prove", str(graph), "-o", str(tmp_path / "out")]) == 1
    page = Page(tmp_path / "out" / "proof.html")
    assert page.wrong == []
    assert "NOT PROVEN: two" in page.text
    assert "no bound of 1 ms" in page.text
    assert "width:100.00%" in page.styles
