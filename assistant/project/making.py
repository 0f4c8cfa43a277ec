"""Making programs of a project: each by itself, several at once in processes of their own."""

from __future__ import annotations

import contextlib
import os
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path as FilePath

from assistant import languages
from assistant.base.budgets import internal_error, traceback_wanted
from assistant.base.diagnostics import Diagnostic, Refused, has_errors
from assistant.base.source_text import read_bytes
from assistant.compiler import compile
from assistant.compiler.arms import open_cell, robot_of
from assistant.compiler.combine import combine_sources
from assistant.compiler.loader import language_of, load, read_trees
from assistant.compiler.motion_proof import Proving
from assistant.compiler.style import style_of
from assistant.findings.severities import apply_severities
from assistant.languages import Tree
from assistant.program.settings_tables import listed
from assistant.project import rules
from assistant.project.inputs import Digests, digests, recorded_inputs
from assistant.project.layout import Place, Recipe
from assistant.project.workers import at_once
from assistant.sources import PROCESS_SUFFIX, READERS
from assistant.sources.project_file import PROJECT_FILES


@dataclass(frozen=True, slots=True)
class BuildOrder:
    """A program that is wanted: of a recipe, for a controller that takes these languages.

    folder: of the project. robot: of the controller, if the recipe names none.
    """

    folder: FilePath
    recipe: Recipe
    taken: tuple[str, ...]
    robot: str | None = None

    @property
    def arm(self) -> str | None:
        return self.recipe.robot or self.robot


@dataclass(frozen=True, slots=True)
class MadeProgram:
    """A program that was made.

    files: bytes by name, empty if anything forbids them. inputs: what they were made of. origins:
    source of each file that was taken as it is, from the project's folder. proof: a line each.
    unreadable: whether something could not be read at all. language: of the files, empty without.
    """

    files: Mapping[str, bytes] = field(default_factory=dict)
    inputs: Digests = field(default_factory=dict)
    origins: Mapping[str, str] = field(default_factory=dict)
    findings: tuple[Diagnostic, ...] = ()
    proof: tuple[str, ...] = ()
    unreadable: bool = False
    language: str = ""


def order_of(folder: FilePath, place: Place, recipe: Recipe) -> BuildOrder:
    return BuildOrder(folder, recipe, place.languages, place.controller.robot)


def make_all(
    orders: Sequence[BuildOrder], jobs: int | None = None
) -> dict[BuildOrder, MadeProgram]:
    """Makes each, with at most so many processes; default as many as there are processors."""
    wanted = list(dict.fromkeys(orders))
    count = min(len(wanted), jobs or os.cpu_count() or 1)
    if count <= 1:
        return {order: make_program(order) for order in wanted}
    return dict(zip(wanted, at_once(make_program, wanted, count, _died), strict=True))


def _died(order: BuildOrder) -> MadeProgram:
    name = order.recipe.name
    return MadeProgram(findings=(rules.DIED(place=name, name=name),), unreadable=True)


def make_program(order: BuildOrder) -> MadeProgram:
    """Makes one; what is refused, or fails, is in its findings."""
    name = shown_path(order.recipe.source)
    with recorded_inputs(order.folder) as opened:
        made = _make_or_refuse(order, name)
    # What the project's own file says of the style is in the digest of what is wanted.
    inputs = digests(order.folder, (opened | set(_looked_for(order))) - set(PROJECT_FILES))
    found = apply_severities([finding.within(name) for finding in made.findings]).left
    files = {} if has_errors(found) else made.files
    return replace(made, inputs=inputs, findings=found, files=files)


def shown_path(path: FilePath) -> str:
    """From the working folder, if it is in it."""
    with contextlib.suppress(ValueError, OSError):
        return str(path.relative_to(FilePath.cwd()))
    return str(path)


def _looked_for(order: BuildOrder) -> Iterator[str]:
    """Files that change what is made by being there; who only looks for them opens nothing."""
    recipe, folder = order.recipe, order.folder
    beside = recipe.source.with_suffix(PROCESS_SUFFIX)
    others = (file for one in recipe.also for file in (one, one.with_suffix(PROCESS_SUFFIX)))
    for file in (recipe.source, recipe.process or beside, recipe.signals, recipe.cell, *others):
        if file is not None:
            yield file.relative_to(folder).as_posix()


