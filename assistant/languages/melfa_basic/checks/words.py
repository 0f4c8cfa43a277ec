"""Rules of what a version of the language does not have, with what to write instead."""

from __future__ import annotations

from typing import Final

from assistant.base.diagnostics import Diagnostic
from assistant.languages.checks.registry import Found
from assistant.languages.melfa_basic import rules
from assistant.languages.melfa_basic.checks import kinds, value_rules
from assistant.languages.melfa_basic.checks.file_view import Look
from assistant.languages.melfa_basic.checks.flow import scope_parts
from assistant.languages.melfa_basic.checks.undefined import near_status
from assistant.languages.melfa_basic.checks.variables_of import known_variables
from assistant.languages.melfa_basic.tables import vocabulary
from assistant.languages.melfa_basic.tables.dialects import DIALECTS
from assistant.languages.melfa_basic.tree import syntax as s
from assistant.languages.melfa_basic.tree.walk import literal, statements_in, word_of

LEVELS: Final = {dialect.level: dialect.title for dialect in DIALECTS.values()}
JUMP_CURE: Final = "write `If … Then GoTo` over the lines"
NEWER_VERSION_CURE: Final = "compile for a newer version of the language"


def missing_words(look: Look) -> Found:
    """Statements, functions, status variables and forms that the version lacks."""
    for line in look.lines:
        yield from _missing_statements(look, line)
        if line.label and line.statement and not look.dialect.labelled_statements:
            word = f"statement behind the label `*{line.label}`"
            yield _lacking_at(look, line, f"*{line.label}", word, "write it on a line of its own")
    yield from _breaks(look)
    for line, move in look.all(s.Motion):
        if move.type and literal(move.type[1]) == SINGULAR and not look.dialect.singular_type:
            cure = "write `Type 0,1`, or move the points away from where axis 5 is 0"
            yield _lacking_at(look, line, "Type", "`Type` through singular points", cure)
    for line, command in look.all(s.Command):
        yield from _missing_forms(look, line, command)
    yield from _missing_functions(look)


SINGULAR: Final = 2


def _lacking_at(
    look: Look, line: s.Entry, at: str | s.Variable, word: str, cure: str
) -> Diagnostic:
    title = look.dialect.title
    return look.at(
        rules.NOT_IN_DIALECT, line, at, title=title, word=word, cure=cure or NEWER_VERSION_CURE
    )


def _missing_statements(look: Look, line: s.Line) -> Found:
    for statement in statements_in(line.statement):
        if isinstance(statement, s.If) and statement.then is None and not look.dialect.blocks:
            yield _lacking_at(look, line, "If", "`If` block", JUMP_CURE)
        word = word_of(statement)
        at = word.removeprefix("Def ").removeprefix("#")
        if (row := vocabulary.statement(word)) is not None:
            yield from _missing_word(look, line, at, row.word, row)


def _missing_word(
    look: Look, line: s.Line, at: str | s.Variable, word: str, row: vocabulary.Row
) -> Found:
    """What is found of a word that not every version has."""
    if look.dialect.level not in row.dialects:
        cure = f"write {row.instead}" if row.instead else _of_versions(row.dialects)
        yield _lacking_at(look, line, at, f"`{word}`", cure)


def _of_versions(levels: frozenset[int]) -> str:
    named = " and ".join(LEVELS[level] for level in sorted(levels))
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
            if kinds.kind_of(look, first) == "M":
                yield _lacking_at(look, line, word, f"`{word}` with a number", "write a position")
        case "Fine" if not look.dialect.fine_distance and len(command.arguments) > 1:
            if isinstance(second := command.arguments[1], s.Variable) and second.key in ("P", "J"):
                yield _lacking_at(look, line, "Fine", "`Fine` with a distance", "write pulses")


def _is_narrow(condition: s.Expression | None) -> bool:
    """Whether it is `variable = constant`, which every version waits for."""
    match condition:
        case s.Binary("=", s.Variable(), constant):
            return literal(constant) is not None
    return False


def _missing_functions(look: Look) -> Found:
    """Functions and status variables of other versions, and status variables that are none."""
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
            near = near_status(key)
            if near and use.role == "read" and key not in names.given:
                seen.add(key)
                title, cure = look.dialect.title, f"write `{near}` if that is meant"
                yield look.at(value_rules.UNKNOWN_STATUS, line, variable, title=title, cure=cure)
