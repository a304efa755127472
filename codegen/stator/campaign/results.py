"""The results of a campaign in its folder. `flights.jsonl` gets each flight as it ends;
`flights.parquet` has all of them in order, and equal campaigns have equal bytes there."""

from __future__ import annotations

import contextlib
import json
from typing import TYPE_CHECKING, Any

from stator.campaign.columns import RESULTS
from stator.diagnostics import UserError, shown_path

if TYPE_CHECKING:
    from pathlib import Path

    from stator.campaign.definition import Campaign

INPUTS = {
    "flight": "int64",
    "seed": "int64",
    "vehicle_varies": "bool",
    "wind_m_s": "double",
    "wind_from_deg": "double",
    "gusts": "string",
    "mission": "string",
    "pilot": "string",
    "faults": "string",
}
ROWS_IN_A_GROUP = 65_536


class Results:
    """Of `identity`: what has an influence on a result. Raises `UserError` if the folder has those
    of another campaign."""

    def __init__(self, folder: Path, campaign: Campaign, identity: str) -> None:
        self.folder = folder
        self._campaign = campaign
        self.parquet = folder / "flights.parquet"
        self._journal = folder / "flights.jsonl"
        self._note = folder / "campaign.json"
        folder.mkdir(parents=True, exist_ok=True)
        self.rows: dict[int, dict[str, Any]] = {}
        if self._note.is_file():
            self._resume(identity)
        elif any(folder.iterdir()):
            raise UserError(
                f"error: expected an empty folder, or one with results, found "
                f"'{shown_path(folder)}' with other files\nhint: name another folder: -o DIR"
            )
        self._note.write_text(json.dumps({"identity": identity}, indent=2) + "\n", encoding="utf-8")
        self._file = self._journal.open("a", encoding="utf-8")

    def add(self, text: str) -> None:
        """A result as JSON."""
        row = json.loads(text)
        self.rows[row["flight"]] = row
        self._file.write(text + "\n")
        self._file.flush()

    def close(self) -> None:
        self._file.close()

    def finish(self, count: int) -> list[dict[str, Any]]:
        """Writes the table of all flights, in order, and returns it."""
        rows = [self.rows[number] for number in range(count)]
        write_table(self._campaign, rows, self.parquet)
        self.close()
        self._journal.unlink()
        return rows

    def _resume(self, identity: str) -> None:
        found = None
        with contextlib.suppress(ValueError):
            found = json.loads(self._note.read_bytes())["identity"]
        if found != identity:
            raise UserError(
                f"error: the results in '{shown_path(self.folder)}' are of another campaign: the "
                "file, the graph or the code has changed\n"
                "hint: name another folder with -o DIR, or remove this one"
            )
        if self.parquet.is_file():
            import pyarrow.parquet as pq

            for row in pq.read_table(self.parquet).to_pylist():
                self.rows[row["flight"]] = row
        if not self._journal.is_file():
            return
        whole, end, _ = self._journal.read_bytes().rpartition(b"\n")
        for line in whole.splitlines():
            row = json.loads(line)
            self.rows[row["flight"]] = row
        self._journal.write_bytes(whole + end)  # the last line may have been cut


def write_table(campaign: Campaign, rows: list[dict[str, Any]], file: Path) -> None:
    import pyarrow as pa
    import pyarrow.parquet as pq

    params = {
        param.name: "bool" if isinstance(param.value.values[0], bool) else "double"
        for param in campaign.params
    }
    kinds = {"bool": pa.bool_(), "int64": pa.int64(), "double": pa.float64(), "string": pa.string()}
    columns = INPUTS | params | RESULTS
    schema = pa.schema([(name, kinds[kind]) for name, kind in columns.items()])
    table = pa.Table.from_pylist(rows, schema=schema)
    partial = file.with_suffix(".part")
    pq.write_table(table, partial, compression="zstd", row_group_size=ROWS_IN_A_GROUP)
    partial.replace(file)
