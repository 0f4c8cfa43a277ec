"""Names that programs use and neither they nor their position lists give a value: the cell must
state it.

Positions and joints that were taught on the controller and not exported, numbers that were set
there, and the tools and bases that parameters hold by their numbers.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import Final

from assistant.base.diagnostics import Span
from assistant.languages.melfa_basic.checks.file_view import Calls, Look, known_variables
from assistant.languages.melfa_basic.checks.lines import with_single_rows
from assistant.languages.melfa_basic.checks.names import is_call
from assistant.languages.melfa_basic.tables import vocabulary
from assistant.languages.melfa_basic.tables.dialects import DIALECTS
from assistant.languages.melfa_basic.tables.variables import (
    LAST_SET_PARAMETERS,
    PARAMETERS,
    SETTING_STATUS,
    TAUGHT_STATUS,
    parameter_position,
)
from assistant.languages.melfa_basic.tree import syntax as s
from assistant.languages.melfa_basic.tree import walk
from assistant.languages.melfa_basic.tree.line_tables import Positions
from assistant.languages.melfa_basic.tree.walk import literal, nodes, program_name
from assistant.program.undeclared_names import STATE_TYPE, CallArgument, Plain, Wanted, WantedKind

_OF_TYPE: Final[dict[str, str]] = {"Pos": "P", "Jnt": "J", "Char": "C"}
"""Type of a `Def` → the letter that names of it begin with elsewhere; numbers otherwise."""
_KINDS: Final[dict[str, tuple[WantedKind, str, Plain | None]]] = {
    "P": ("position", "", None),
    "J": ("joints", "", None),
    "C": ("data", "string", ""),
    "M": ("data", "num", 0.0),
}
"""By letter: what it is, its type, and the value that says least."""


def wanted(trees: Sequence[s.File]) -> tuple[Wanted, ...]:
    """Return the names without a value, in the order of the programs and of their first uses.

    Names of all programs but the first have the name of their program as a prefix.
    """
    trees = with_single_rows(trees)
    calls, found = Calls(trees), dict[str, Wanted]()
    looks = [Look(tree, DIALECTS[tree.dialect], calls) for tree in trees]
    given = {key for look in looks for key in _externals(look)}
    for at, (tree, look) in enumerate(zip(trees, looks, strict=True)):
        # Lines that are not there may give any name a value.
        if look.has_strangers:
            continue
        before = f"{program_name(tree)}_" if at else ""
        for one in (
            *_variables(look),
            *_parameters(look),
            *_tools(look),
            *_outside(look),
            *_functions(look),
        ):
            external = one.name[1:2] == "_"
            shared = external or one.kind in ("tool", "frame", "routine")
            # Another program sets it before it is read.
            if external and one.name.upper() in given:
                continue
            name = one.name if shared else before + one.name
            there = found.get(name.lower())
            uses = tuple(dict.fromkeys((*(there.uses if there else ()), *one.uses)))
            found[name.lower()] = replace(there or one, name=name, uses=uses)
    return tuple(found.values())


def _variables(look: Look) -> Iterator[Wanted]:
    """Plain variables of a file that are used and have no value, or only components of one."""
    names, positions = look.once(known_variables), Positions(look.tree)
    types = {
        v.key: _OF_TYPE.get(node.type, "M")
        for _, node in look.all(s.DefNames)
        for v in node.variables
    }
    whole = {
        use.variable.key
        for _, use in look.uses
        if use.role in ("written", "either") and not use.variable.component
    }
    empty = _empty(look.tree)
    met: dict[str, Wanted] = {}
    for line, use in look.uses:
        variable, key = use.variable, use.variable.key
        asks = use.role == "read" or bool(variable.component)
        if not asks or variable.arguments is not None or is_call(look, variable):
            continue
        external = key[1:2] == "_"
        if (
            (key in whole and not external)
            or (vocabulary.status(key) is not None and key not in TAUGHT_STATUS)
            or walk.is_force_state(key)
        ):
            continue
        if (
            key in positions.plain
            or positions.constant(key) is not None
            or key in names.dimensioned
        ):
            continue
        # A component that is set leaves the others of the position without a value.
        if not external and key in names.given and key not in empty and not variable.component:
            continue
        kind, type, nothing = _KINDS[types.get(key, key[0] if key[0] in "PJC" else "M")]
        one = met.get(key) or Wanted(variable.name, kind, type, nothing=nothing)
        assigned = one.assigned or use.role != "read"
        met[key] = replace(one, uses=(*one.uses, _place(look, line.span)), assigned=assigned)
    yield from met.values()


def _externals(look: Look) -> Iterator[str]:
    """Variables of all programs that a file gives values before it reads them, as they stand.

    The others have what the controller holds of them, which outlasts the programs.
    """
    met = set[str]()
    for _, use in look.uses:
        key = use.variable.key
        if key[1:2] == "_" and key not in met and use.role != "read":
            yield key
        met.add(key)
    for item in look.data:
        if isinstance(item, s.Data) and item.variable.key[1:2] == "_":
            yield item.variable.key


def _empty(tree: s.File) -> set[str]:
    """Positions that were never taught, whose lines hold zeros without flags."""
    return {
        item.variable.key
        for item in tree.items
        if isinstance(item, s.Data)
        and isinstance(item.value, s.Constant)
        and item.value.flags == (None, None)
        and not any(item.value.values)
    }


def _parameters(look: Look) -> Iterator[Wanted]:
    """Tools and bases by number."""
    positions = Positions(look.tree)
    for line, command in look.all(s.Command):
        known_as = PARAMETERS.get(command.keyword)
        number = literal(command.arguments[0]) if len(command.arguments) == 1 else None
        if known_as is not None and number:
            kind: WantedKind = "tool" if command.keyword == "Tool" else "frame"
            name = known_as.format(number=round(number))
            if positions.constant(parameter_position(name)) is None:
                yield Wanted(name, kind, uses=(_place(look, line.span),))


def _tools(look: Look) -> Iterator[Wanted]:
    """Tools that `M_Tool` is given by their numbers."""
    positions = Positions(look.tree)
    for line, node in look.all(s.Assign):
        number = literal(node.value) if node.target.key == SETTING_STATUS["Tool"] else None
        if number:
            name = PARAMETERS["Tool"].format(number=round(number))
            if positions.constant(parameter_position(name)) is None:
                yield Wanted(name, "tool", uses=(_place(look, line.span),))


def kept(trees: Sequence[s.File]) -> Iterator[Wanted]:
    """The tool and the base that parameters keep, where none of the programs sets another one."""
    for word, name in LAST_SET_PARAMETERS.items():
        kind: WantedKind = "tool" if word == "Tool" else "frame"
        if trees and not any(_sets(tree, word) for tree in trees):
            yield Wanted(name, kind)


def _sets(tree: s.File, word: str) -> bool:
    for item in tree.items:
        for node in nodes(item.statement if isinstance(item, s.Line) else None):
            match node:
                case s.Command(keyword=keyword) if keyword == word:
                    return True
                case s.Assign(target=target) if target.key == SETTING_STATUS[word]:
                    return True
    return False


def _outside(look: Look) -> Iterator[Wanted]:
    """Routines that stand for commands of the maker's own, and the states that they give."""
    for line, command in look.all(s.Command):
        routine = walk.supplied_routine(command)
        if routine is not None:
            name, given = routine
            yield Wanted(
                name,
                "routine",
                arguments=(CallArgument("num"),) * len(given),
                uses=(_place(look, line.span),),
            )
    written = {use.variable.key for _, use in look.uses if use.role != "read"}
    for line, use in look.uses:
        name, key = use.variable.name, use.variable.key
        if walk.is_force_state(key) and key not in written:
            kind, type, nothing = _KINDS[key[0]]
            type = type or STATE_TYPE
            yield Wanted(name, kind, type, nothing=nothing, uses=(_place(look, line.span),))


