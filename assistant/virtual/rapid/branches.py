"""The branches of RAPID modules: what `Machine.took` can tell of."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from assistant.languages.rapid.tree import syntax as s
from assistant.languages.rapid.tree.walk import nodes
from assistant.virtual.branches import Branch, Branches, BranchKey


def branches(files: Sequence[s.File]) -> Branches:
    """Every way that a statement of the routines can go on."""
    found: dict[BranchKey, Branch] = {}
    for file in files:
        path = (file.source.path if file.source else None) or ""
        for node in nodes(file.parts):
            if file.source is None or not isinstance(node, DECISION_NODES) or node.span is None:
                continue
            start = node.span.start
            line = file.source.line_column(start)[0]
            for way, said in _branch_ways(node):
                found[path, start, way] = Branch(path, line, said)
    return found


DECISION_NODES = s.IfThen | s.CompactIf | s.ForLoop | s.WhileLoop | s.TestOf


def _branch_ways(
    node: s.IfThen | s.CompactIf | s.ForLoop | s.WhileLoop | s.TestOf,
) -> Iterator[tuple[int, str]]:
    match node:
        case s.IfThen(branches=parts):
            for way, _ in enumerate(parts):
                yield way, "ELSEIF met" if way else "IF met"
            yield len(parts), "ELSE" if node.otherwise else "IF not met"
        case s.CompactIf():
            yield from ((0, "IF met"), (1, "IF not met"))
        case s.WhileLoop(condition=condition) if not isinstance(condition, s.BoolLiteral):
            yield from ((0, "WHILE met"), (1, "WHILE not met"))
        case s.ForLoop(step=step) if step is not None:
            bounds = (node.first, node.last)
            if not all(isinstance(bound, s.NumberLiteral) for bound in bounds):
                yield from ((0, "FOR entered"), (1, "FOR passed"))
        case s.TestOf(cases=cases):
            for way, _ in enumerate(cases):
                yield way, f"CASE {way + 1}"
            yield len(cases), "DEFAULT" if node.otherwise else "no CASE"
