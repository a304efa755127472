"""Installs what `./stator` needs: missing Debian packages, and the Python environment (.venv).

It uses the standard library only, because it runs before anything is installed. Arguments: the
first line of the stamp, "tests" or nothing, then the missing packages.
"""

import importlib.util
import os
import shlex
import shutil
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT / "codegen"))

from stator.lock import Held, held  # noqa: E402  (it takes nothing but the standard library)

ENVIRONMENT = ROOT / ".venv"
REQUIREMENTS = ROOT / "requirements.txt"
FOR_TESTS = ROOT / "requirements-test.txt"
LOG = ROOT / "build" / "setup.log"
APT = Path("/etc/apt")
NOT_DONE = 2  # the exit status: codegen/stator/diagnostics.py
OS_RELEASE = Path("/etc/os-release")
# Packages that are too old in the release, and those that must come from backports with them.
QEMU = ["qemu-system-arm", "qemu-system-common", "qemu-system-data"]
FROM_BACKPORTS = {"bookworm": {"qemu-system-arm": QEMU}}
# Some users set these for other projects; here they would move the packages elsewhere.
UNWANTED_VARIABLES = ("PIP_TARGET", "PIP_PREFIX", "PIP_USER")


class SetUpError(Exception):
    """An installation failed: the reason, and the commands to do it by hand."""

    def __init__(self, reason: str, by_hand: list[str]) -> None:
        super().__init__(reason)
        self.by_hand = by_hand


def say(text: str) -> None:
    print(f"stator: {text}", file=sys.stderr, flush=True)


def shell(*words: str | Path) -> str:
    return shlex.join(str(word) for word in words)


def run(lock: Held, *command: str | Path) -> bool:
    """Runs a command with its output in the log. The command inherits the lock: after a killed
    set-up, the next one waits until the command has ended."""
    environment = {k: v for k, v in os.environ.items() if k not in UNWANTED_VARIABLES}
    with LOG.open("a", encoding="utf-8") as log:
        print(f"$ {shell(*command)}", file=log, flush=True)
        finished = subprocess.run(
            command,
            stdin=subprocess.DEVNULL,
            stdout=log,
            stderr=log,
            env=environment,
            pass_fds=(lock.fileno(),),
            check=False,
        )
    return finished.returncode == 0


def end_of_log() -> str:
    lines = LOG.read_text(encoding="utf-8", errors="replace").splitlines()
    return "\n".join(f"    {line}" for line in lines[-12:])


def has_terminal() -> bool:
    try:
        os.close(os.open("/dev/tty", os.O_RDWR))
    except OSError:
        return False
    return True


def release() -> str:
    """The code name of this Debian or Ubuntu, such as bookworm; empty if it has none."""
    if not OS_RELEASE.exists():
        return ""
    lines = OS_RELEASE.read_text(encoding="utf-8").splitlines()
    names = [line.partition("=")[2] for line in lines if line.startswith("VERSION_CODENAME=")]
    return names[0].strip('"') if names else ""


def backports_source(suite: str) -> str:
    """The apt source of backports, on the same server as the release's packages."""
    for file in sorted((APT / "sources.list.d").glob("*.sources")):
        for entry in file.read_text(encoding="utf-8").split("\n\n"):
            pairs = [line.partition(":") for line in entry.splitlines() if ":" in line]
            fields = {key.lower(): value.strip() for key, _, value in pairs if key[:1] != "#"}
            if suite in fields.get("suites", "").split():
                signed = fields.get("signed-by", "")
                lines = ["Types: deb", f"URIs: {fields['uris']}", f"Suites: {suite}-backports"]
                lines += ["Components: main", *([f"Signed-By: {signed}"] if signed else [])]
                return "\n".join(lines) + "\n"
    for file in (APT / "sources.list", *sorted((APT / "sources.list.d").glob("*.list"))):
        for line in file.read_text(encoding="utf-8").splitlines() if file.is_file() else []:
            words = [word for word in line.split() if not word.startswith("[")]
            if words[:1] == ["deb"] and suite in words[2:3]:
                return (
                    f"Types: deb\nURIs: {words[1]}\nSuites: {suite}-backports\nComponents: main\n"
                )
    raise SetUpError(
        f"missing apt source of {suite}, which is needed to find {suite}-backports",
        [f"add a source with the suite {suite}-backports below {APT}, then repeat ./stator"],
    )


def with_backports(
    lock: Held, packages: list[str], prefix: list[str]
) -> tuple[list[str], list[str]]:
    """The packages, with a mark on those that come from backports; and the commands that add
    backports to apt's sources, if they are needed."""
    suite = release()
    late = FROM_BACKPORTS.get(suite, {})
    if not any(package in late for package in packages):
        return packages, []
    marked = [package for package in packages if package not in late]
    marked += [f"{part}/{suite}-backports" for p in packages for part in late.get(p, [])]
    policy = subprocess.run(["apt-cache", "policy"], capture_output=True, text=True, check=False)
    if f"{suite}-backports" in policy.stdout:
        return marked, []
    target = APT / "sources.list.d" / f"{suite}-backports.sources"
    text = shlex.quote(backports_source(suite))
    command = shell(*prefix, "sh", "-c", f"printf %s {text} > {target}")
    if not (run(lock, *shlex.split(command)) and run(lock, *prefix, "apt-get", "update")):
        raise SetUpError(f"cannot add {suite}-backports to apt's sources", [command])
    return marked, [command]