def _functions(look: Look) -> Iterator[Wanted]:
    """Yield functions that are called but defined in no file: calls with `()`, and call
    statements.
    """
    if not look.tree.dialect.endswith("6"):
        return
    names = look.once(known_variables)
    made = {node.name.upper() for _, node in look.all(s.DefFunction)}
    called: list[tuple[s.Line, s.Variable, str, Plain | None]] = [
        (line, call.function, "", None) for line, call in look.all(s.Call)
    ]
    for line, use in look.uses:
        variable = use.variable
        if use.role == "read" and variable.arguments is not None:
            if variable.arguments == () or variable.key.startswith("FN"):
                _, type, nothing = _KINDS[_letter(variable)]
                called.append((line, variable, type or "position", nothing))
    for line, function, result, nothing in called:
        key = function.key
        if key in look.functions or key in made or key in names.dimensioned:
            continue
        if vocabulary.function(key) is None and vocabulary.status(key) is None:
            given = tuple(CallArgument(_KINDS[_letter(one)][1]) for one in function.arguments or ())
            uses = (_place(look, line.span),)
            yield Wanted(
                function.name, "routine", result, arguments=given, uses=uses, nothing=nothing
            )


def _letter(node: s.Expression | None) -> str:
    """That of the type of a value, as far as its name tells it."""
    match node:
        case s.String():
            return "C"
        case s.Variable(component="") if node.key[0] in "PJC":
            return node.key[0]
    return "M"


def _place(look: Look, span: Span | None) -> str:
    number = "?"
    if look.tree.source is not None and span is not None:
        number = str(look.tree.source.line_column(span.start)[0])
    return f"{program_name(look.tree) or 'program'}:{number}"
