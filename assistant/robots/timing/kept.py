"""Whether vendor text may move the arm, itself or in what it calls."""

from __future__ import annotations

from assistant.program.expressions import Effect
from assistant.program.program import Program
from assistant.program.rewriting import records
from assistant.program.statements import Call, Moving, Opaque
from assistant.program.vendor_statements import effect_of


class VendorMotion:
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
        """Whether a routine, in lower case, or one that it calls may move the arm."""
        if name not in self._moving:
            reached, pending = {name}, [name]
            while pending and name not in self._moving:
                moves, calls = self._does(pending.pop())
                if moves:
                    self._moving[name] = True
                pending += sorted(calls - reached)
                reached |= calls
            self._moving.setdefault(name, False)
        return self._moving[name]

    def _does(self, name: str) -> tuple[bool, set[str]]:
        """Whether a routine moves by itself, as one that is not there may; and what it calls."""
        procedure = self._program.procedure(name)
        if procedure is None:
            effects = self._declared.get(name)
            if effects is None:
                return True, set()
            return any(one.moves for one in effects), {c for one in effects for c in one.calls}
        moves, calls = False, set[str]()
        for record in records(procedure.body):
            match record:
                case Call(called):
                    calls.add(called.lower())
                case Opaque():
                    effect = effect_of(record)
                    moves |= effect.moves
                    calls |= effect.calls
            moves |= isinstance(record, Moving)
        return moves, calls
