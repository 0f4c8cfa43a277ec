"""Names of a built program as the text spells them that its program was lifted from."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import replace
from typing import Any

from assistant.languages.melfa_basic.text import header
from assistant.languages.melfa_basic.tree import syntax as s
from assistant.languages.melfa_basic.tree.columnar import MoveRows, PositionRows
from assistant.languages.melfa_basic.tree.line_tables import rows_as_lines
from assistant.languages.melfa_basic.tree.walk import nodes
from assistant.program.rewriting import rewrite

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

    for item in items:
        if isinstance(item, s.Line) and item.label is not None:
            labels.setdefault(item.label.upper(), item.label)
        held = item.variable if isinstance(item, s.Data) else getattr(item, "statement", None)
        for node in nodes(held):
            if isinstance(node, s.Variable):
                names.setdefault(node.name.upper(), node.name)
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
                yield replace(row, label=label, statement=rewrite(row.statement, change))
            elif isinstance(row, s.Data):
                yield replace(row, variable=change(row.variable))
            else:
                yield row


def in_upper_case(node: Any) -> Any:
    """A statement with its names and labels as controllers compare them."""

    def change(one: Any) -> Any:
        if isinstance(one, s.Variable):
            return replace(one, name=one.name.upper())
        if isinstance(one, s.Target) and isinstance(one.place, str):
            return s.Target(one.place.upper())
        return one

    return rewrite(node, change)
