"""Stator's compiler and command line, in rooms: README.md has their order."""

from pathlib import Path

HOME = Path(__file__).resolve().parents[2]  # the checkout
