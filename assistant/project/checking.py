"""Checking a project: that everything builds, and what of it does not suit its controller's robot.

Nothing is written into `build/`: programs are made anew in a folder that is gone afterwards.
"""

from __future__ import annotations

import contextlib
import shutil
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path as FilePath
from tempfile import TemporaryDirectory

from assistant.base.diagnostics import Diagnostic, Refused, Severity
from assistant.base.file_sets import scratch_folder
from assistant.compiler.checker import check_files
from assistant.findings.severities import apply_severities
from assistant.project import rules
from assistant.project.building import Progress, chosen_orders, name_clashes
from assistant.project.inputs import digest_of
from assistant.project.layout import BUILD_FOLDER, Project
from assistant.project.making import MadeProgram, make_all, order_of, shown_path


@dataclass(frozen=True, slots=True)
class ProjectCheck:
    """What was found. programs: how many, of all targets. ignored: by comments in programs.

    sources: the files that the programs are made of.
    """

    programs: int
    findings: tuple[Diagnostic, ...]
    ignored: tuple[Diagnostic, ...] = ()
    unreadable: bool = False
    sources: tuple[str, ...] = ()


def check(
    project: Project,
    *,
    jobs: int | None = None,
    working: Progress | None = None,
) -> ProjectCheck:
    """Everything that targets want is made and checked, the programs of a target together.

    Nothing of the project is changed. Raises Refused if no folder at all can be written.
    """
    orders = {
        (place.name, recipe.name): order_of(project.folder, place, recipe)
        for place, recipe in chosen_orders(project, ())
    }
    with (working or _no_progress)(len(set(orders.values()))):
        made = make_all(list(orders.values()), jobs)
        found = [finding for order in made for finding in made[order].findings]
        ignored: list[Diagnostic] = []
        unreadable = any(one.unreadable for one in made.values())
        for place in project.places:
            programs = {r.name: orders[place.name, r.name] for r in place.recipes}
            by_name = {name: made[order] for name, order in programs.items()}
            digests = {
                name: {file: digest_of(data) for file, data in one.files.items()}
                for name, one in by_name.items()
            }
            found += name_clashes(place.name, digests)
            arms: dict[str | None, list[str]] = {}
            for name, order in programs.items():
                arms.setdefault(order.arm, []).append(name)
            for arm, names in arms.items():
                one = _check_on_robot(project, place.name, arm, [by_name[name] for name in names])
                found += one.findings
                ignored += one.ignored
                unreadable |= one.unreadable
    return ProjectCheck(
        len(orders),
        tuple(dict.fromkeys(found)),
        tuple(dict.fromkeys(ignored)),
        unreadable,
        tuple(dict.fromkeys(shown_path(order.recipe.source) for order in orders.values())),
    )


@contextlib.contextmanager
def _target_folder(project: Project) -> Iterator[FilePath]:
    """A folder for the programs of a target, which is gone afterwards.

    It is in the project, whose settings hold for them there. Where the project cannot be written it
    is among the temporary files of the computer, with a copy of the project's file.
    """
    with contextlib.ExitStack() as stack:
        try:
            folder = stack.enter_context(scratch_folder(project.kept))
        except OSError:
            folder = FilePath(stack.enter_context(TemporaryDirectory())).resolve()
            shutil.copyfile(project.file, folder / project.file.name)
        yield folder


def _no_progress(_: int) -> contextlib.AbstractContextManager[None]:
    return contextlib.nullcontext()


def _check_on_robot(
    project: Project, target: str, arm: str | None, made: Sequence[MadeProgram]
) -> ProjectCheck:
    """The files of programs for one robot, as they will be on the controller."""
    files = {name: data for one in made for name, data in one.files.items()}
    if not files:
        return ProjectCheck(0, ())
    origins = {name: origin for one in made for name, origin in one.origins.items()}
    told = [finding for one in made if not one.origins for finding in one.findings]
    try:
        with _target_folder(project) as folder:
            paths = _written_names(folder, files)
            checked = check_files(list(paths), robot=arm)
            settled = apply_severities(checked.findings, checked.texts)
    except OSError as error:
        reason = error.strerror or str(error)
        finding = rules.NOT_KEPT(file=error.filename or project.kept, reason=reason)
        raise Refused(finding, exit_status=2) from None
    places = {
        path: shown_path(
            project.folder / origins.get(name, (BUILD_FOLDER / target / name).as_posix())
        )
        for path, name in paths.items()
    }
    whole = {str(folder): shown_path(project.folder / BUILD_FOLDER / target)}

    def placed(findings: Iterable[Diagnostic]) -> tuple[Diagnostic, ...]:
        return tuple(
            replace(one, path=_original_path(one.path, {**whole, **places})) for one in findings
        )

    left = [f for f in settled.left if _is_new_finding(f, paths, origins, told)]
    return ProjectCheck(0, placed(left), placed(settled.ignored), checked.unreadable)


def _is_new_finding(
    finding: Diagnostic,
    paths: Mapping[str, str],
    origins: Mapping[str, str],
    told: Sequence[Diagnostic],
) -> bool:
    """Whether a finding tells what the making of a program has not told.

    Notes about texts that we wrote are of no interest to those who cannot change them. Beside files
    that somebody else wrote, what is found may be about any of them: only the same is told already.
    """
    if paths.get(finding.path or "") in origins:
        return True
    same = (one for one in told if one.code == finding.code)
    if origins:
        same = (one for one in same if one.place == finding.place)
    return finding.severity is not Severity.INFO and not any(same)


def _original_path(path: str | None, places: Mapping[str, str]) -> str | None:
    return places.get(path or "", path)


def _written_names(folder: FilePath, files: Mapping[str, bytes]) -> dict[str, str]:
    """Path of each file that is written into a folder → its name."""
    for name, data in files.items():
        (folder / name).write_bytes(data)
    return {str(folder / name): name for name in files}
