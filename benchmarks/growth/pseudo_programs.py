"""Pseudo-programs that grow."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Final

from benchmarks.growth.construct import Lines


def _main(inner: Lines) -> Lines:
    def lines(n: int) -> Iterator[str]:
        yield from ("variable a number = 0", "procedure main", *inner(n), "end")

    return lines


def _pseudo_nested(n: int) -> Iterator[str]:
    yield from (*("if a = 1" for _ in range(n)), *("end" for _ in range(n)))


def _pseudo_moves(n: int) -> Iterator[str]:
    for k in range(n):
        yield f"move linear target [{k}, 0, 400] [0, 0, 1, 0] speed 100 mm/s blend {k % 5} mm"


def _pseudo_path(n: int) -> Iterator[str]:
    yield "follow seam"
    yield " joint [0, 0, 400] [0, 0, 1, 0] speed 100 mm/s blend fine"
    yield from (f" linear [{k}, 0, 400]" for k in range(n))
    yield "end"


def _pseudo_paths(n: int) -> Iterator[str]:
    for k in range(n):
        yield from ("follow seam", " joint [0, 0, 400] [0, 0, 1, 0] speed 100 mm/s blend fine")
        yield from (f" linear [{k}, 0, 300]", "end")


def _pseudo_labels(n: int) -> Iterator[str]:
    for k in range(n):
        yield from (f"label l{k}", f"goto l{(7 * k + 1) % n}")


def _pseudo_loops(n: int) -> Iterator[str]:
    for k in range(n):
        yield from (f"for i from 1 to {k}", " a = a + i", "end")


def _pseudo_cases(n: int) -> Iterator[str]:
    yield "switch a"
    for k in range(n):
        yield from (f"case {k}", f" a = {k}")
    yield "end"


def _pseudo_messages(n: int) -> Iterator[str]:
    yield from (f'message "a{k}"' for k in range(n))


def _pseudo_calls(n: int) -> Iterator[str]:
    for k in range(n):
        yield from (f"procedure p{k}", f"call p{k + 1}" if k + 1 < n else "stop", "end")


def _pseudo_variables(n: int) -> Iterator[str]:
    yield from (f"variable a{k} number = {k}" for k in range(n))
    yield from ("procedure main", *(f"a{k} = a{(k + 1) % n}" for k in range(n)), "end")


def _pseudo_like_names(n: int) -> Iterator[str]:
    """Names that are alike in their first letters, or but for their accents."""
    yield from (f"variable `{'ä' * 60}{k}` number = {k}" for k in range(n))
    yield from ("procedure main", *(f"`{'ä' * 60}{k}` = {k}" for k in range(n)), "end")


def _pseudo_targets(n: int) -> Iterator[str]:
    yield from (f"target t{k} [{k}, 0, 400] [0, 0, 1, 0]" for k in range(n))
    yield "procedure main"
    yield from (f"move linear t{k} speed {k % 50 + 1} mm/s blend {k % 7} mm" for k in range(n))
    yield "end"


def _pseudo_signals(n: int) -> Iterator[str]:
    yield from (f"signal s{k} digital output {k}" for k in range(n))
    yield from ("procedure main", *(f"set s{k} = true" for k in range(n)), "end")


def _pseudo_tools(n: int) -> Iterator[str]:
    yield from (f"tool t{k} tip [0, 0, {k}] [1, 0, 0, 0]" for k in range(n))
    yield "procedure main"
    for k in range(n):
        yield (f"move linear target [{k}, 0, 400] [0, 0, 1, 0] speed 100 mm/s blend fine tool t{k}")
    yield "end"


def _pseudo_speeds(n: int) -> Iterator[str]:
    yield "procedure main"
    for k in range(n):
        yield (
            f"move linear target [{k}, 0, 400] [0, 0, 1, 0] "
            f"speed {k + 1}.5 mm/s blend {k + 1}.25 mm"
        )
    yield "end"


PSEUDO: Final[Mapping[str, Lines]] = {
    "if in each other": _main(_pseudo_nested),
    "moves": _main(_pseudo_moves),
    "rows of a path": _main(_pseudo_path),
    "paths of one name": _main(_pseudo_paths),
    "labels and jumps": _main(_pseudo_labels),
    "loops": _main(_pseudo_loops),
    "cases": _main(_pseudo_cases),
    "messages": _main(_pseudo_messages),
    "procedures in a chain": _pseudo_calls,
    "variables": _pseudo_variables,
    "long names that are alike": _pseudo_like_names,
    "targets": _pseudo_targets,
    "signals": _pseudo_signals,
    "tools": _pseudo_tools,
    "speeds": _pseudo_speeds,
}
