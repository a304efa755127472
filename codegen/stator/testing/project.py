"""The tests of a project outside this repository: `tests/apps/NAME/*_test.cpp` of app NAME,
`tests/graphs/NAME/*_test.cpp` of graph NAME.yaml, and `test_*.py` for pytest."""

import hashlib
import os
from pathlib import Path

from stator import HOME
from stator.build.cmake import configure, lock_of
from stator.build.paths import check_paths
from stator.diagnostics import BuildFailed, UserError
from stator.lock import held
from stator.pipeline import make_app_files, make_buildable_plan
from stator.testing.junit import Case, Outcome
from stator.testing.run import environment_of_tests, run_ctest, run_pytest
from stator.testing.selection import EVERYTHING, select, targets_of


def project_of(names: list[str]) -> Path | None:
    """The folder around the current folder, or around a named path, that has tests or apps. None:
    Stator's own."""
    here = Path.cwd()
    named = [(here / name.partition("::")[0]).resolve() for name in names]
    for place in (*(path for path in named if path.exists()), here):
        if place.is_relative_to(HOME):
            return None
        for folder in (place, *place.parents):
            has_own = (folder / "apps").is_dir() or (folder / "tests").is_dir()
            if has_own and folder.name != "tests":
                return folder
    if any((HOME / name.partition("::")[0]).exists() for name in names):
        return None
    raise UserError(
        f"error: expected a project with apps/ or tests/, found none in '{here}'\n"
        f"hint: ./stator new app NAME writes an app and its test; Stator's own tests run in {HOME}"
    )


def run_project(project: Path, names: list[str], long: bool) -> list[Case]:
    check_paths([HOME, project])
    selection = select(project, names)
    folder = HOME / "build" / f"tests-{hashlib.sha256(os.fsencode(project)).hexdigest()[:8]}"
    cases: list[Case] = []
    apps = _names(project, "apps")
    graphs = _names(project, "graphs")
    if (apps or graphs) and selection.ctest_regex:
        if apps:
            make_app_files(project, apps)  # raises the errors of interfaces
        for graph in graphs:
            make_buildable_plan(str(project / f"{graph}.yaml"), "sitl")
        options = [f"-DSTATOR_PROJECT={project}", "-DSTATOR_TESTS=OFF"]
        environment = environment_of_tests(HOME)
        try:
            configure(folder, options, ["build.ninja"])  # again if a folder of tests is new
            all_of_it = selection == EVERYTHING
            targets = ["all_tests"] if all_of_it else targets_of(selection, folder)
            if targets:
                configure(folder, options, targets)
        except BuildFailed as failed:
            print(f"\n{failed}", flush=True)
            return [Case("build", Outcome.FAILED, str(failed))]
        with held(lock_of(folder), "tests"):
            cases += run_ctest(folder, selection.ctest_regex, long, environment)
    if any(project.glob("tests/**/test_*.py")):
        for number, arguments in enumerate(selection.pytest_runs):
            report = folder / f"pytest{number}.xml"
            report.parent.mkdir(parents=True, exist_ok=True)
            chosen = arguments or [str(project / "tests")]
            cases += run_pytest(report, chosen, long, environment_of_tests(HOME), project)
    return cases


def _names(project: Path, kind: str) -> list[str]:
    files = sorted(project.glob(f"tests/{kind}/*/*_test.cpp"))
    return list(dict.fromkeys(file.parent.name for file in files))
