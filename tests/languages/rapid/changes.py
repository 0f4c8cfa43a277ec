"""Random changes of a RAPID tree, as a tool makes them: from the leaf up, the rest shared."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, fields, replace
from random import Random
from typing import Any

from assistant.languages.rapid.tree import syntax as s

STATEMENTS = (
    s.ReturnFrom(),
    s.Assignment(s.NameRef("fresh"), s.NumberLiteral("42")),
    s.ProcedureCall("Stop", (s.Option("NoRegain"),)),
    s.IfThen((s.IfBranch(s.NameRef("ready"), (s.Word("EXIT"), s.CommentLine("why", True))),), ()),
    s.WhileLoop(s.BoolLiteral(True), ()),
    s.CommentLine("a comment"),
    s.LabelMark("again"),
)
ITEMS = (
    s.Data("LOCAL", "VAR", "num", "fresh", (s.NumberLiteral("3"),)),
    s.Alias(False, "num", "metres"),
    s.Record(True, "pair", (("num", "a"), ("string", "b"))),
    s.Routine("PROC", False, "added", (s.ReturnFrom(),)),
    s.CommentLine("a comment"),
)
LISTS = {
    "parts": (s.CommentLine("a comment"), s.Module("added", (), ())),
    "items": ITEMS,
    "body": STATEMENTS,
    "otherwise": STATEMENTS,
    "arguments": (s.Option("On"), s.Conditional("Off", s.NameRef("off"))),
    "parameters": (
        s.ParameterGroup(True, (s.ParameterNode("", "switch", "on"),)),
        s.ParameterGroup(False, (s.ParameterNode("VAR", "num", "more", 2),)),
    ),
    "dimensions": (s.NumberLiteral("7"),),
    "indices": (s.NumberLiteral("7"), s.Whole()),
    "values": (s.NumberLiteral("7"),),
    "numbers": (s.NameRef("ERR_OTHER"),),
    "handlers": (),
    "cases": (s.TestCase((s.NumberLiteral("8"), s.NameRef("b")), (s.ReturnFrom(),)),),
    "branches": (s.IfBranch(s.NameRef("otherwise"), (s.ReturnFrom(),)),),
    "attributes": (),
    "components": (("num", "added"),),
    "alternatives": (),
}
"""Fields that are lists, with what may be put into them."""
NEVER_EMPTY = {"parts", "indices", "values", "branches", "components", "alternatives"}
ONLY_VARIABLES = {"target", "interrupt", "variable"}
SPELLINGS: dict[tuple[type, str], tuple[Any, ...]] = {
    (s.NumberLiteral, "text"): ("42", "1.5E3"),
    (s.StringLiteral, "value"): ("", 'say "no" \\ or not'),
    (s.BoolLiteral, "value"): (True, False),
    (s.CommentLine, "text"): ("other words", ""),
    (s.Word, "word"): ("EXIT", "RETRY", "TRYNEXT"),
    (s.Data, "storage"): ("VAR", "PERS", "CONST"),
    (s.Data, "scope"): ("", "LOCAL", "TASK"),
    (s.File, "header"): (None, " VERSION:2 "),
}
NAMES = {"name", "label", "variable", "trap", "type"}


@dataclass(frozen=True)
class Change:
    """A changed tree. old, new: what was taken out, what was put in instead."""

    tree: s.File
    old: tuple[Any, ...]
    new: tuple[Any, ...]


Put = Callable[[Any], s.File]


def change(tree: s.File, random: Random) -> Change:
    """One random change."""
    while True:
        node, put = random.choice(list(_places(tree, lambda new: new)))
        spots = [f.name for f in fields(node) if f.name not in ("span", "origin", "findings")]
        if not spots:  # a node without fields, `*` among indices
            continue
        name = random.choice(spots)
        value = getattr(node, name)
        made = _other(node, name, value, random)
        if made is not None and made[0] != value:
            new, taken, given = made
            return Change(put(replace(node, **{name: new})), taken, given)


def _places(node: Any, put: Put) -> Iterator[tuple[Any, Put]]:
    """Every node with what puts another one in its place."""
    yield node, put
    for field in fields(node):
        value = getattr(node, field.name)
        if isinstance(value, s.Node):
            yield from _places(value, lambda new, f=field.name: put(replace(node, **{f: new})))
        elif isinstance(value, tuple):
            for k, child in enumerate(value):
                if isinstance(child, s.Node):

                    def put_item(
                        new: Any, f: str = field.name, v: Any = value, k: int = k
                    ) -> s.File:
                        return put(replace(node, **{f: (*v[:k], new, *v[k + 1 :])}))

                    yield from _places(child, put_item)


def _other(
    node: Any, name: str, value: Any, random: Random
) -> tuple[Any, tuple[Any, ...], tuple[Any, ...]] | None:
    if (type(node), name) in SPELLINGS:
        return random.choice(SPELLINGS[type(node), name]), (node,), (node,)
    if name == "local":
        return not value, (), ()
    if isinstance(value, str) and name in NAMES and value and value != "<ID>":
        return "renamed", (node,), (node,)
    if isinstance(node, s.IfBranch) and node.condition is None:
        return None
    if isinstance(node, s.TestCase) and not node.values:
        return None
    if isinstance(value, s.Node) and not isinstance(value, s.StatementNode):
        return _expression(node, name, value, random)
    if isinstance(value, tuple) and name in LISTS:
        return _list(node, name, value, random)
    return None


def _expression(
    node: Any, name: str, value: Any, random: Random
) -> tuple[Any, tuple[Any, ...], tuple[Any, ...]]:
    new: Any = s.NameRef("fresh")
    variable = name in ONLY_VARIABLES or isinstance(node, s.Component | s.Element)
    if not variable and random.random() < 0.5:
        new = s.FunctionCall("Abs", (s.Positional(s.Group(s.Infix("+", new, new))),))
    return new, (value,), (new,)


def _list(
    node: Any, name: str, value: tuple[Any, ...], random: Random
) -> tuple[Any, tuple[Any, ...], tuple[Any, ...]] | None:
    at = random.randint(0, len(value))
    choices = LISTS["values" if isinstance(node, s.AggregateNode) else name]
    never_empty = name in NEVER_EMPTY or isinstance(node, s.AggregateNode)
    match random.choice(("put", "take", "replace", "swap", "wrap")):
        case "put" if choices:
            new = random.choice(choices)
            return (*value[:at], new, *value[at:]), (), (new,)
        case "take" if at < len(value) and len(value) > never_empty:
            left = (*value[:at], *value[at + 1 :])
            if name == "parts" and not any(isinstance(p, s.Module) for p in left):
                return None
            return left, (value[at],), ()
        case "replace" if at < len(value) and choices and name != "parts":
            new = random.choice(choices)
            return (*value[:at], new, *value[at + 1 :]), (value[at],), (new,)
        case "swap" if at + 1 < len(value):
            pair = value[at : at + 2]
            return (*value[:at], *pair[::-1], *value[at + 2 :]), pair, pair
        case "wrap" if name in ("body", "otherwise") and at < len(value):
            new = s.ForLoop("i", s.NumberLiteral("1"), s.NameRef("n"), None, value[at:])
            return (*value[:at], new), value[at:], (new,)
    return None


def settled(node: Any) -> Any:
    """The tree with comments as a text can have them: none behind another, none behind nothing."""
    if isinstance(node, tuple):
        nodes = [settled(child) for child in node]
        for k, child in enumerate(nodes):
            if isinstance(child, s.CommentLine) and child.trailing:
                alone = k == 0 or isinstance(nodes[k - 1], s.CommentLine)
                nodes[k] = replace(child, trailing=not alone)
        return tuple(nodes)
    if isinstance(node, s.Node | s.File):
        inner = {f.name: getattr(node, f.name) for f in fields(node) if f.name != "findings"}
        return replace(
            node,
            **{k: settled(v) for k, v in inner.items() if isinstance(v, tuple | s.Node)},
        )
    return node
