"""Rules of several programs, of interrupts, and of lines of communication."""

from __future__ import annotations

from collections.abc import Iterator

from assistant.languages.melfa_basic import rules
from assistant.languages.melfa_basic.checks import flow_rules, motion_rules
from assistant.languages.melfa_basic.checks.file_view import Look, program_name
from assistant.languages.melfa_basic.checks.kinds import literal
from assistant.languages.melfa_basic.tree import syntax as s
from assistant.languages.melfa_basic.tree.columnar import MoveRows
from assistant.program.diagnostics import Diagnostic

Found = Iterator[Diagnostic]


def called(tree: s.File) -> Iterator[tuple[s.Line, str, int | None]]:
    """Programs that a file names: the line, the name, and the slot it is run or loaded in.

    None for CallP, which stays in its own slot; 0 for a slot that is worked out.
    """
    for item in tree.items:
        if not isinstance(item, s.Line):
            continue
        for statement in _statements(item.statement):
            match statement:
                case s.CallP(program=s.String(name)):
                    yield item, name, None
                case s.Command("XRun" | "XLoad", (slot, s.String(name), *_)):
                    yield item, name, int(literal(slot) or 0)
                case s.Include(program=name):
                    yield item, name, None


def _statements(statement: s.Statement | s.Target | None) -> Iterator[s.Statement]:
    if isinstance(statement, s.If):
        yield from _statements(statement.then)
        yield from _statements(statement.otherwise)
    elif statement is not None and not isinstance(statement, s.Target):
        yield statement


def missing(look: Look) -> Found:
    """Programs that are called, run or loaded, and are not among the files."""
    seen: set[str] = set()
    for line, name, _ in called(look.tree):
        plain = name.upper().removesuffix(".PRG")
        if plain not in look.calls.by_name and plain not in seen:
            seen.add(plain)
            yield look.at(rules.NO_PROGRAM, line, f'"{name}"', name=name)


def recursion(look: Look) -> Found:
    """Programs that call themselves, or call too deep."""
    own = program_name(look.tree).upper()
    most = look.dialect.nesting.calls
    told = False
    for line, name, slot in called(look.tree):
        if slot is not None or isinstance(line.statement, s.Include) or told:
            continue
        chain = _way_back(look, name.upper(), own) if own else None
        if chain is not None:
            told = True
            text = " calls ".join(f"`{n}`" for n in (own, *chain))
            yield look.at(flow_rules.CALLS_ITSELF, line, "CallP", chain=text)
            continue
        depth = 1 + _depth(look, name.upper(), ())
        if depth == most + 1:
            told = True
            yield look.at(flow_rules.CALLED_TOO_DEEP, line, "CallP", depth=depth, most=most)


def _inner(look: Look, name: str) -> list[str]:
    tree = look.calls.by_name.get(name.removesuffix(".PRG"))
    if tree is None:
        return []
    return [
        other.upper()
        for line, other, slot in called(tree)
        if slot is None and not isinstance(line.statement, s.Include)
    ]


def _way_back(look: Look, name: str, own: str) -> list[str] | None:
    """The programs from one to the own one, None if it does not lead there."""
    left: list[tuple[str, ...]] = [(name,)]
    seen: set[str] = set()
    while left:
        chain = left.pop()
        if chain[-1] == own:
            return list(chain)
        if chain[-1] not in seen:
            seen.add(chain[-1])
            left += [(*chain, other) for other in _inner(look, chain[-1])]
    return None


def _depth(look: Look, name: str, above: tuple[str, ...]) -> int:
    if name in above:
        return 0
    return max((1 + _depth(look, n, (*above, name)) for n in _inner(look, name)), default=0)


def mechanisms(look: Look) -> Found:
    """Programs that are run in slots other than 1, and move the robot without having asked."""
    seen: set[str] = set()
    for line, name, slot in called(look.tree):
        tree = look.calls.by_name.get(name.upper().removesuffix(".PRG"))
        if tree is None or slot is None or slot <= 1 or name.upper() in seen:
            continue
        code = [item for item in tree.items if isinstance(item, s.Line | MoveRows)]
        if any(map(_moves, code)) and not any(map(_asks, code)):
            seen.add(name.upper())
            yield look.at(motion_rules.NO_GETM, line, f'"{name}"', name=name, slot=slot)