def _make_or_refuse(order: BuildOrder, name: str) -> MadeProgram:
    try:
        return _copied_source(order, name) or _compile_order(order, name)
    except Refused as refused:
        return MadeProgram(findings=refused.findings, unreadable=refused.exit_status == 2)
    except OSError as error:
        reason = error.strerror or str(error)
        finding = rules.NOT_KEPT(file=error.filename or name, reason=reason)
        return MadeProgram(findings=(finding,), unreadable=True)
    except Exception as error:
        if traceback_wanted():
            raise
        return MadeProgram(findings=(internal_error(error),), unreadable=True)


def _source_language(recipe: Recipe) -> str | None:
    """The robot language of a source, None for drawings, tables and pseudo-programs."""
    if recipe.from_language is not None:
        return recipe.from_language
    if recipe.source.suffix.lower() in READERS:
        return None
    spoken = languages.of_file(recipe.source, read_bytes(recipe.source))
    return None if spoken is None else spoken.name


def chosen_language(order: BuildOrder) -> str:
    """What a program is made in; raises Refused if nobody says it."""
    return _output_language(order, _source_language(order.recipe))


def _output_language(order: BuildOrder, spoken: str | None) -> str:
    """What the program is to be in; raises Refused if nobody says it."""
    if order.recipe.language is not None:
        return order.recipe.language
    arm = robot_of(order.arm)
    runs = order.taken if arm is None else tuple(x for x in arm.languages if x in order.taken)
    if spoken in (runs or order.taken):
        return str(spoken)
    if len(order.taken) == 1:
        return order.taken[0]
    if arm is None or not runs:
        finding = rules.OPEN_LANGUAGE(name=order.recipe.name, taken=listed(order.taken))
        raise Refused(finding)
    return runs[0]


def _copied_source(order: BuildOrder, name: str) -> MadeProgram | None:
    """A source that is already what is wanted, with the files that it calls; None for others."""
    recipe = order.recipe
    spoken = _source_language(recipe)
    plain = Recipe(recipe.name, recipe.source, recipe.language, recipe.robot, from_language=spoken)
    if spoken is None or replace(recipe, from_language=spoken) != plain:
        return None
    if _output_language(order, spoken) != spoken:
        return None
    language = language_of(spoken)
    trees: Sequence[Tree] = read_trees(
        language, [language.read(name)], beside=FilePath(name).parent
    )
    found = tuple(finding for tree in trees for finding in tree.findings)
    files: dict[str, bytes] = {}
    origins: dict[str, str] = {}
    for path in map(FilePath, _tree_paths(trees)):
        if not path.resolve().is_relative_to(order.folder.resolve()):
            found = (*found, rules.NOT_BESIDE(path=name, file=path))
            continue
        files[path.name] = read_bytes(path)
        beside = recipe.source.parent / path.name
        origins[path.name] = beside.relative_to(order.folder).as_posix()
    return MadeProgram(files, origins=origins, findings=found, language=spoken)


def _tree_paths(trees: Sequence[Tree]) -> Iterator[str]:
    for tree in trees:
        if tree.source is not None and tree.source.path is not None:
            yield tree.source.path


def _compile_order(order: BuildOrder, name: str) -> MadeProgram:
    recipe = order.recipe
    spoken = _source_language(recipe)
    source = name
    given = None
    if recipe.from_language is not None:
        given = load(
            source,
            process=_shown_or_none(recipe.process),
            robot=robot_of(recipe.from_robot),
            language=recipe.from_language,
            unit=recipe.unit,
        )
    if recipe.also:
        given = combine_sources(
            [source, *map(shown_path, recipe.also)],
            recipe.name,
            process=_shown_or_none(recipe.process),
            unit=recipe.unit,
            around=open_cell(_shown_or_none(recipe.cell), robot_of(order.arm)).around,
        )
    script = _shown_or_none(recipe.signals)
    language = _output_language(order, spoken)
    compiled = compile(
        given or source,
        language=language,
        robot=robot_of(order.arm),
        process=_shown_or_none(recipe.process),
        unit=recipe.unit,
        cell=_shown_or_none(recipe.cell),
        from_robot=recipe.from_robot,
        most_targets=recipe.most_targets,
        frames=recipe.frames,
        entry=recipe.entry,
        called=recipe.called,
        main=recipe.main,
        proving=Proving(script=script, seed=recipe.seed) if recipe.prove else None,
        style=style_of(order.folder),
    )
    files = compiled.files if compiled.ok else {}
    proof = tuple(compiled.proof_lines())
    return MadeProgram(files, findings=compiled.findings, proof=proof, language=language)


def _shown_or_none(path: FilePath | None) -> str | None:
    return None if path is None else shown_path(path)
