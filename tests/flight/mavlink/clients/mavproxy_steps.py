"""MAVProxy at a pseudo terminal, as a person would use it. Arguments: the port, and latitude and
longitude of home in degrees."""

from __future__ import annotations

import re
import sys
import tempfile
from pathlib import Path

import MAVProxy
import pexpect

HANGS_S = 600  # of wall time
PROGRAM = next(
    path
    for path in (Path(MAVProxy.__path__[0]).parent / "bin", Path(sys.executable).parent)
    if (path / "mavproxy.py").exists()
)
MODULES = "log,wp,rally,fence,param,cmdlong,mode,arm,misc,link,output"
ROW = "\t".join(["{}"] * 12) + "\n"  # of a file of waypoints


class Person:
    def __init__(self, port: str, folder: Path) -> None:
        self.folder = folder
        options = [
            f"--master=udpin:127.0.0.1:{port}",
            "--dialect=common",
            "--mav20",
            f"--state-basedir={folder}",
            f"--default-modules={MODULES}",
        ]
        self.terminal = pexpect.spawn(
            sys.executable,
            ["-u", str(PROGRAM / "mavproxy.py"), *options],
            cwd=str(folder),
            encoding="utf-8",
            codec_errors="replace",
            echo=False,
            timeout=HANGS_S,
        )
        self.terminal.logfile_read = sys.stdout

    def hear(self, wanted: str) -> re.Match[str]:
        self.terminal.expect(wanted)
        match = self.terminal.match
        assert isinstance(match, re.Match)
        return match

    def say(self, line: str, wanted: str) -> re.Match[str]:
        self.terminal.sendline(line)
        return self.hear(wanted)

    def say_until(self, line: str, wanted: str) -> None:
        """Says it again until the answer comes, as what changes takes its time."""
        for _ in range(HANGS_S):
            self.terminal.sendline(line)
            if self.terminal.expect([wanted, pexpect.TIMEOUT], timeout=1) == 0:
                return
        raise AssertionError(f"{line}: no {wanted}")

    def waypoints(self, name: str, rows: list[tuple[float, ...]]) -> Path:
        """A file of frame, command, four parameters, x, y and z."""
        path = self.folder / name
        lines = [ROW.format(i, int(i == 0), *row, 1) for i, row in enumerate(rows)]
        path.write_text("QGC WPL 110\n" + "".join(lines))
        return path


def changes_parameters(p: Person) -> None:
    p.say("param fetch", r"Received \d+ parameters")
    shown = p.say("param show MIS_TAKEOFF_ALT", r"MIS_TAKEOFF_ALT\s+([\d.]+)")
    usual = float(shown.group(1))
    p.terminal.sendline(f"param set MIS_TAKEOFF_ALT {usual + 1.0}")
    p.say_until("param show MIS_TAKEOFF_ALT", rf"MIS_TAKEOFF_ALT\s+{usual + 1.0}")
    p.terminal.sendline(f"param set MIS_TAKEOFF_ALT {usual}")
    p.say_until("param show MIS_TAKEOFF_ALT", rf"MIS_TAKEOFF_ALT\s+{usual}")
    file = p.folder / "saved.parm"
    p.say(f"param save {file}", r"Saved \d+ parameters")
    p.say(f"param load {file}", r"Loaded \d+ parameters [^\n]*changed 0")


def keeps_plans(p: Person, latitude: float, longitude: float) -> None:
    rows = [
        (0, 16, 0, 0, 0, 0, latitude, longitude, 0),  # home, as MAVProxy counts
        (3, 22, 0, 0, 0, 0, latitude, longitude, 6),
        (3, 16, 0, 2, 0, 0, latitude + 1e-4, longitude, 6),
        (3, 16, 1, 2, 0, 0, latitude + 1e-4, longitude + 1e-4, 8),
        (3, 16, 1, 2, 0, 0, latitude, longitude + 1e-4, 8),
        (3, 16, 1, 2, 0, 0, latitude - 1e-4, longitude, 8),
        (3, 20, 0, 0, 0, 0, 0, 0, 0),
    ]
    p.say(f"wp load {p.waypoints('way.txt', rows)}", r"Sent all 7 waypoints")
    p.hear(r"TYPE_MISSION: ACCEPTED")
    p.say("wp list", r"Saved 7 waypoints")
    p.say("wp set 2", r"DO_SET_MISSION_CURRENT: ACCEPTED")
    p.say("wp clear", r"ACCEPTED")
    d = 2e-3
    corners = [(-d, -d), (d, -d), (d, d), (-d, d)]
    rows = [(0, 5001, 4, 0, 0, 0, latitude + a, longitude + b, 0) for a, b in corners]
    p.say(f"fence load {p.waypoints('fence.txt', rows)}", r"Sent all 4 fence items")
    p.hear(r"TYPE_FENCE: ACCEPTED")
    p.say("fence list", r"Saved 4 fence items")
    p.say("fence clear", r"TYPE_FENCE: ACCEPTED")
    rows = [(3, 5100, 0, 0, 0, 0, latitude + 1e-4, longitude, 10)]
    p.say(f"rally load {p.waypoints('rally.txt', rows)}", r"Sent all 1 rally items")
    p.hear(r"TYPE_RALLY: ACCEPTED")
    p.say("rally list", r"Saved 1 rally items")


def flies(p: Person) -> None:
    p.say("arm throttle", r"\bARMED")
    p.say("disarm", r"DISARMED")
    p.say("arm throttle", r"\bARMED")
    # The prompt shows each mode.
    p.say("long NAV_TAKEOFF 0 0 0 0 0 0 0", r"NAV_TAKEOFF: ACCEPTED")
    p.hear(r"TAKEOFF> ")
    p.hear(r"LOITER> ")  # it is up there
    p.say("long DO_SET_MODE 1 4 3", r"DO_SET_MODE: ACCEPTED")
    p.say("long NAV_RETURN_TO_LAUNCH", r"NAV_RETURN_TO_LAUNCH: ACCEPTED")
    p.hear(r"(RTL|LAND)> ")
    p.hear(r"DISARMED")


def main(port: str, latitude: float, longitude: float) -> None:
    with tempfile.TemporaryDirectory() as folder:
        person = Person(port, Path(folder))
        person.hear(r"Detected vehicle 1:1")
        person.hear(r"Received \d+ parameters")  # which it fetches by itself
        changes_parameters(person)
        keeps_plans(person, latitude, longitude)
        flies(person)
        person.terminal.close(force=True)


if __name__ == "__main__":
    main(sys.argv[1], float(sys.argv[2]), float(sys.argv[3]))
