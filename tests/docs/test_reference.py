"""docs/reference.md says what the checker checks."""

from stator import HOME
from stator.schema.reference import reference


def test_the_page_is_what_the_command_prints() -> None:
    page = (HOME / "docs" / "reference.md").read_text(encoding="utf-8")
    assert page == reference(), "./stator schema --reference > docs/reference.md"


def test_every_key_has_a_meaning() -> None:
    rows = [
        line.split(" | ") for line in reference().splitlines() if line.startswith(("| `", "| *"))
    ]
    assert len(rows) > 80
    assert [row[0] for row in rows if row[2].strip(" |") == ""] == ["| `NAME`"]
