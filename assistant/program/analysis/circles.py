"""What leads back to itself along calls."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping


def recursive_names(calls: Mapping[str, Collection[str]]) -> frozenset[str]:
    """Names that lead back to themselves, found in a time that grows with the calls alone.

    calls: what each name calls; what is no key calls nothing. By the strongly connected components
    of the graph (R. Tarjan: Depth-first search and linear graph algorithms, 1972).
    """
    found: set[str] = set()
    order: dict[str, int] = {}
    first: dict[str, int] = {}
    """By name the least place in `order` that it is known to lead back to."""
    open_names: dict[str, None] = {}
    for root in calls:
        pending: list[tuple[str, Iterator[str]]] = []
        new: str | None = None if root in order else root
        while new is not None or pending:
            if new is not None:
                order[new] = first[new] = len(order)
                open_names[new] = None
                pending.append((new, iter(calls[new])))
            name, callees = pending[-1]
            new = None
            for callee in callees:
                if callee in calls and callee not in order:
                    new = callee
                    break
                if callee in open_names:
                    first[name] = min(first[name], order[callee])
            if new is not None:
                continue
            pending.pop()
            if pending:
                above = pending[-1][0]
                first[above] = min(first[above], first[name])
            if first[name] == order[name]:
                whole = [open_names.popitem()[0]]
                while whole[-1] != name:
                    whole.append(open_names.popitem()[0])
                if len(whole) > 1 or name in calls[name]:
                    found.update(whole)
    return frozenset(found)
