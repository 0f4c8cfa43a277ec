"""The branches of MELFA-BASIC programs: what `Machine.took` can tell of."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from assistant.languages.melfa_basic.tree import syntax as s
from assistant.virtual.branches import Branch, Branches, BranchKey
from assistant.virtual.melfa.code import Code, code_of


def branches(files: Sequence[s.File]) -> Branches:
    """Every way that a statement can go on; raises Failed where blocks do not close."""
    found: dict[BranchKey, Branch] = {}
    for file in files:
        code = code_of(file)
        for at, row in enumerate(code.rows):
            for way, said in _branch_ways(code, at, row.statement):
                found[code.path, at, way] = Branch(code.path, row.line, said)
    return found


def _branch_ways(code: Code, at: int, statement: s.Statement | None) -> Iterator[tuple[int, str]]:
    match statement:
        case s.If(then=None):
            parts = [code.rows[part].statement for part in code.opened[at].parts]
            yield 0, "If met"
            for way, part in enumerate(parts, 1):
                yield way, "ElseIf met" if isinstance(part, s.ElseIf) else "Else"
            if not parts or isinstance(parts[-1], s.ElseIf):
                yield len(parts) + 1, "If not met"
        case s.DefAct():
            yield from ((0, "interrupt"), (1, "no interrupt"))
        case s.If():
            yield from ((0, "If met"), (1, "If not met"))
        case s.For(first=first, last=last):
            if not (isinstance(first, s.Number) and isinstance(last, s.Number)):
                yield from ((0, "For entered"), (1, "For passed"))
        case s.Select():
            parts = [code.rows[part].statement for part in code.opened[at].parts]
            for way, part in enumerate(parts):
                yield way, f"Case {way + 1}" if isinstance(part, s.Case) else "Default"
            if not parts or isinstance(parts[-1], s.Case):
                yield len(parts), "no Case"
        case s.OnJump(targets=targets):
            for way, target in enumerate(targets, 1):
                if target is not None:
                    yield way, f"{statement.keyword} {way}"
            yield 0, f"no {statement.keyword}"
        case s.Command(keyword=keyword, arguments=arguments) if keyword.upper() == "WHILE":
            if not isinstance(arguments[0], s.Number):
                yield from ((0, "While met"), (1, "While not met"))
