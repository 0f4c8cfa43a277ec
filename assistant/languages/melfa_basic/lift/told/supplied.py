"""Functions of MELFA-BASIC that a program gets as procedures of its own: `tables/library.txt`."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

from assistant.languages.melfa_basic.tables.library import library, library_calls
from assistant.program import expressions as e
from assistant.program.program import Program
from assistant.program.rewriting import rewrite


class LibraryProcedures:
    """The procedures of the library that a program calls, under names that it has free.

    free: gives a name that nothing has yet.
    """

    def __init__(self, free: Callable[[str], str]) -> None:
        self._free = free
        self._names: dict[str, str] = {}

    def name(self, key: str) -> str:
        """What a procedure of the library is called in the program, which it is added to."""
        if key not in self._names:
            self._names[key] = self._free(key)
            for other in sorted(library_calls(library()[key])):
                self.name(other)
        return self._names[key]

    def added(self, program: Program) -> Program:
        """The program with the procedures that were asked for."""
        if not self._names:
            return program

        def named(node: Any) -> Any:
            match node:
                case e.Apply(function, given) if function in self._names:
                    return e.Apply(self._names[function], given)
            return node

        made = tuple(
            rewrite(replace(library()[key], name=name), named, ())
            for key, name in self._names.items()
        )
        return replace(program, procedures=(*program.procedures, *made))
