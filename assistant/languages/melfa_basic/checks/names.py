"""Names and words: their form, what defines and uses them, and what a version does not have.

Rules of names that are misspelled, defined twice, defined nowhere or used nowhere, and of
statements, functions, status variables and forms that a version of the language lacks, with their
replacement.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Set
from typing import Final

import numpy as np

from assistant.base.diagnostics import Diagnostic
from assistant.languages.checks.names import NameSet, firsts, repeated, typing_distance
from assistant.languages.checks.registry import Found, Listing
from assistant.languages.melfa_basic import rules
from assistant.languages.melfa_basic.checks import values
from assistant.languages.melfa_basic.checks.file_view import (
    Known,
    Look,
    given_anywhere,
    is_position,
    known_variables,
    names_of,
)
from assistant.languages.melfa_basic.checks.flow import scope_parts
from assistant.languages.melfa_basic.tables import vocabulary
from assistant.languages.melfa_basic.tables.dialects import DIALECTS, PROGRAM_NAME
from assistant.languages.melfa_basic.text import printer
from assistant.languages.melfa_basic.tree import syntax as s
from assistant.languages.melfa_basic.tree.columnar import MoveRows, PositionRows
from assistant.languages.melfa_basic.tree.control_flow import labels_named
from assistant.languages.melfa_basic.tree.walk import (
    Use,
    declarations,
    literal,
    nodes,
    program_name,
    statements_in,
    word_of,
)
from assistant.languages.runs.columns import Names

# ---------------------------------------------------------------------------------- as written


def name_forms(look: Look) -> Found:
    """Names and labels are within the limits of the version."""
    most = look.dialect.longest
    long = (one for one in _named_things(look) if len(one[1]) > most and not _is_known(one[1]))
    for item, name, where in firsts(long, lambda one: one[1].upper()):
        yield look.at(rules.LONG_NAME, item, where, name=name, most=most)
    for line in look.lines if not look.dialect.label_underscores else ():
        if line.label is not None and "_" in line.label.upper().removeprefix("L_"):
            name, title = line.label, look.dialect.title
            yield look.at(rules.LABEL_FORM, line, f"*{name}", name=name, title=title)


def _named_things(look: Look) -> Iterator[tuple[s.Item, str, str]]:
    """Yield names with their item and their spelling there; the names in tables are short
    enough.
    """
    for line in look.lines:
        if line.label is not None:
            yield line, line.label, f"*{line.label}"
    for line, use in look.uses:
        yield line, use.variable.name, use.variable.name
    for item in look.tree.items:
        if isinstance(item, s.Data):
            yield item, item.variable.name, item.variable.name


def _is_known(name: str) -> bool:
    return vocabulary.status(name) is not None or vocabulary.function(name) is not None


def program_name_form(look: Look) -> Found:
    """The name of the file is the name that the controller stores the program by."""
    path = look.source.path if look.source else None
    name = program_name(look.tree)
    if not name or not path or not path.lower().endswith((".prg", ".mb4", ".mb5", ".mb6")):
        return
    first = next((line for line in look.lines if line.statement or line.label), None)
    if first is None:
        return  # a list of positions
    what, number = "", 4130
    if len(name) > PROGRAM_NAME:
        what, number = f"it has {len(name)} characters", 4120
    elif bad := re.search(r"[^A-Za-z0-9]", name):
        what = f"`{bad[0]}` is no letter and no digit"
    if what:
        yield look.finding(rules.PROGRAM_NAME, None, name=name, what=what, number=number)


# --------------------------------------------------------------------------------- definitions


def declared_twice(look: Look) -> Found:
    """Variables that are declared twice."""
    for scope in look.scopes:
        lines = look.lines_of(scope)
        declared = [(line, one) for line in lines for one, _ in declarations(line.statement)]
        for line, variable in repeated(declared, lambda one: one[1].key):
            yield look.at(rules.DECLARED_TWICE, line, variable)


_SETTING_COMMANDS: Final = ("Tool", "Base")


def undefined_variables(look: Look) -> Found:
    """Variables that are read, and moves to positions, that nothing gives a value."""
    # Lines or files that were not read may give any name a value.
    if look.has_strangers:
        return
    names = look.once(known_variables)
    moved = _plain_move_targets(look)
    seen: set[str] = set()
    for line, use in look.uses:
        variable, key = use.variable, use.variable.key
        if use.role != "read" or key in seen or is_call(look, variable):
            continue
        if key in names.given:
            continue
        seen.add(key)
        if key[1:2] == "_":
            stranger = key not in names.declared and vocabulary.status(key) is None
            if stranger and not _near_status(key) and key not in look.calls.once(given_anywhere):
                yield look.at(rules.NO_EXTERNAL, line, variable, name=variable.marked)
        elif variable.arguments is not None:
            if key not in names.dimensioned:
                yield look.at(rules.NO_DIM, line, variable, name=variable.marked)
        elif key in moved or re.fullmatch(r"[PJ][0-9]+", key):
            kind = "joint variable" if key[0] == "J" else "position"
            name = variable.name
            yield look.at(rules.NO_POSITION, line, name, kind=kind, name=name)
        else:
            yield look.at(rules.NO_VALUE, line, variable, name=variable.marked)


def is_call(look: Look, variable: s.Variable) -> bool:
    """True if a name, with or without arguments, is that of a function."""
    key = variable.key
    if vocabulary.function(key) is not None and variable.arguments is not None:
        return True
    return key in look.functions or key.startswith("FN") or key == "PLT"


def _plain_move_targets(look: Look) -> set[str]:
    """Plain variables that moves, tools and bases name."""
    found: set[str] = set()
    for _, motion in look.all(s.Motion):
        for node in nodes(motion.arguments):
            if isinstance(node, s.Variable) and node.key[0] in "PJ" and not node.component:
                found.add(node.key)
    for _, command in look.all(s.Command):
        if command.keyword in _SETTING_COMMANDS:
            found |= {n.key for n in nodes(command.arguments) if isinstance(n, s.Variable)}
    return found


def undefined_calls(look: Look) -> Found:
    """Functions of MELFA-BASIC VI that are called as a statement and are not there."""
    if look.has_strangers:
        return
    for line, call in look.all(s.Call):
        name = call.function.name
        if not is_call(look, call.function):
            yield look.at(rules.NO_CALL, line, name, name=name)


def _near_status(key: str) -> str:
    """The status variable that a name is one slip away from, empty for none."""
    # `M_01` and the like are external variables, not slips.
    if key[2:].isdigit():
        return ""
    for name, row in vocabulary.variables().items():
        if name[0] == key[0] and abs(len(name) - len(key)) <= 1 and len(name) > _SHORT_NAME:
            if typing_distance(name, key, 1) <= 1:
                return row.name
    return ""


_SHORT_NAME: Final = 4
"""Names so short that others are near them by chance."""


def stored_twice(look: Look) -> Found:
    """Variables with two lines of data; names in tables are there once."""
    items: dict[str, list[s.Data]] = {}
    for item in look.data:
        if isinstance(item, s.Data):
            items.setdefault(printer.expression(item.variable).upper(), []).append(item)
    for several in items.values():
        if len(several) > 1:
            last = several[-1]
            yield look.at(rules.TWO_POSITIONS, last, last.variable.name, name=last.variable.name)


# -------------------------------------------------------------------------------------- unused


def unused_names(look: Look) -> Found:
    """Labels, variables and positions that nothing uses; one finding for each of the three."""
    aimed = set(labels_named(look.lines))
    labels: Listing[s.Item] = Listing()
    for line in look.lines:
        label = (line.label or "").upper()
        # what begins with `L_` is shared with the programs on top of this one
        if label and label not in aimed and not label.startswith("L_"):
            labels.add(line, f"*{line.label}")
    yield from _listed_finding(look, "label", labels)
    names = look.once(known_variables)
    variables: Listing[s.Item] = Listing()
    told: set[str] = set()
    moved = _table_move_targets(look)
    for line, use in look.uses:
        key = use.variable.key
        written = use.role in ("written", "declared") and key not in told
        if written and _is_own(look, use, names) and key not in moved:
            told.add(key)
            variables.add(line, use.variable.marked)
    yield from _listed_finding(look, "variable", variables)
    yield from _unused_positions(look, _table_move_targets(look, names.read | told))


def _table_move_targets(look: Look, words: Set[str] = frozenset()) -> NameSet:
    """The positions that moves in tables name, and other words."""
    moved = NameSet()
    moved.words |= words
    for rows in look.code:
        if isinstance(rows, MoveRows):
            # -1 stands for a point that a move does not have.
            stem, points = rows.stem.encode("ascii"), (rows.end, rows.via, rows.start)
            moved.columns += [Names.numbered(stem, numbers[numbers >= 0]) for numbers in points]
    return moved


def _is_own(look: Look, use: Use, names: Known) -> bool:
    key = use.variable.key
    return (
        key not in names.read
        and key[1:2] != "_"
        and key not in look.functions
        and not isinstance(use.variable.arguments, tuple)
        and key not in names.dimensioned
    )


def _listed_finding(look: Look, what: str, found: Listing[s.Item]) -> Found:
    if found.first is None:
        return
    item, row = found.first
    words = {"what": f"the {what}s" if found.count > 1 else f"the {what}", **found.words}
    if isinstance(item, s.Line):
        yield look.at(rules.UNUSED, item, found.names[0].rstrip("$%&!#"), **words)
    else:
        where = look.row(item, row) if isinstance(item, PositionRows) else item
        yield look.finding(rules.UNUSED, where, **words)


def _unused_positions(look: Look, used: NameSet) -> Found:
    """Positions with a line that no statement names."""
    if not look.code:
        # A list of positions is there for other programs, which are not read here.
        return  # a list of positions for other programs
    found: Listing[s.Item] = Listing()
    for item in look.data:
        if isinstance(item, PositionRows):
            written = Names.numbered(item.stem.encode("ascii"), item.numbers)
            found.add_rows(item, np.flatnonzero(~used.among(names_of(item))), written.name)
        elif is_position(item) and not _is_shared(item.variable) and item.variable.key not in used:
            found.add(item, item.variable.name)
    yield from _listed_finding(look, "position", found)


def _is_shared(variable: s.Variable) -> bool:
    """True if other programs, or computed subscripts, may name a position."""
    return variable.key[1:2] == "_" or variable.arguments is not None


_LEVELS: Final = {dialect.level: dialect.title for dialect in DIALECTS.values()}
_JUMP_CURE: Final = "write `If … Then GoTo` over the lines"
_NEWER_VERSION_CURE: Final = "compile for a newer version of the language"


def missing_words(look: Look) -> Found:
    """Statements, functions, status variables and forms that the version lacks."""
    for line in look.lines:
        yield from _missing_statements(look, line)
        if line.label and line.statement and not look.dialect.labelled_statements:
            word = f"statement behind the label `*{line.label}`"
            yield _lacking_at(look, line, f"*{line.label}", word, "write it on a line of its own")
    yield from _breaks(look)
    for line, move in look.all(s.Motion):
        if move.type and literal(move.type[1]) == _SINGULAR and not look.dialect.singular_type:
            cure = "write `Type 0,1`, or move the points away from where axis 5 is 0"
            yield _lacking_at(look, line, "Type", "`Type` through singular points", cure)
    for line, command in look.all(s.Command):
        yield from _missing_forms(look, line, command)
    yield from _missing_functions(look)


_SINGULAR: Final = 2


def _lacking_at(
    look: Look, line: s.Entry, at: str | s.Variable, word: str, cure: str
) -> Diagnostic:
    title = look.dialect.title
    return look.at(
        rules.NOT_IN_DIALECT, line, at, title=title, word=word, cure=cure or _NEWER_VERSION_CURE
    )


def _missing_statements(look: Look, line: s.Line) -> Found:
    for statement in statements_in(line.statement):
        if isinstance(statement, s.If) and statement.then is None and not look.dialect.blocks:
            yield _lacking_at(look, line, "If", "`If` block", _JUMP_CURE)
        word = word_of(statement)
        at = word.removeprefix("Def ").removeprefix("#")
        if (row := vocabulary.statement(word)) is not None:
            yield from _missing_word(look, line, at, row.word, row)


def _missing_word(
    look: Look, line: s.Line, at: str | s.Variable, word: str, row: vocabulary.Row
) -> Found:
    """Report a word that not every version of the language has."""
    if look.dialect.level not in row.dialects:
        cure = f"write {row.instead}" if row.instead else _of_versions(row.dialects)
        yield _lacking_at(look, line, at, f"`{word}`", cure)


def _of_versions(levels: frozenset[int]) -> str:
    named = " and ".join(_LEVELS[level] for level in sorted(levels))
    return f"leave it out, or use the file with {named}"


def _breaks(look: Look) -> Found:
    """Break out of loops and branches, where a version has it for Select only."""
    if look.dialect.breaks:
        return
    for part in look.once(scope_parts):
        for at in part.scope.entries:
            line = look.code[at]
            breaks = line.statement == s.Command("Break")
            if breaks and not any(b.kind == "Select" for b in part.blocks.within(at)):
                cure = "write `GoTo` a label behind the block"
                yield _lacking_at(look, line, "Break", "`Break` out of loops", cure)


def _missing_forms(look: Look, line: s.Line, command: s.Command) -> Found:
    """Arguments of statements that came with a later version."""
    first = command.arguments[0] if command.arguments else None
    match command.keyword:
        case "Wait" if not look.dialect.wide_wait and not _is_narrow(first):
            cure = "wait in a loop: `*W` on one line, `If … = 0 Then GoTo *W` on the next"
            word = "`Wait` but for `variable = constant`"
            yield _lacking_at(look, line, "Wait", word, cure)
        case "Tool" | "Base" as word if not look.dialect.numbered_frames:
            if values.kind_of(look, first) == "M":
                yield _lacking_at(look, line, word, f"`{word}` with a number", "write a position")
        case "Fine" if not look.dialect.fine_distance and len(command.arguments) > 1:
            if isinstance(second := command.arguments[1], s.Variable) and second.key in ("P", "J"):
                yield _lacking_at(look, line, "Fine", "`Fine` with a distance", "write pulses")


def _is_narrow(condition: s.Expression | None) -> bool:
    """True for `variable = constant`, which every version can wait for."""
    match condition:
        case s.Binary("=", s.Variable(), constant):
            return literal(constant) is not None
    return False


def _missing_functions(look: Look) -> Found:
    """Report functions and status variables of other versions, and names that only look like status
    variables.
    """
    names = look.once(known_variables)
    seen: set[str] = set()
    for line, use in look.uses:
        variable = use.variable
        key = variable.key
        own = key in names.declared or key in look.functions
        if key in seen or own or use.role == "declared":
            continue
        row = vocabulary.known(key, called=variable.arguments is not None)
        lacks = list(_missing_word(look, line, variable, row.name, row)) if row else []
        if lacks:
            seen.add(key)
            yield from lacks
        elif variable.suffix and variable.suffix not in look.dialect.suffixes:
            seen.add(key)
            word = f"mark `{variable.suffix}` behind a name such as `{variable.marked}`"
            cure = f"write `{variable.name}#`, whose numbers reach further"
            yield _lacking_at(look, line, variable, word, cure)
        elif row is None and key[1:2] == "_" and key[0] in "MPJC":
            near = _near_status(key)
            if near and use.role == "read" and key not in names.given:
                seen.add(key)
                title, cure = look.dialect.title, f"write `{near}` if that is meant"
                yield look.at(values.UNKNOWN_STATUS, line, variable, title=title, cure=cure)
