"""Simulated runs: the programs that run together, and scripts of inputs and answers, as TOML.

Times are seconds of the run. Signals are named in any case, or by their number.

    [[set]]
    input = "diPart"          # or a number
    value = 1                 # a number, true or false; 1 if left out
    at = 2.5                  # 0 if left out
    for = 0.5                 # then it is what it was before
    every = 10                # again and again

    [[set]]
    input = "diClosed"
    value = 1
    when = "doGrip = 1"       # each time that this output gets this value; or "input NAME = VALUE",
                              # "visit 3 of pPick", "visit pPick" (each), "visit 3" (of the run)
    after = 0.3               # 0 if left out

    [[answer]]
    to = "How many"           # a part of the question, in any case; any if left out
    value = "12"              # a text or a number: what is typed in, or the key that is pressed
    after = 3                 # 0 if left out
    always = false            # true: to each such question, not only to the next one

    [options]                 # what the manuals of the language leave open
    quotients = "zero"
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import replace
from pathlib import Path as FilePath
from typing import TYPE_CHECKING, Any, Final

from assistant import languages, sources
from assistant.base.budgets import SETTINGS_FILE
from assistant.base.diagnostics import Diagnostic, Refused, Severity, error, has_errors, warning
from assistant.base.near_names import near_name
from assistant.base.source_text import SourceText, decode, is_folder, lines_of, read_bytes
from assistant.compiler.arms import Arms, teaching_arm
from assistant.compiler.cell_defaults import with_tree_values
from assistant.compiler.cell_equipment import controller_configuration
from assistant.compiler.loader import (
    language_of,
    load,
    load_text,
    read_companions,
    read_pseudo,
    read_trees,
    with_entry,
)
from assistant.compiler.program_files import programs_in
from assistant.compiler.retarget import for_arm
from assistant.compiler.seen_frames import with_located_frames
from assistant.program import pseudo, settings_tables
from assistant.program.settings_tables import (
    ENCODINGS,
    Read,
    Table,
    Wrong,
    kind_of,
    read_toml,
    shown,
)
from assistant.sources.cell_values import NO_CELL, read_cell
from assistant.sources.sights import NOTHING_SEEN, Seeing
from assistant.virtual.kernel.script import Answer, Change, Script, Visit, When, words_of
from assistant.virtual.tasks import Group, Part, Programs, groups

if TYPE_CHECKING:
    from assistant.languages import Language, Tree
    from assistant.robots import Robot
    from assistant.sources.process.placement import DrawingPlacement


_RUN_ALONE_ONLY: Final = error(
    "CO021", "`{name}` is run by itself, beside no other program", "name it alone"
)
_MIXED_LANGUAGES: Final = error(
    "CO022",
    "`{name}` is written in {language}, `{first}` in {other}",
    "name programs of one language: one controller runs them",
)
_OPTION_OF_SOURCES: Final = error(
    "CO023",
    "--{option} is for drawings, tables and pseudo-programs, `{name}` is a robot program",
    "leave it out",
)


def programs(
    named: Sequence[str],
    *,
    language: str | None = None,
    robot: Robot | None = None,
    process: str | FilePath | None = None,
    unit: str | None = None,
    entry: str | None = None,
    placement: DrawingPlacement | None = None,
    cell: str | FilePath | None = None,
    seeing: Seeing = NOTHING_SEEN,
) -> Programs:
    """Return the programs of files and folders that run together on one controller.

    named: a drawing, table or pseudo-program; or robot programs of one language, or a folder with
    them. language: of robot programs, if neither suffix nor text identifies it. robot, process,
    unit, placement: see `load`, for other sources. entry: the procedure that a pseudo-program
    begins with. cell: file of what robot programs use and do not declare. seeing: source of its
    frames located by cameras. Raises Unreadable or Refused.
    """
    title = ", ".join(named)
    folder = named[0] if is_folder(named[0]) else None
    if len(named) > 1:
        for name in named:
            if is_folder(name) or _is_source(name):
                raise Refused(_RUN_ALONE_ONLY(path=name, name=name), exit_status=2)
    elif folder is None and _is_source(named[0], language):
        loaded = load(named[0], process=process, robot=robot, unit=unit, placement=placement)
        is_text = FilePath(named[0]).suffix.lower() == pseudo.SUFFIX
        program = with_entry(loaded.program, entry)
        text = read_pseudo(named[0]) if is_text else None
        program, sights = with_located_frames(
            program, Arms(robot, seeing=seeing.beside(loaded.seen))
        )
        found = (*loaded.findings, *sights)
        return _program_for_arm(Programs(title, program=program, text=text), found, robot)
    for option, value in (("process", process), ("unit", unit), ("place", placement)):
        if value is not None:
            raise Refused(
                _OPTION_OF_SOURCES(path=named[0], option=option, name=named[0]), exit_status=2
            )
    files = list(programs_in(folder, language)) if folder else list(dict.fromkeys(named))
    spoken = _one_language(files, language)
    parts = [_run_part(spoken, group) for group in groups(spoken, files, folder)]
    return _in_cell(Programs(title, spoken, tuple(parts)), files[0], cell)


def _in_cell(made: Programs, file: str, cell: str | FilePath | None) -> Programs:
    """Robot programs with what the files of their controller, and a cell file, state."""
    spoken = made.language
    assert spoken is not None
    given, found = controller_configuration(spoken, file)
    stated = NO_CELL if cell is None else read_cell(cell)
    signals = {**given.signals, **stated.process.signals}
    parts = []
    for part in made.parts:
        trees = with_tree_values(spoken, part.trees, given, stated)
        part = replace(part, trees=tuple(trees))
        parts.append(part)
        with suppress(Refused):  # told by whoever translates the program
            if any(
                _SIGNAL_HEADING in (tree.source.text if tree.source else "") for tree in part.trees
            ):
                signals = {**spoken.lift(part.trees).signals, **signals}
    missing = (finding for part in parts for finding in spoken.missing(part.trees))
    return replace(made, parts=tuple(parts), findings=(*found, *missing), stated=signals)


_SIGNAL_HEADING: Final = "signal: "
"""In the heading of a program that names its signals."""


def programs_of_text(
    text: SourceText,
    *,
    language: str | None = None,
    robot: Robot | None = None,
    entry: str | None = None,
    seeing: Seeing = NOTHING_SEEN,
) -> Programs:
    """Return the programs of a text that is not a file: in a robot language if named, else pseudo
    text.
    """
    title = text.path or "standard input"
    if language is None:
        program = with_entry(load_text(text).program, entry)
        program, sights = with_located_frames(program, Arms(robot, seeing=seeing))
        return _program_for_arm(Programs(title, program=program, text=text), sights, robot)
    spoken = language_of(language)
    tree = spoken.parse(text)
    _refuse_errors([tree])
    (group,) = groups(spoken, [title], None)
    part = Part(group.name, (tree,), (title,))
    return Programs(title, spoken, (part,), findings=tuple(spoken.missing([tree])))


def _program_for_arm(
    made: Programs, findings: Sequence[Diagnostic], robot: Robot | None
) -> Programs:
    """A pseudo-program as another arm runs it than the one that it was taught on."""
    assert made.program is not None
    program = made.program
    if robot is None:
        return replace(made, findings=tuple(findings))
    program, changed = for_arm(program, teaching_arm(program, Arms(robot)), robot)
    if has_errors(changed):
        raise Refused(*(f.within(made.title) for f in changed if f.severity is Severity.ERROR))
    return replace(made, program=program, findings=(*findings, *changed))


def _is_source(name: str, language: str | None = None) -> bool:
    suffix = FilePath(name).suffix.lower()
    if language is not None:
        return False
    if suffix == pseudo.SUFFIX or suffix in sources.READERS:
        return True
    # What is no robot program is to be said as for any source that cannot be read.
    return not is_folder(name) and languages.of_file(name, read_bytes(name)) is None


def _one_language(files: Sequence[str], named: str | None) -> Language[Any]:
    """The language of all files; raises Refused if there are two."""
    first: tuple[str, Language[Any]] | None = None
    for file in files:
        spoken = language_of(named) if named else languages.of_file(file, read_bytes(file))
        if spoken is None:
            raise Refused(_RUN_ALONE_ONLY(path=file, name=file), exit_status=2)
        if first is not None and spoken.family != first[1].family:
            raise Refused(
                _MIXED_LANGUAGES(
                    path=file,
                    name=FilePath(file).name,
                    language=spoken.title,
                    first=FilePath(first[0]).name,
                    other=first[1].title,
                ),
                exit_status=2,
            )
        first = first or (file, spoken)
    assert first is not None
    return first[1]


def _run_part(spoken: Language[Any], group: Group) -> Part:
    """Raises Refused where one of the files has errors."""
    texts = [spoken.read(file) for file in group.files]
    folder = FilePath(group.files[0]).parent if group.beside else None
    trees = read_trees(spoken, texts, beside=folder)
    if folder is not None:
        # Companions may be named as well: each file runs once.
        known = {_tree_path(tree) for tree in trees}
        trees += [t for t in read_companions(spoken, trees, folder) if _tree_path(t) not in known]
    _refuse_errors(trees)
    names = tuple(_tree_path(tree).stem for tree in trees)
    return Part(group.name, tuple(trees), names, group.essential)


def _tree_path(tree: Tree) -> FilePath:
    return FilePath((tree.source.path if tree.source else None) or "")


def _refuse_errors(trees: Sequence[Tree]) -> None:
    found: list[Diagnostic] = [f for tree in trees for f in tree.findings]
    if has_errors(found):
        raise Refused(*(f for f in found if f.severity is Severity.ERROR))


_SCRIPT_NO_ROWS: Final = error(
    "CO031", "`{key}` is {what}, not rows", "write [[{key}]] above each of them"
)
_SCRIPT_KEY_MISSING: Final = error("CO032", "the {row} states no `{key}`", "write `{example}`")
_SCRIPT_KEYS_EXCLUSIVE: Final = error(
    "CO033", "`{key}` and `{other}` do not go together", "keep one of them, or write two rows"
)
_SCRIPT_PULSE_TOO_LONG: Final = error(
    "CO034", "it lasts {lasts:g} s and comes again every {every:g} s", "write a shorter `for`"
)

_VISIT_NOT_IN_PROGRAM: Final = warning(
    "CO126",
    "the script changes `{name}` at a visit of `{target}`, which no statement names",
    "{cure}",
)

_WHEN: Final = re.compile(r"\s*(?:(input|output)\s+)?([A-Za-z]\w*|\d+)\s*=\s*(\S+)\s*", re.I)
_VISIT: Final = re.compile(
    r"\s*visit\s+(?:(\d{1,9})(?:\s+of\s+([A-Za-z_]\w*))?|([A-Za-z_]\w*))\s*", re.I
)
_SIGNAL: Final = re.compile(r"[A-Za-z]\w*|\d+")
_TRUTHS: Final = {"true": 1.0, "false": 0.0, "high": 1.0, "low": 0.0}
_MOST_SECONDS: Final = 1e9
_MOST_TYPED: Final = 1e15
"""A number of more digits than are kept is typed in as a text."""


def _read_signal(value: Any) -> str:
    if isinstance(value, int) and not isinstance(value, bool) and value >= 0:
        return str(value)
    name = settings_tables.text(value).strip()
    if _SIGNAL.fullmatch(name) is None:
        raise Wrong(f'is "{shown(name)}"', "write the name of a signal, or its number")
    return _signal_key(name)


def _signal_key(name: str) -> str:
    return str(int(name)) if name.isdecimal() else name.lower()


def _read_value(value: Any) -> float:
    if isinstance(value, bool):
        return float(value)
    found: float = settings_tables.number(
        "", least=-settings_tables.MOST_VALUE, most=settings_tables.MOST_VALUE
    )(value)
    return found


def _read_when(value: Any) -> When | Visit:
    cure = 'write "NAME = VALUE" of an output, "input NAME = VALUE", or "visit 3 of NAME"'
    text = settings_tables.text(value)
    visit = _VISIT.fullmatch(text)
    if visit is not None:
        if visit[1] is not None and int(visit[1]) == 0:
            raise Wrong(f'is "{shown(text)}"', "count visits from 1")
        place = (visit[2] or visit[3] or "").lower()
        return Visit(place, None if visit[1] is None else int(visit[1]))
    found = _WHEN.fullmatch(text)
    if found is None:
        raise Wrong(f'is "{shown(text)}"', cure)
    wanted = _TRUTHS.get(found[3].lower())
    try:
        number = _read_value(float(found[3]) if wanted is None else wanted)
    except ValueError:
        raise Wrong(f'is "{shown(text)}"', cure) from None
    return When(_signal_key(found[2]), number, (found[1] or "").lower() == "input")


def _read_answer(value: Any) -> str:
    if isinstance(value, bool) or not isinstance(value, str | int | float):
        raise Wrong(f"is {kind_of(value)}", "write a text in quotes, or a number")
    if not isinstance(value, str) and not abs(value) < _MOST_TYPED:
        raise Wrong("is a number that nobody types in", "write it as a text in quotes")
    return value if isinstance(value, str) else f"{value:.15g}"


def _read_text(value: Any) -> str:
    if not isinstance(value, str):
        raise Wrong(f"is {kind_of(value)}", "write a text in quotes")
    return value


_SECONDS: Final = settings_tables.number("seconds", least=0.0, most=_MOST_SECONDS)
_SOME_SECONDS: Final = settings_tables.number("seconds", above=0.0, most=_MOST_SECONDS)

CHANGE_KEYS: Final[Mapping[str, Read]] = {
    "input": _read_signal,
    "value": _read_value,
    "at": _SECONDS,
    "when": _read_when,
    "after": _SECONDS,
    "for": _SOME_SECONDS,
    "every": _SOME_SECONDS,
}
ANSWER_KEYS: Final[Mapping[str, Read]] = {
    "to": _read_text,
    "value": _read_answer,
    "after": _SECONDS,
    "always": settings_tables.truth,
}


def _read_unchanged(value: Any) -> Any:
    return value


def _read_options(value: Any) -> Any:
    if not isinstance(value, dict):
        raise Wrong(f"is {kind_of(value)}", "write [options] above its keys")
    return value


SCRIPT_KEYS: Final[Mapping[str, Read]] = {
    "set": _read_unchanged,
    "answer": _read_unchanged,
    "options": _read_options,
}


def unknown_visits(script: Script, sources: Sequence[SourceText]) -> Iterator[Diagnostic]:
    """Findings on visits of a script that no text of the programs names."""
    names = {word for one in sources for line in lines_of(one.text) for word in words_of(line)}
    for change in script.changes:
        place = change.when.place if isinstance(change.when, Visit) else ""
        if not place or place in names:
            continue
        near = near_name(place, names)
        cure = f"write `{near}`" if near else "write the name of a target as the program has it"
        if not sources:
            cure = "write the number of the visit, as `visit 3`: no text names targets"
        yield _VISIT_NOT_IN_PROGRAM(name=change.name, target=place, cure=cure)


def read_script(path: str | FilePath) -> Script:
    """Read a script; raise Unreadable if it is not TOML, Refused for errors in it."""
    return parse_script(decode(read_bytes(path, most=SETTINGS_FILE), str(path), ENCODINGS))


def parse_script(source: SourceText) -> Script:
    """Parse the text of a script, like `read_script`."""
    top = read_toml(source)
    options = top.read(SCRIPT_KEYS).get("options", {})
    changes = [_change_of(row) for row in _script_rows(top, "set")]
    answers = [_answer_of(row) for row in _script_rows(top, "answer")]
    findings = sorted(top.page.findings, key=lambda f: f.line or 0)
    if has_errors(findings):
        raise Refused(*findings, exit_status=2)
    return Script(tuple(changes), tuple(answers), options)


def _script_rows(top: Table, key: str) -> Iterator[Table]:
    rows = top.content.get(key, [])
    if not isinstance(rows, list) or not all(isinstance(row, dict) for row in rows):
        top.say(_SCRIPT_NO_ROWS, key, key=key, what=kind_of(rows))
        return
    for number, row in enumerate(rows):
        yield Table(top.page, (key, str(number)), row)


def _change_of(row: Table) -> Change:
    found = row.read(CHANGE_KEYS)
    if "input" not in row.content:
        row.say(_SCRIPT_KEY_MISSING, row="change", key="input", example='input = "diPart"')
    for key, other in (("at", "when"), ("every", "when")):
        if key in row.content and other in row.content:
            row.say(_SCRIPT_KEYS_EXCLUSIVE, key, key=key, other=other)
    if "after" in row.content and "when" not in row.content:
        row.say(
            _SCRIPT_KEY_MISSING, "after", row="change", key="when", example='when = "doGrip = 1"'
        )
    lasts, every = found.get("for"), found.get("every")
    if lasts is not None and every is not None and lasts >= every:
        row.say(_SCRIPT_PULSE_TOO_LONG, "for", lasts=lasts, every=every)
    return Change(
        name=found.get("input", ""),
        value=found.get("value", 1.0),
        at=found.get("at", 0.0),
        when=found.get("when"),
        after=found.get("after", 0.0),
        lasts=lasts,
        every=every,
    )


def _answer_of(row: Table) -> Answer:
    found = row.read(ANSWER_KEYS)
    if "value" not in row.content:
        row.say(_SCRIPT_KEY_MISSING, row="answer", key="value", example='value = "OK"')
    return Answer(
        value=found.get("value", ""),
        to=found.get("to", ""),
        after=found.get("after", 0.0),
        always=found.get("always", False),
    )
