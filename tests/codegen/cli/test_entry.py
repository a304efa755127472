"""`./stator` itself: what it starts, what it installs, and what it says where it cannot."""

import os
import re
import shlex
import shutil
import subprocess
import sys
import time
from pathlib import Path

import pytest

from stator.__main__ import COMMANDS

ROOT = Path(__file__).resolve().parents[3]
REAL_PYTHON = os.path.realpath(sys.executable)
MACHTYPE = subprocess.run(
    ["bash", "-c", "echo $MACHTYPE"], capture_output=True, text=True, check=True
).stdout.strip()


APT = """# a comment
[host]
hovercraft  hover
[tests]
# another
wind-tunnel  blow
"""


class Machine:
    """A made-up machine: a project folder with a space in its name, and a PATH that has only the
    programs named here. It needs one Debian package, `hovercraft`, for building, and one for
    tests."""

    def __init__(self, folder: Path) -> None:
        self.project = folder / "a b" / "stator"
        self.bin = folder / "bin"
        self.calls = folder / "calls"
        package = self.project / "codegen" / "stator"
        package.mkdir(parents=True)
        for name in ("__main__.py", "__init__.py", "lock.py"):
            shutil.copy(ROOT / "codegen" / "stator" / name, package)
        self.bin.mkdir()
        # Debian's own interpreter is looked for at a fixed place; here it is part of the machine.
        script = (ROOT / "stator").read_text().replace("/usr/bin/python3", f"{self.bin}/system")
        self.write(self.project / "stator", script)
        shutil.copy(ROOT / "codegen" / "bootstrap.py", self.project / "codegen")
        (self.project / "requirements.txt").write_text("# none\n")
        (self.project / "requirements-test.txt").write_text("# of tests\n")
        (self.project / "requirements-apt.txt").write_text(APT)
        for program in ("bash", "env", "readlink"):
            (self.bin / program).symlink_to(shutil.which(program) or "")

    def write(self, path: Path, script: str) -> None:
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(script)
        path.chmod(0o755)

    def add_program(self, name: str, script: str = "") -> None:
        self.write(
            self.bin / name, f'#!{self.bin}/bash\necho "{name} $*" >>"{self.calls}"\n{script}'
        )

    def add_ready_environment(self, lists: str = "# none\n") -> None:
        """A stand-in for the finished one; its interpreter prints how it was called."""
        environment = self.project / ".venv"
        self.write(environment / "bin" / "python", f'#!{self.bin}/bash\necho "ran: $*"\n')
        (environment / "stamp").write_text(f"{MACHTYPE}\n{lists}")

    def run(self, *arguments: str, **variables: str) -> subprocess.CompletedProcess[str]:
        return subprocess.run(
            [str(self.bin / "bash"), str(self.project / "stator"), *arguments],
            env={"PATH": str(self.bin), "HOME": str(self.bin), **variables},
            cwd="/",
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
            check=False,
        )


@pytest.fixture
def machine(tmp_path: Path) -> Machine:
    return Machine(tmp_path)


def test_with_everything_in_place_it_only_starts_the_command_line(machine: Machine) -> None:
    machine.add_ready_environment("# none\n# of tests\n")
    machine.add_program("hover")
    machine.add_program("blow")
    (machine.project / "codegen" / "bootstrap.py").unlink()  # nothing to set up, so not run
    for command in ("check", "fly", "test"):
        result = machine.run(command, "x y", "*")
        assert result.stdout == f"ran: -I -X utf8 -m stator {command} x y *\n"
        assert result.returncode == 0


def test_it_works_through_links(machine: Machine, tmp_path: Path) -> None:
    machine.add_ready_environment()
    (tmp_path / "one").symlink_to("a b/stator/stator")
    (tmp_path / "two").symlink_to(tmp_path / "one")
    command = [str(machine.bin / "bash"), "../two", "check"]
    environment = {"PATH": str(machine.bin)}
    result = subprocess.run(command, env=environment, cwd=machine.bin, capture_output=True)
    assert result.stdout == b"ran: -I -X utf8 -m stator check\n"


def test_what_only_tests_need_is_for_tests(machine: Machine) -> None:
    machine.add_ready_environment()
    machine.add_program("hover")
    assert machine.run("fly").stdout == "ran: -I -X utf8 -m stator fly\n"
    result = machine.run("test", STATOR_PYTHON=REAL_PYTHON)
    assert result.returncode == 2
    assert "missing apt-get to install: wind-tunnel\n" in result.stdout
    assert "stator: installing Python packages" in result.stdout
    stamp = machine.project / ".venv" / "stamp"
    assert stamp.read_text() == f"{MACHTYPE}\n# none\n# of tests\n"
    machine.add_program("blow")
    for command in ("test", "fly"):
        assert machine.run(command).stdout == f"ran: -I -X utf8 -m stator {command}\n"


