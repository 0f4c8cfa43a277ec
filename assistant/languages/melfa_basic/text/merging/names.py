"""Names of a built program as the text spells them that its program was lifted from."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import fields, is_dataclass, replace
from typing import Any

from assistant.languages.melfa_basic.text import header
from assistant.languages.melfa_basic.tree import syntax as s
from assistant.languages.melfa_basic.tree.columnar import MoveRows, PositionRows
from assistant.languages.melfa_basic.tree.line_tables import rows_as_lines

Names = Mapping[str, str]


def named_as(file: s.File, tree: s.File) -> s.File:
    """A built file with the names of the tree, by the header that keeps the original ones."""
    kept = header.read(_texts(file.items))
    spelled, labelled = _used(tree.items)
    short = {name: variable.name for name, variable in kept.variables.items()}
    for kind in header.NAME_KINDS:
        short |= kept.names[kind]
    names = {n.upper(): spelled[o.upper()] for n, o in short.items() if o.upper() in spelled}
    labels = {n.upper(): labelled[o.upper()] for n, o in short.items() if o.upper() in labelled}
    return replace(file, items=tuple(_renamed(file.items, names, labels)))


def _texts(items: Iterable[s.Item]) -> Iterator[str]:
    """The comments that begin a file, without their mark."""
    for item in items:
        if not isinstance(item, s.Line) or item.comment is None:
            return
        yield item.comment.removeprefix("'").strip()


def _used(items: Iterable[s.Item]) -> tuple[Names, Names]:
    """Upper case → spelling of the names and the labels in a text."""
    names: dict[str, str] = {}
    labels: dict[str, str] = {}

    def note(node: Any) -> Any:
        if isinstance(node, s.Variable):
            names.setdefault(node.name.upper(), node.name)
        return node

    for item in items:
        if isinstance(item, s.Line):
            rebuilt(item.statement, note)
            if item.label is not None:
                labels.setdefault(item.label.upper(), item.label)
        elif isinstance(item, s.Data):
            note(item.variable)
    return names, labels


def _renamed(items: Iterable[s.Item], names: Names, labels: Names) -> Iterator[s.Item]:
    def change(node: Any) -> Any:
        if isinstance(node, s.Variable) and node.name.upper() in names:
            return replace(node, name=names[node.name.upper()])
        if isinstance(node, s.Target) and isinstance(node.place, str):
            return s.Target(labels.get(node.place.upper(), node.place))
        return node

    for item in items:
        if isinstance(item, PositionRows | MoveRows):
            stem = item.stem.upper()
            numbered = any(n.startswith(stem) and n[len(stem) :].isdigit() for n in names)
            rows: Iterable[s.Item] = rows_as_lines(item) if numbered else [item]
        else:
            rows = [item]
        for row in rows:
            if isinstance(row, s.Line):
                label = row.label and labels.get(row.label.upper(), row.label)
                yield replace(row, label=label, statement=rebuilt(row.statement, change))
            elif isinstance(row, s.Data):
                yield replace(row, variable=change(row.variable))
            else:
                yield row


def rebuilt(node: Any, change: Callable[[Any], Any]) -> Any:
    """A node with everything in it changed, from the inside out."""
    if isinstance(node, tuple):
        return tuple(rebuilt(one, change) for one in node)
    if not is_dataclass(node) or isinstance(node, type):
        return node
    parts = {f.name: getattr(node, f.name) for f in fields(node)}
    new = {name: rebuilt(part, change) for name, part in parts.items()}
    same = all(new[name] is part or new[name] == part for name, part in parts.items())
    return change(node if same else replace(node, **new))


def in_upper_case(node: Any) -> Any:
    """A statement with its names and labels as controllers compare them."""

    def change(one: Any) -> Any:
        if isinstance(one, s.Variable):
            return replace(one, name=one.name.upper())
        if isinstance(one, s.Target) and isinstance(one.place, str):
            return s.Target(one.place.upper())
        return one

    return rebuilt(node, change)
