"""A flight's log for other tools."""