def test_setup_with_everything_in_place_says_so(machine: Machine) -> None:
    machine.add_ready_environment("# none\n# of tests\n")
    machine.add_program("hover")
    machine.add_program("blow")
    result = machine.run("setup")
    assert (result.returncode, result.stdout) == (0, "stator: everything is installed\n")


def test_commands_that_build_nothing_need_no_packages(machine: Machine) -> None:
    machine.add_ready_environment()
    for command in ("check", "gen", "explain", "chekc", "--help"):
        assert machine.run(command).stdout == f"ran: -I -X utf8 -m stator {command}\n"


def test_without_python_it_says_what_to_install(machine: Machine) -> None:
    result = machine.run("check")
    assert result.returncode == 2
    assert "expected Python 3.11 or newer, found: no working python3" in result.stdout
    assert "hint: on Debian 12, Ubuntu 24.04 or newer: sudo apt-get install" in result.stdout


def test_a_python_that_is_too_old_is_named(machine: Machine) -> None:
    # To `-c ...` an old one answers with an empty line.
    machine.add_program("python3", '[[ $1 == --version ]] && echo "Python 3.9.2" || echo')
    result = machine.run("check")
    assert result.returncode == 2
    assert "expected Python 3.11 or newer, found: Python 3.9.2" in result.stdout


def test_a_broken_shim_is_passed_over(machine: Machine) -> None:
    machine.add_program("python3", "exit 127")
    machine.add_program("python3.12", f'exec "{REAL_PYTHON}" "$@"')
    machine.add_ready_environment()
    assert "missing apt-get" in machine.run("fly").stdout  # so bootstrap.py has been run


def test_without_apt_it_lists_what_is_missing(machine: Machine) -> None:
    machine.add_ready_environment()
    result = machine.run("fly", STATOR_PYTHON=REAL_PYTHON)
    assert result.returncode == 2
    assert "stator: error: missing apt-get to install: hovercraft\n" in result.stdout
    assert "by hand: " in result.stdout
    assert "ran:" not in result.stdout


SUDO = 'while [[ $1 == -* ]]; do shift; done; exec "$@"'
APT_THAT_NEEDS_LISTS = """
if [[ $* == *update* ]]; then >"$0.lists"; exit; fi
[[ -e $0.lists ]] || exit 100
printf '#!/bin/sh\\n' >"${0%/*}/hover"; /bin/chmod +x "${0%/*}/hover"
"""


def test_packages_are_installed_once(machine: Machine) -> None:
    machine.add_ready_environment()
    machine.add_program("sudo", SUDO)
    machine.add_program("apt-get", APT_THAT_NEEDS_LISTS)
    result = machine.run("fly", STATOR_PYTHON=REAL_PYTHON)
    assert result.returncode == 0
    assert "stator: installing with apt: hovercraft\n" in result.stdout
    assert "apt-get install hovercraft\n" in result.stdout
    assert result.stdout.endswith("ran: -I -X utf8 -m stator fly\n")
    apt = [line for line in machine.calls.read_text().splitlines() if line.startswith("apt-get")]
    verbs = [re.sub(r".*Timeout=\d+ ", "", line) for line in apt]
    install = "install --no-install-recommends hovercraft"
    assert verbs == [install, "update", install]
    assert machine.run("fly").stdout == "ran: -I -X utf8 -m stator fly\n"


def test_a_failing_apt_is_shown_with_the_commands_to_type(machine: Machine) -> None:
    machine.add_ready_environment()
    machine.add_program("sudo", SUDO)
    machine.add_program("apt-get", "echo Temporary failure resolving; exit 100")
    result = machine.run("fly", STATOR_PYTHON=REAL_PYTHON)
    assert result.returncode == 2
    assert "stator: error: apt-get failed to install: hovercraft; the end of " in result.stdout
    assert "    Temporary failure resolving\n" in result.stdout
    assert re.search(r"by hand: (sudo )?apt-get update\n", result.stdout)
    assert re.search(r"by hand: (sudo )?apt-get install hovercraft\n", result.stdout)


def test_a_package_that_brings_nothing_is_an_error(machine: Machine) -> None:
    machine.add_ready_environment()
    machine.add_program("sudo", SUDO)
    machine.add_program("apt-get", "exit 0")
    result = machine.run("fly", STATOR_PYTHON=REAL_PYTHON)
    assert result.returncode == 2
    assert "error: installed, but missing in PATH or /usr/include: hovercraft\n" in result.stdout


