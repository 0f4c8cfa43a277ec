"""Whether two trees say the same: what a controller would not tell apart compares equal.

Case of names, order of declarations, parentheses that priorities make needless, an IF in one
line, spelling of numbers, decimals beyond the printed ones, attributes of modules, LOCAL before
data of motion, a signal that is read by a function or by its name, and the
comments that this package itself writes into a module's head do not count. All the rest does.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Sequence
from typing import Any, Final
from unicodedata import combining, normalize

from assistant.base import rotations
from assistant.languages.rapid.text.header import read_header
from assistant.languages.rapid.tree import syntax as s
from assistant.languages.rapid.tree.literals import literal_number, literal_target
from assistant.languages.rapid.tree.syntax import (
    CIRCULAR,
    PLAIN_MOVES,
    TARGET_PARTS,
    MoveRun,
    TargetRun,
)

Said = tuple[Any, ...]
"""What a node says, as nested tuples that compare."""


def differences(before: Sequence[s.File], after: Sequence[s.File]) -> Iterator[str]:
    """One line for everything that only one side says, or that they say differently."""
    one, other = Counter(_items(before)), Counter(_items(after))
    for gone in (one - other).elements():
        yield f"only before: {_short(gone)}"
    for new in (other - one).elements():
        yield f"only after: {_short(new)}"


def _plain(comment: str) -> str:
    """A comment as it is written: in ASCII, without outer blanks."""
    letters = (c for c in normalize("NFKD", comment) if not combining(c))
    text = "".join(letters).encode("ascii", "replace").decode("ascii")
    return " ".join("".join(c if c.isprintable() else " " for c in text).split())


def _short(said: Said) -> str:
    return str(said)[:200]


def _items(files: Iterable[s.File]) -> Iterator[Said]:
    for module in (m for file in files for m in file.modules):
        yield "module", module.name.lower()
        comments = []
        for item in module.items:
            match item:
                case s.CommentLine(text):
                    comments.append(text)
                case s.TargetRunNode(_, run):
                    for name, values in _target_rows(run):
                        yield "data", "", "CONST", "robtarget", name, (), values
                case s.Routine():
                    whole = said(item)
                    yield (*whole[:-2], whole[-2][_heading(whole[-2]) :], whole[-1])
                    yield from whole[-2][: _heading(whole[-2])]
                case _:
                    yield said(item)
        yield from (("comment", _plain(c)) for c in read_header(comments).comments)


def _heading(body: Said) -> int:
    """How many comments a routine begins with: they may as well stand above it."""
    return next((at for at, x in enumerate(body) if x[0] != "comment"), len(body))


def said(node: Any) -> Said:
    """What one declaration, statement or expression says."""
    found = SAID.get(type(node))
    if found is None:
        raise TypeError(f"no node: {type(node).__name__}")
    result: Said = found(node)
    return result


def body(nodes: Sequence[Any] | None) -> Said:
    """The statements of a block, rows of moves one by one."""
    out: list[Said] = []
    for node in nodes or ():
        if isinstance(node, s.MoveRunNode):
            out += _move_rows(node.run)
        elif isinstance(node, s.TargetRunNode):
            out += [
                ("data", node.scope, "CONST", "robtarget", name, (), values)
                for name, values in _target_rows(node.run)
            ]
        else:
            out.append(said(node))
    return tuple(out)


def _target_rows(run: TargetRun) -> Iterator[tuple[str, Said]]:
    for row, values in enumerate(run.values.tolist()):
        yield run.names.name(row).lower(), _target(values)


def _move_rows(run: MoveRun) -> Iterator[Said]:
    for row in range(len(run)):
        motion = run.motions[row]
        points = [run.names.name(row)]
        if run.kinds[row] == CIRCULAR:
            points.insert(0, run.vias.name(row))
        names = (*points, motion.speed, motion.zone, motion.tool)
        options = {("wobj", ("name", motion.frame.lower()))} if motion.frame else set()
        yield _called(
            PLAIN_MOVES[int(run.kinds[row])].lower(), [("name", n.lower()) for n in names], options
        )


def _called(name: str, plain: list[Said], options: set[Said]) -> Said:
    """A call; ways of writing the same instruction come out alike."""
    if name in ("set", "reset") and len(plain) == 1 and not options:
        return "call", "setdo", (plain[0], ("number", float(name == "set"))), frozenset()
    if name == "tpwrite" and len(options) == 1:
        ((option, value),) = options
        if option == "num":
            shown = ("function", ("call", "valtostr", (value,), frozenset()))
            return "call", name, (("infix", "+", *plain, shown),), frozenset()
    if name == "reltool":
        options = {o for o in options if o[1:] != (("number", 0.0),)}
    return "call", name, tuple(plain), frozenset(options - {("wobj", ("name", "wobj0"))})


def _call(name: s.Expression | str, arguments: Sequence[s.Argument]) -> Said:
    plain: list[Said] = []
    options: set[Said] = set()
    for argument in arguments:
        match argument:
            case s.Positional(value, None):
                plain.append(said(value))
            case s.Positional(value, str(own)):
                plain.append(("named", own.lower(), said(value)))
            case s.Option(own, value):
                options.add((own.lower(), said(value) if value is not None else ()))
            case s.Conditional(own, variable):
                options.add((own.lower(), "?", said(variable)))
    if isinstance(name, str):
        return _called(name.lower(), plain, options)
    return "late call", said(name), tuple(plain), frozenset(options)


def _number(node: s.Expression) -> Said | None:
    value = literal_number(node)
    return None if value is None else ("number", float(value) + 0.0)


class Near(tuple[float, ...]):
    """Numbers that compare equal within what printing rounds."""

    __slots__ = ()
    within = 2e-4

    def __eq__(self, other: object) -> bool:
        return (
            isinstance(other, Near)
            and len(self) == len(other)
            and all(abs(a - b) <= self.within for a, b in zip(self, other, strict=True))
        )

    def __hash__(self) -> int:
        return len(self)


class NearTurn(Near):
    """Numbers of a quaternion."""

    __slots__ = ()
    within = 1e-6


def _target(values: Sequence[float]) -> Said:
    position, quaternion, configuration, external = (list(values[a:b]) for a, b in TARGET_PARTS)
    return (
        "target",
        Near(position),
        _orientation(quaternion),
        tuple(configuration),
        Near(external),
    )


def _orientation(quaternion: Sequence[float]) -> tuple[float, ...]:
    if not any(quaternion):
        return tuple(quaternion)
    return NearTurn(rotations.canonical(quaternion).tolist())


def _aggregate(node: s.AggregateNode) -> Said:
    target = literal_target(node)
    if target is not None:
        return _target(target)
    plain = _numbers(node)
    if plain is not None:
        return "aggregate", Near(plain)
    parts = [_numbers(i) for i in node.items]
    sizes = [None if q is None else len(q) for q in parts]
    if sizes == [3, 4] and parts[0] is not None and parts[1] is not None:
        return "pose", Near(parts[0]), _orientation(parts[1])
    if sizes == [6, 6] and parts[0] is not None and parts[1] is not None:
        return tuple(Near(q) for q in (parts[0], parts[1]))
    return "aggregate", tuple(said(i) for i in node.items)


def _numbers(node: s.Expression) -> list[float] | None:
    if not isinstance(node, s.AggregateNode):
        return None
    values = [literal_number(i) for i in node.items]
    return None if any(v is None for v in values) else [float(v) for v in values if v is not None]


def _function(node: s.FunctionCall) -> Said:
    match node:
        case s.FunctionCall(name, (s.Positional(s.NameRef() as signal, None),)):
            if name.lower() in ("dinput", "doutput", "ginput", "goutput", "ainput", "aoutput"):
                return said(signal)
    return "function", _call(node.name, node.arguments)


def _prefix(node: s.Prefix) -> Said:
    number = _number(node)
    if number is not None:
        return number
    if node.operator == "+":
        return said(node.operand)
    return "prefix", node.operator, said(node.operand)


def _branches(node: s.IfThen) -> Said:
    branches = tuple(
        (None if b.condition is None else said(b.condition), body(b.body)) for b in node.branches
    )
    return "if", branches, body(node.otherwise)


def _step(node: s.ForLoop) -> Said | None:
    if node.step is not None:
        return said(node.step)
    bounds = [literal_number(x) for x in (node.first, node.last)]
    if bounds[0] is None or bounds[1] is None:
        return None
    return "number", 1.0 if bounds[0] <= bounds[1] else -1.0


def _for(node: s.ForLoop) -> Said:
    bounds = said(node.first), said(node.last)
    return "for", node.variable.lower(), *bounds, _step(node), body(node.body)


def _test(node: s.TestOf) -> Said:
    cases = tuple((tuple(map(said, c.values)), body(c.body)) for c in node.cases)
    return "test", said(node.subject), cases, body(node.otherwise)


def _data(node: s.Data) -> Said:
    value = None if node.value is None else said(node.value)
    kind = node.type.lower()
    scope = "" if kind in FOR_ALL and node.scope == "LOCAL" else node.scope
    return (
        *("data", scope, node.storage, kind, node.name.lower()),
        *(tuple(map(said, node.dimensions)), value),
    )


FOR_ALL: Final = ("tooldata", "wobjdata", "speeddata", "zonedata", "robtarget", "jointtarget")
"""Types whose data the pseudo-program has for the whole program, also those of one module."""


def _routine(node: s.Routine) -> Said:
    groups = tuple((g.optional, tuple(map(said, g.alternatives))) for g in node.parameters)
    handlers = tuple((h.kind, tuple(map(said, h.numbers)), body(h.body)) for h in node.handlers)
    return (
        *("routine", node.kind, node.local, node.name.lower(), node.type.lower()),
        *(groups, _declared_first(body(node.body)), handlers),
    )


def _declared_first(body: Said) -> Said:
    """Declarations of a routine in order of names: none of them needs another one."""
    data = sorted((x for x in body if x[0] == "data"), key=lambda x: str(x[4]))
    return (*data, *(x for x in body if x[0] != "data"))


SAID: Final[dict[type, Callable[[Any], Said]]] = {
    s.NumberLiteral: lambda n: _number(n) or ("number", n.text.lower()),
    s.StringLiteral: lambda n: ("string", n.value),
    s.BoolLiteral: lambda n: ("truth", n.value),
    s.NameRef: lambda n: ("name", n.name.lower()),
    s.Component: lambda n: ("component", said(n.value), n.name.lower()),
    s.Whole: lambda _: ("whole",),
    s.Element: lambda n: ("element", said(n.value), tuple(map(said, n.indices))),
    s.AggregateNode: _aggregate,
    s.Group: lambda n: said(n.inner),
    s.FunctionCall: lambda n: _function(n),
    s.Prefix: _prefix,
    s.Infix: lambda n: ("infix", n.operator, said(n.left), said(n.right)),
    s.Placeholder: lambda n: ("hole", n.text),
    s.CommentLine: lambda n: ("comment", _plain(n.text)),
    s.Assignment: lambda n: ("assign", said(n.target), said(n.value)),
    s.ProcedureCall: lambda n: _call(n.name, n.arguments),
    s.GotoLabel: lambda n: ("goto", n.label.lower()),
    s.LabelMark: lambda n: ("label", n.name.lower()),
    s.ReturnFrom: lambda n: ("return", None if n.value is None else said(n.value)),
    s.RaiseError: lambda n: ("raise", None if n.value is None else said(n.value)),
    s.Word: lambda n: ("word", n.word),
    s.Connect: lambda n: ("connect", said(n.interrupt), n.trap.lower()),
    s.IfThen: _branches,
    s.CompactIf: lambda n: ("if", ((said(n.condition), body((n.statement,))),), ()),
    s.ForLoop: _for,
    s.WhileLoop: lambda n: ("while", said(n.condition), body(n.body)),
    s.TestOf: _test,
    s.Data: _data,
    s.Record: lambda n: (
        *("record", n.local, n.name.lower()),
        tuple((t.lower(), c.lower()) for t, c in n.components),
    ),
    s.Alias: lambda n: ("alias", n.local, n.type.lower(), n.name.lower()),
    s.ParameterNode: lambda n: (n.mode, n.type.lower(), n.name.lower(), n.dimensions),
    s.Routine: _routine,
}
