"""What each line does to settings, and which of them it depends on."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Final

from assistant.base.arrays import Ints
from assistant.languages.melfa_basic.lift.settings.held import (
    ALL_SETTINGS,
    FRAME,
    JOINT,
    TCP,
    TOOL,
    Settings,
)
from assistant.languages.melfa_basic.lift.settings.interrupts import interrupts_of
from assistant.languages.melfa_basic.lift.structure.answers import Answers
from assistant.languages.melfa_basic.lift.structure.blocks import Code, Structure
from assistant.languages.melfa_basic.lift.structure.regions import Region, odd_entries, target_name
from assistant.languages.melfa_basic.lift.values.constants import Constants, changed_variables
from assistant.languages.melfa_basic.tables.vocabulary import commands
from assistant.languages.melfa_basic.tree import syntax as s
from assistant.languages.melfa_basic.tree.blocks import is_block_word, statement_of
from assistant.languages.melfa_basic.tree.columnar import MOV, MoveRows
from assistant.languages.melfa_basic.tree.targets import exits_of, graph_of, labels_of
from assistant.languages.melfa_basic.tree.walk import nodes, program_stem, statements_in
from assistant.languages.settings.flow import (
    Calls,
    Changes,
    Computed,
    Either,
    LineEffects,
    Sets,
    Steps,
    calls_in,
    with_interrupts,
)
from assistant.languages.settings.forms import CalledForms
from assistant.program.program import identifier

NO_NAMES: Final = frozenset[str]()
_WAIT_LABELS: Final = re.compile(r"W\d+Z?", re.IGNORECASE)
"""Labels that are read together with the lines around them."""


@dataclass(frozen=True)
class SettingFlow:
    """What the code is, however its settings are said: the same in each reading of a file.

    single: see `paths.used_once`. breaks: whether it asks if something was left by `Break`.
    """

    constants: Constants
    structure: Structure
    regions: list[Region]
    settings: Settings
    called: CalledForms
    single: Mapping[str, Ints]
    timers: dict[int, str]
    breaks: bool


def setting_lines(
    code: Code,
    structure: Structure,
    regions: Sequence[Region],
    settings: Settings,
    touched: Mapping[str, frozenset[int]],
    elsewhere: frozenset[int],
    answers: Answers,
) -> LineEffects:
    """touched: the settings that each program sets, by its name in upper case. elsewhere: those
    that interrupts of the programs that call this one may set while it runs. answers: what those of
    this one call.
    """
    blocks, labels = structure.blocks, labels_of(code)
    by_label = {region.label: k for k, region in enumerate(regions) if region.label}
    by_name = {r.function.name.upper(): k for k, r in enumerate(regions) if r.function}

    def called(statement: s.Statement | None) -> Iterator[int | frozenset[int]]:
        match statement:
            case s.CallP(program=s.String(value=name)):
                yield touched.get(identifier(program_stem(name)).upper(), ALL_SETTINGS)
            case s.CallP():
                yield ALL_SETTINGS
            case s.Jump() | s.OnJump():
                for target in exits_of(statement).calls:
                    yield by_label.get(target_name(target), ALL_SETTINGS)
        if by_name:
            node = statement.condition if isinstance(statement, s.If) else statement
            for part in nodes(node):
                if isinstance(part, s.Variable) and part.key in by_name:
                    if part is not getattr(statement, "target", None):
                        yield by_name[part.key]

    watched = _setting_variables(code, settings)

    def steps(statement: s.Statement | s.Target | None, own: frozenset[str] = NO_NAMES) -> Steps:
        """own: variables of its function alone, which nothing that it calls can change."""
        if statement is None or isinstance(statement, s.Target):
            return ()
        made = does(statement)
        if not watched or (len(made) == 1 and isinstance(made[0], Sets)):
            return made
        if any(True for _ in calls_in(made)):
            named = frozenset(x.key for x in nodes(statement) if isinstance(x, s.Variable))
            any_other = Changes(None, own - named)
            return (any_other, *made, any_other)
        names = watched.intersection(changed_variables(statement, settings.constants.kept))
        return (*made, Changes(frozenset(names))) if names else made

    def does(statement: s.Statement) -> Steps:
        effect = settings.effect(statement)
        if effect is not None:
            return (Sets(*effect),)
        calls = tuple(called(statement))
        inside = isinstance(statement, s.Jump | s.OnJump)
        if isinstance(statement, s.OnJump):
            return (Either((*((Calls((one,), inside),) for one in calls), ())),)
        before: Steps = (Calls(calls, inside),) if calls else ()
        if isinstance(statement, s.If) and statement.then is not None:
            return (*before, Either((steps(statement.then), steps(statement.otherwise))))
        if isinstance(statement, s.Motion) and statement.append is not None:
            return (*before, Either((steps(statement.append.statement), ())))
        return before

    places = [region.places() for region in regions]
    calls = {
        k: {one for at in inside for one in called(statement_of(code[at]))}
        for k, inside in enumerate(places if watched else ())
    }

    def own(number: int) -> frozenset[str]:
        """Parameters of a function by value, while it does not run twice at once."""
        function, names = regions[number].function, NO_NAMES
        if watched and function is not None and number not in _reached_calls(number, calls):
            given = function.parameters or ()
            names = watched & {f"{q.name}{q.suffix}".upper() for q in given if q.mode == "ByVal"}
        return names

    loose = {
        at for at, item in enumerate(code)
        if is_block_word(statement_of(item)) and at not in blocks.words
    }  # fmt: skip
    first = {label: places[number][0] for label, number in by_label.items() if places[number]}
    entries = labels | first
    for label, (call, _) in answers.items():
        number = by_name.get(call.function.key) if isinstance(call, s.Call) else None
        if isinstance(call, s.Jump):
            number = by_label.get(target_name(call.target))
        if number is not None and places[number]:
            entries[label] = places[number][0]
    lines = LineEffects(
        len(ALL_SETTINGS),
        places,
        [graph_of(code, inside, blocks).after for inside in places],
        {
            at: made
            for inside, kept in zip(places, map(own, range(len(places))), strict=True)
            for at in inside
            if (made := steps(statement_of(code[at]), kept))
        },
        lambda at: _used_settings(code[at]),
        lambda at: exits_of(statement_of(code[at])).on,
        frozenset(labels.values()),
        frozenset(at for at, depth in enumerate(structure.depth) if depth)
        | {at for label, at in labels.items() if _WAIT_LABELS.fullmatch(label)},
        frozenset(loose | {entries[to] for to in odd_entries(code, regions) if to in entries}),
    )
    answering = {region.label: k for k, region in enumerate(regions) if region.answers}
    found = interrupts_of(code, entries, {label: k for label, k in answering.items() if label})
    return with_interrupts(lines, found, elsewhere)


def _reached_calls(number: int, calls: Mapping[int, set[int | frozenset[int]]]) -> set[int]:
    """What a procedure calls, with all that this calls; everything where that is not known."""
    pending, found = [*calls[number]], set[int]()
    while pending:
        one = pending.pop()
        if not isinstance(one, int):
            return set(calls)
        if one not in found:
            found.add(one)
            pending += calls[one]
    return found


def _setting_variables(code: Code, settings: Settings) -> frozenset[str]:
    """Variables that values of settings are worked out of, in upper case."""
    effects = (settings.effect(one) for item in code for one in statements_in(statement_of(item)))
    values = [effect[1] for effect in effects if effect is not None]
    return frozenset().union(*(one.names for one in values if isinstance(one, Computed)))


_READ_SETTINGS: Final = {
    **dict.fromkeys(("P_CURR", "P_FBC", "P_CURRR", "PTOJ", "JTOP"), frozenset({TOOL, FRAME})),
    **dict.fromkeys(("P_TOOL", "M_TOOL"), frozenset({TOOL})),
    **dict.fromkeys(("P_BASE", "M_BSNO"), frozenset({FRAME})),
    "M_SPD": frozenset({TCP}),
    "M_JOVRD": frozenset({JOINT}),
    "M_RSPD": ALL_SETTINGS,
}
"""Settings that status variables and functions tell, or depend on."""
_SPARED_SETTINGS: Final[dict[str, frozenset[int]]] = {"Mov": frozenset({TCP}), "Mva": frozenset()}
"""Settings that a move does not depend on; others are at no percentage of joint speed."""


def _used_settings(item: s.Entry) -> frozenset[int]:
    """Settings that a line depends on: a joint move on no speed of the tool, others on no other."""
    match item:
        case MoveRows(kinds=kinds):
            joint = kinds == MOV
            return ALL_SETTINGS - ({TCP} if joint.all() else {JOINT} if not joint.any() else set())
        case s.Line(statement=statement) if statement is not None:
            return needed_settings(statement)
    return frozenset()


def needed_settings(statement: s.Statement) -> frozenset[int]:
    """The settings that what a statement does depends on."""
    found: frozenset[int] = frozenset()
    for part in nodes(statement):
        match part:
            case s.Motion(keyword=keyword):
                found |= ALL_SETTINGS - _SPARED_SETTINGS.get(keyword, frozenset({JOINT}))
            case s.Variable(key=key) if key in _READ_SETTINGS:
                found |= _READ_SETTINGS[key]
            case s.Command(keyword=keyword) if keyword in commands("needs"):
                found |= ALL_SETTINGS
    return found
