"""Output files of several sources: what each one answers, where its files go, and kept edits.

Each source answers for itself: what is refused for one does not keep the others from being
written. Sources whose files have the same names get a folder each. A file that was edited since it
was written is merged, kept or replaced as the user asked; see `compiler.keeping`.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import field
from pathlib import Path
from typing import TYPE_CHECKING, Final, TypeVar

from assistant.base.budgets import internal_error, traceback_wanted
from assistant.base.data_classes import dataclass
from assistant.base.diagnostics import Diagnostic, Refused, info
from assistant.base.file_sets import file_in_folder, write_all
from assistant.base.worker_processes import WorkerDied, pool_of
from assistant.cli.presentation import working

if TYPE_CHECKING:
    from assistant.compiler.merge_edits import Keeper

A = TypeVar("A")
B = TypeVar("B")
_SAME_FILE: Final = info(
    "CL001",
    "both `{first}` and `{second}` write `{name}`: each goes to a folder of its own",
    "rename one of the sources to have their files side by side",
)


@dataclass(slots=True)
class Outcomes:
    """refusals: why programs have no answer. status: the worst exit status so far."""

    refusals: list[Diagnostic] = field(default_factory=list)
    status: int = 0

    @contextmanager
    def of(self, program: str) -> Iterator[None]:
        """Turn refusals and failures inside into findings of one program; the others continue."""
        try:
            yield
        except Refused as refused:
            self.refusals += [f.within(program) for f in refused.findings]
            self.status = max(self.status, refused.exit_status)
        except OSError:
            raise
        except Exception as error:
            if traceback_wanted():
                raise
            self.refusals.append(internal_error(error).within(program))
            self.status = 2

    def of_each(
        self,
        function: Callable[[A], B],
        arguments: Sequence[tuple[str, A]],
        jobs: int | None,
        what: str,
    ) -> list[tuple[str, B]]:
        """Return programs and results, without those that have none; see `results_of`."""
        found: list[tuple[str, B]] = []
        for program, results, answers in results_of(function, arguments, jobs, what):
            found += [(program, result) for result in results]
            self.refusals += answers.refusals
            self.status = max(self.status, answers.status)
        return found


def results_of(
    function: Callable[[A], B], arguments: Sequence[tuple[str, A]], jobs: int | None, what: str
) -> Iterator[tuple[str, list[B], Outcomes]]:
    """Yield each program with the result of a module's function, or none, and its refusals.

    arguments: programs, with what the function is given for each. jobs: processes that share the
    work, None for the number that is usual. what: is said of a program on the terminal, such as
    `compiling`. Raises OSError where a file cannot be used.
    """
    pool = pool_of(len(arguments), jobs)
    given = [(function, program, argument) for program, argument in arguments]
    if pool is None:
        for one in given:
            with working(f"{what} {one[1]}"):
                answer = _answer_of(one)
            yield answer
        return
    with working(f"{what} {len(given)} programs"):
        answers = pool.answers(_answer_of, given, _lost)
    yield from answers


Answer = tuple[str, list[B], Outcomes]


def _answer_of(given: tuple[Callable[[A], B], str, A]) -> Answer[B]:
    """The result for a program, if there is one, and its refusals; also in a worker process."""
    function, program, argument = given
    answers, found = Outcomes(), list[B]()
    with answers.of(program):
        found.append(function(argument))
    return program, found, answers


def _lost(given: tuple[Callable[[A], B], str, A], died: WorkerDied) -> Answer[B]:
    program = given[1]
    return program, [], Outcomes([died.finding(path=program)], died.exit_status)


Files = Mapping[str, bytes]


def output_folders(files: Mapping[str, Files]) -> tuple[dict[str, str], list[Diagnostic]]:
    """Return a folder for each source that writes a file which another source writes too.

    files: by source, then by name. Folder names keep the sources distinct.
    """
    from assistant.program.program import identifier

    owner: dict[str, str] = {}
    told: list[Diagnostic] = []
    apart: dict[str, None] = {}
    for source, made in files.items():
        for name in made:
            other = owner.setdefault(name.lower(), source)
            if other != source:
                apart |= {other: None, source: None}
                told.append(_SAME_FILE(path=source, first=other, second=source, name=name))
    paths = {source: Path(source).absolute().with_suffix("") for source in apart}
    above = os.path.commonpath([path.parent for path in paths.values()]) if paths else ""
    folders: dict[str, str] = {}
    for source, path in paths.items():
        folders[source] = identifier("_".join(path.relative_to(above).parts), {*folders.values()})
    return folders, told


def write_outputs(
    files: Mapping[str, Files],
    folders: Mapping[str, str],
    output: str | Path,
    paths: Mapping[str, str],
) -> tuple[list[str], list[Diagnostic]]:
    """Write the files of all sources; a source that has its own folder is written there.

    paths: file that each source is, or begins with. Return the files, and a finding for each that
    was written from another source: nothing of such a source is written.
    """
    from assistant.compiler.merge_edits import replaced, with_sources, written_in

    wanted: dict[Path, bytes] = {}
    made: dict[Path, dict[str | Path, list[str]]] = {}
    told: list[Diagnostic] = []
    for source in sorted(files, key=lambda source: source in folders):  # those without one first
        memory = written_in(Path(output) / folders.get(source, ""))
        wished, path = (
            _files_by_path(source, files[source], folders, output),
            paths.get(source, source),
        )
        if others := replaced(wished, path, memory):
            told += others
            continue
        wanted |= wished
        made.setdefault(memory, {})[path] = [one.name for one in wished]
    written = [str(path) for path in wanted]
    for memory, sources in made.items():
        wanted |= with_sources(sources, memory)
    write_all(wanted)
    return written, told


def _files_by_path(
    source: str, files: Files, folders: Mapping[str, str], output: str | Path
) -> dict[Path, bytes]:
    """The files of one source by where they are written."""
    folder = Path(output) / folders.get(source, "")
    return {file_in_folder(name, folder): data for name, data in files.items()}


def output_paths(
    files: Mapping[str, Files], folders: Mapping[str, str], output: str | Path
) -> Sequence[Path]:
    """Return the paths that the files of all sources are written to."""
    return [
        Path(output) / folders.get(source, "") / name
        for source, made in files.items()
        for name in made
    ]


@dataclass(slots=True)
class WrittenFiles:
    """written: files, in order. findings: about edits. diffs: by file, of what was edited.

    refused: sources of which nothing is written.
    """

    written: list[str] = field(default_factory=list)
    findings: list[Diagnostic] = field(default_factory=list)
    diffs: dict[str, str] = field(default_factory=dict)
    refused: list[str] = field(default_factory=list)


def write_with_edits(
    files: Mapping[str, Files], folders: Mapping[str, str], output: str, keeper: Keeper
) -> WrittenFiles:
    """Writes the files of all sources, with what was edited in those that are there."""
    from assistant.compiler.merge_edits import Kept, replaced, with_sources, written_in

    done = WrittenFiles()
    wanted: dict[Path, bytes] = {}
    compiled: dict[Path, bytes] = {}
    made: dict[Path, dict[str | Path, list[str]]] = {}
    for source in sorted(files, key=lambda source: source in folders):
        memory = written_in(Path(output) / folders.get(source, ""))
        wished = _files_by_path(source, files[source], folders, output)
        others = [] if keeper.wishes.overwrite else replaced(wished, source, memory)
        kept = Kept({}, {}, findings=tuple(others)) if others else keeper.kept(wished, memory)
        done.findings += kept.findings
        if not kept.ok:
            done.refused.append(source)
            continue
        done.diffs |= {str(path): diff for path, diff in kept.diffs.items()}
        wanted |= kept.files
        compiled |= kept.compiled
        made.setdefault(memory, {})[source] = [path.name for path in wished]
    unknown = keeper.unknown_names()
    done.findings += unknown
    if wanted and not unknown:
        for memory, sources in made.items():
            compiled |= with_sources(sources, memory)
        write_all({**wanted, **compiled})
        done.written = [str(path) for path in wanted]
    return done
