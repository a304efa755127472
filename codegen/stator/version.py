"""The version of Stator, in this one place."""

from __future__ import annotations

import subprocess
from pathlib import Path

from stator import HOME

VERSION = "0.1.0-dev"
# Of the files that a user writes. It grows when a file that was accepted is refused, or means
# something else; new keys leave it.
SCHEMA_VERSION = 1


def version_text() -> str:
    return f"stator {VERSION}, {_commit()}, schema {SCHEMA_VERSION}"


def _commit() -> str:
    """The commit of this checkout. A copy without .git may lie in a repository of another
    project, whose commit says nothing."""
    top = _git("rev-parse", "--show-toplevel")
    commit = _git("describe", "--always", "--exclude=*", "--abbrev=12", "--dirty=, modified")
    if not top or not commit or Path(top).resolve() != HOME:
        return "commit unknown"
    return f"commit {commit}"


def _git(*arguments: str) -> str:
    """The output of git; empty if git is missing or fails."""
    try:
        finished = subprocess.run(
            ["git", "-C", str(HOME), *arguments], capture_output=True, text=True, check=False
        )
    except OSError:
        return ""
    return finished.stdout.strip() if finished.returncode == 0 else ""