def install_packages(lock: Held, packages: list[str]) -> None:
    prefix = [] if os.geteuid() == 0 else ["sudo"]
    update = shell(*prefix, "apt-get", "update")
    by_hand = [update, shell(*prefix, "apt-get", "install", *packages)]
    if shutil.which("apt-get") is None:
        raise SetUpError(
            "missing apt-get to install: " + " ".join(packages),
            ["install these Debian packages, or the same programs, with your package manager"],
        )
    if prefix and shutil.which("sudo") is None:
        raise SetUpError(
            "missing root rights, or sudo, to install: " + " ".join(packages),
            ["as root: " + command.removeprefix("sudo ") for command in by_hand],
        )
    packages, first = with_backports(lock, packages, prefix)
    by_hand = [*first, update, shell(*prefix, "apt-get", "install", *packages)]
    say(f"installing with apt: {' '.join(packages)}")
    say(f"  by hand: {by_hand[-1]}")
    sudo = prefix if has_terminal() else [word for p in prefix for word in (p, "--non-interactive")]
    apt = [*sudo, "env", "DEBIAN_FRONTEND=noninteractive", "apt-get", "--yes"]
    apt += ["-o", "DPkg::Lock::Timeout=600"]
    install = [*apt, "install", "--no-install-recommends", *packages]
    # Update the package lists only if they are missing or out of date.
    if not (run(lock, *install) or (run(lock, *apt, "update") and run(lock, *install))):
        reason = f"apt-get failed to install: {' '.join(packages)}; the end of {LOG}:"
        raise SetUpError(f"{reason}\n{end_of_log()}", by_hand)


def environment_is_usable(lock: Held) -> bool:
    """Whether packages can be added to the existing environment. An interrupted set-up leaves
    `unfinished` in it."""
    python = ENVIRONMENT / "bin" / "python"
    unfinished = (ENVIRONMENT / "unfinished").exists()
    return python.exists() and not unfinished and run(lock, python, "-I", "-m", "pip", "--version")


def can_make_environment() -> bool:
    importlib.invalidate_caches()
    return importlib.util.find_spec("ensurepip") is not None


def package_of_venv() -> str:
    """The Debian or Ubuntu package that makes environments."""
    if sys.base_prefix != "/usr":
        reason = f"{sys.executable} cannot make environments: missing module ensurepip"
        raise SetUpError(reason, ["STATOR_PYTHON=/path/to/another/python3 ./stator setup"])
    return f"python3.{sys.version_info.minor}-venv"


def make_environment(lock: Held, head: str, files: list[Path], usable: bool) -> None:
    stamp, unfinished = ENVIRONMENT / "stamp", ENVIRONMENT / "unfinished"
    lists = [file.read_text(encoding="utf-8").rstrip("\n") for file in files]
    wanted = "\n".join([head, *lists])
    if usable and stamp.exists() and stamp.read_text(encoding="utf-8").startswith(wanted):
        return  # what is there may be more
    python = ENVIRONMENT / "bin" / "python"
    create = (sys.executable, "-I", "-m", "venv", ENVIRONMENT)
    named = [word for file in files for word in ("-r", file)]
    install = (python, "-I", "-m", "pip", "install", "--only-binary", ":all:", *named)
    by_hand = f"{shell(*create, '--clear')} && {shell(*install)}"
    if not usable and not can_make_environment():
        reason = "cannot install Python packages: missing Python module ensurepip"
        raise SetUpError(reason, [by_hand])
    say(f"installing Python packages into {ENVIRONMENT} (half a minute)")
    say(f"  by hand: {by_hand}")
    stamp.unlink(missing_ok=True)
    if not usable:
        shutil.rmtree(ENVIRONMENT, ignore_errors=True)
        ENVIRONMENT.mkdir()
    unfinished.touch()
    if not ((usable or run(lock, *create)) and run(lock, *install)):
        reason = f"cannot install Python packages: pip failed; the end of {LOG}:\n{end_of_log()}"
        raise SetUpError(reason, [by_hand])
    for site_packages in ENVIRONMENT.glob("lib/python*/site-packages"):
        # Relative, so that the project can move, and its path can contain any character.
        relative = os.path.relpath(ROOT / "codegen", site_packages)
        (site_packages / "stator.pth").write_text(relative + "\n", encoding="utf-8")
    unfinished.unlink()
    temporary = stamp.with_suffix(".new")
    temporary.write_text(wanted + "\n", encoding="utf-8")
    temporary.replace(stamp)


def set_up(head: str, for_tests: bool, packages: list[str]) -> list[SetUpError]:
    """Installs everything that it can. Returns the problems."""
    LOG.parent.mkdir(exist_ok=True)
    problems: list[SetUpError] = []
    with held(ROOT / ".venv.lock", "sets up", "./stator setup") as lock:
        LOG.write_text("", encoding="utf-8")
        usable = environment_is_usable(lock)
        try:
            if not usable and not can_make_environment():
                packages = [*packages, package_of_venv()]
            if packages:
                install_packages(lock, packages)
        except SetUpError as problem:
            problems.append(problem)
        try:
            files = [REQUIREMENTS, *([FOR_TESTS] if for_tests else [])]
            make_environment(lock, head, files, usable)
        except SetUpError as problem:
            problems.append(problem)
    return problems


def main(arguments: list[str]) -> int:
    try:
        head, tests, *packages = arguments
        problems = set_up(head, tests == "tests", packages)
    except KeyboardInterrupt:
        say("set-up interrupted; the next ./stator continues it")
        return 130
    except OSError as error:
        say(f"error: cannot set up: {error}")
        return NOT_DONE
    for problem in problems:
        say(f"error: {problem}")
        for command in problem.by_hand:
            say(f"  by hand: {command}")
    if not problems:
        say("set-up complete")
    return NOT_DONE if problems else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