def test_a_full_set_up_from_nothing(machine: Machine) -> None:
    """Makes real environments, with an empty list of packages, so that nothing is downloaded."""
    machine.add_program("python3", f'exec "{REAL_PYTHON}" "$@"')  # a shim, as version managers have
    package = machine.project / "codegen" / "stator"
    machine.write(package / "__main__.py", "import sys; print(sys.argv[1:], sys.path[0])")
    environment = machine.project / ".venv"

    first = machine.run("check")
    assert "stator: installing Python packages" in first.stdout
    assert "stator:   by hand: " in first.stdout
    assert first.stdout.splitlines()[-1].startswith("['check'] ")
    home = re.search(r"^home = (.*)$", (environment / "pyvenv.cfg").read_text(), re.MULTILINE)
    assert home is not None and home[1] == str(Path(REAL_PYTHON).parent)

    second = machine.run("check", PYTHONPATH="/nowhere", PYTHONHOME="/nowhere", PYTHONSAFEPATH="1")
    assert len(second.stdout.splitlines()) == 1

    # As an interrupted set-up leaves it: no stamp yet, and a package that is half there.
    (environment / "stamp").unlink()
    (environment / "unfinished").touch()
    (environment / "rest").touch()
    third = machine.run("check")
    assert "stator: installing Python packages" in third.stdout
    assert not (environment / "rest").exists()

    # A changed list completes the environment in place.
    (environment / "rest").touch()
    (machine.project / "requirements.txt").write_text("# still none\n")
    assert "stator: installing Python packages" in machine.run("check").stdout
    assert (environment / "rest").exists()
    assert len(machine.run("check").stdout.splitlines()) == 1

    # One that fails leaves no stamp, lest the old list, put back, pass for installed.
    (machine.project / "requirements.txt").write_text("no-such-package-for-stator==1\n")
    assert machine.run("check", PIP_NO_INDEX="1").returncode == 2
    assert not (environment / "stamp").exists()


def test_packages_that_cannot_be_had_leave_no_good_environment(machine: Machine) -> None:
    (machine.project / "requirements.txt").write_text("no-such-package-for-stator==1\n")
    variables = {"STATOR_PYTHON": REAL_PYTHON, "PIP_NO_INDEX": "1", "PIP_FIND_LINKS": ""}
    result = machine.run("check", **variables)
    assert result.returncode == 2
    assert "stator: error: cannot install Python packages: pip failed" in result.stdout
    assert "No matching distribution found for no-such-package-for-stator" in result.stdout
    assert "-m pip install" in result.stdout.splitlines()[-1]
    assert (machine.project / ".venv" / "unfinished").exists()
    assert not (machine.project / ".venv" / "stamp").exists()


def test_two_at_once_wait_for_each_other(machine: Machine) -> None:
    machine.add_ready_environment()
    machine.add_program("sudo", SUDO)
    # It fails, so that each of the two calls it; and leaves a mark if one has not ended yet.
    busy = (
        '[[ -e $0.busy ]] && >"$0.overlap"; >"$0.busy"; /bin/sleep 0.3; /bin/rm "$0.busy"; exit 1'
    )
    machine.add_program("apt-get", busy)
    command = [str(machine.bin / "bash"), str(machine.project / "stator"), "fly"]
    environment = {"PATH": str(machine.bin), "STATOR_PYTHON": REAL_PYTHON}
    with subprocess.Popen(command, env=environment, stdout=subprocess.PIPE, text=True) as first:
        while not machine.calls.exists() and first.poll() is None:
            time.sleep(0.01)
        second = machine.run("fly", STATOR_PYTHON=REAL_PYTHON)
        assert first.wait() == 2
    holder = r"stator: waiting for './stator setup' \(process \d+\), which sets up: 0 s\n"
    assert re.search(holder, second.stdout)
    assert second.returncode == 2
    assert not (machine.bin / "apt-get.overlap").exists()


def test_it_knows_for_each_command_what_that_needs() -> None:
    script = (ROOT / "stator").read_text()
    needed = re.search(r"needed_sections\(\) \{\n.*?\n\}", script, re.DOTALL)
    assert needed is not None
    for command in COMMANDS:
        code = f"root={shlex.quote(str(ROOT))}\n{needed[0]}\nneeded_sections {command.name}"
        said = subprocess.run(["bash", "-c", code], capture_output=True, text=True, check=True)
        assert said.stdout.strip() == command.needs, command
