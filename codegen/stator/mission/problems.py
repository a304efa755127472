"""Everything that is wrong with one mission file, in order, and each with what to do."""

from __future__ import annotations

from typing import TYPE_CHECKING

from stator.diagnostics import UserError

if TYPE_CHECKING:
    from pathlib import Path

MAX_SHOWN = 50


class Problems:
    """Collects; `stop` raises all of them as one `UserError`."""

    def __init__(self, file: Path) -> None:
        self._file = file
        self._found: dict[str, tuple[int, str]] = {}  # the text: where, and the hint

    def add(self, where: int, what: str, hint: str) -> None:
        """`where`: the item's number in the file; 0 is before the first."""
        shown = what if what.isprintable() else "".join(c if c.isprintable() else "?" for c in what)
        self._found.setdefault(shown, (where, hint))

    def __len__(self) -> int:
        return len(self._found)

    def stop(self) -> None:
        if not self._found:
            return
        rows = sorted(self._found.items(), key=lambda row: row[1][0])
        texts = [
            f"error: {self._file}: {what}\nhint: {hint}" for what, (_, hint) in rows[:MAX_SHOWN]
        ]
        if len(rows) > MAX_SHOWN:
            texts.append(f"error: {len(rows) - MAX_SHOWN} more errors")
        raise UserError("\n".join(texts))
