"""Whether vendor text may move the arm, itself or in what it calls."""

from __future__ import annotations

from assistant.program.effects import Effect
from assistant.program.kept import effect_of
from assistant.program.program import Program
from assistant.program.rewriting import records
from assistant.program.statements import Call, Moving, Opaque


class KeptMotion:
    """Of a program's kept text, as far as the program holds the routines that are called."""

    def __init__(self, program: Program) -> None:
        self._program = program
        self._declared: dict[str, list[Effect]] = {}
        for declaration in program.declarations:
            effect = effect_of(declaration)
            for name in effect.writes:
                self._declared.setdefault(name, []).append(effect)
        self._moving: dict[str, bool] = {}

    def possible(self, effect: Effect) -> bool:
        """Whether the arm may be elsewhere behind it."""
        return effect.moves or any(map(self._moves, sorted(effect.calls)))

    def _moves(self, name: str) -> bool:
        """A routine, in lower case; one that the program does not hold may."""
        if name not in self._moving:
            self._moving[name] = False  # a call of itself adds nothing
            self._moving[name] = self._does_move(name)
        return self._moving[name]

    def _does_move(self, name: str) -> bool:
        procedure = self._program.procedure(name)
        if procedure is None:
            effects = self._declared.get(name)
            return effects is None or any(map(self.possible, effects))
        for record in records(procedure.body):
            match record:
                case Call(called) if self._moves(called.lower()):
                    return True
                case Opaque() if self.possible(effect_of(record)):
                    return True
            if isinstance(record, Moving):
                return True
        return False