def _asks(item: s.Line | MoveRows) -> bool:
    statement = item.statement if isinstance(item, s.Line) else None
    return isinstance(statement, s.Command) and statement.keyword == "GetM"


def _moves(item: s.Line | MoveRows) -> bool:
    return isinstance(item, MoveRows) or isinstance(item.statement, s.Motion)


# ----------------------------------------------------------------------------------- interrupts


def interrupts(look: Look) -> Found:
    """Interrupts that are switched but not defined, or defined but not switched on."""
    defined: dict[float, s.Line] = {}
    unsure = False
    for line, act in look.all(s.DefAct):
        number = literal(act.number)
        if number is None:
            unsure = True
        else:
            defined.setdefault(number, line)
    switched: set[float] = set()
    on: set[float] = set()
    every = False
    for line, number, state in _switches(look):
        if number is None:
            every = True
            continue
        if number == 0:
            every = every or state != 0
            continue
        if state != 0:
            on.add(number)
        if number not in defined and number not in switched and not unsure:
            yield look.at(motion_rules.NO_ACT, line, "Act", number=f"{number:g}")
        switched.add(number)
    for number, line in defined.items():
        if number not in on and not every:
            yield look.at(motion_rules.ACT_OFF, line, "Act", number=f"{number:g}")


def _switches(look: Look) -> Iterator[tuple[s.Line, float | None, float | None]]:
    """`Act n=state` statements; None for numbers that are worked out."""
    for line, command in look.all(s.Command):
        if command.keyword == "Act" and command.arguments:
            match command.arguments[0]:
                case s.Binary("=", number, state):
                    yield line, literal(number), literal(state)


# --------------------------------------------------------------------------------------- files


def files(look: Look) -> Found:
    """Lines that are used without being opened, opened twice, or never closed."""
    opened: dict[float, s.Line] = {}
    unsure = False
    for line, node in look.all(s.Open):
        number = literal(node.number)
        unsure = unsure or number is None
        if number is not None:
            opened.setdefault(number, line)
    closed = {literal(n) for _, close in look.all(s.Close) for n in close.numbers}
    every = None in closed or any(not close.numbers for _, close in look.all(s.Close))
    others = any(
        isinstance(item, s.Line) and isinstance(item.statement, s.Open)
        for tree in look.calls.trees
        if tree is not look.tree
        for item in tree.items
    )
    seen: set[float] = set()
    for word, kind in (("Print", s.Print), ("Input", s.Input)):
        for line, used in look.all(kind):
            number = literal(used.number)  # type: ignore[attr-defined]
            if number is None or number in opened or number in seen or unsure or others:
                continue
            seen.add(number)
            yield look.at(motion_rules.NOT_OPENED, line, word, word=word, number=f"{number:g}")
    for number, line in opened.items():
        if number not in closed and not every:
            yield look.at(motion_rules.NOT_CLOSED, line, "Open", number=f"{number:g}")
    yield from _twice(look)


def _twice(look: Look) -> Found:
    """Opens of a number that is open, as far as the lines run straight on."""
    busy: set[float] = set()
    for line in look.lines:
        if line.label is not None:
            busy.clear()
        match line.statement:
            case s.Open(number=value):
                number = literal(value)
                if number is not None and number in busy:
                    yield look.at(motion_rules.OPENED_TWICE, line, "Open", number=f"{number:g}")
                if number is not None:
                    busy.add(number)
            case s.Close(numbers=numbers):
                busy -= {n for value in numbers if (n := literal(value)) is not None}
                if not numbers or any(literal(value) is None for value in numbers):
                    busy.clear()
            case s.Command("End") | s.Jump() | s.CallP() | s.Call() | s.If():
                busy.clear()
