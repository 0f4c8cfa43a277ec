"""The stored programs of a controller, read for the interpreter when they are first needed."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

from assistant import languages
from assistant.base.budgets import STORED, within
from assistant.base.diagnostics import Refused
from assistant.languages.melfa_basic.tree import syntax as s
from assistant.virtual.cr import cells
from assistant.virtual.cr.store import ENCODING, CrProgram
from assistant.virtual.events import Place
from assistant.virtual.melfa.machine import Machine


class Library:
    """source: a stored program by its name, None if there is none."""

    def __init__(self, language: str, source: Callable[[str], CrProgram | None]) -> None:
        self.source = source
        self._language = languages.get(language)
        self._files: dict[str, s.File] = {}

    def file(self, name: str) -> s.File | None:
        """A program by its name in capitals."""
        if name not in self._files:
            program = self.source(name)
            if program is None:
                return None
            text = self._language.decode(program.text().encode(ENCODING), name)
            try:
                with within(STORED, name, len(text.text)):
                    file = self._language.parse(text)
            except Refused as refused:  # told as what is wrong in it when it is to run
                file = replace(self._language.parse(""), findings=refused.findings)
            assert isinstance(file, s.File)
            self._files[name] = file
        return self._files[name]

    def prepare(self, name: str) -> None:
        """Reads a program and those that it calls, so that no program that runs waits for that."""
        waiting, seen = [name], set[str]()
        while waiting:
            one = waiting.pop()
            file = None if one in seen else self.file(one)
            seen.add(one)
            if file is not None:
                called = self._language.called_files(file)
                waiting += [other.partition(".")[0].upper() for other in called]

    def ready(self, name: str, machine: Machine) -> None:
        """A program begins with the values that its variables have in the store."""
        program = self.source(name)
        for line in program.values.values() if program is not None else ():
            variable, _, value = line.partition("=")
            cells.set_variable(machine.main, variable, value)

    def forget(self, name: str) -> None:
        self._files.pop(name, None)

    def steps(self, name: str) -> list[int]:
        """The line numbers of a program, none if there is no such program."""
        program = self.source(name) if name else None
        return sorted(program.steps) if program is not None else []

    def line(self, place: Place | None) -> int:
        """The number of the line at a place of a program, 0 for none."""
        name, at = place or ("", 0)
        steps = self.steps(name)
        return steps[at - 1] if 1 <= at <= len(steps) else 0
