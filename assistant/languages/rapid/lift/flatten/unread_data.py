"""Parts of flattened records that nothing reads, left out of the program.

A statement that only assigns to such a part becomes a comment with a mark, which is removed once
its finding is reported. Parameters of the parts are left out where every call can do without.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Any, Final

from assistant.base.data_classes import dataclass
from assistant.base.diagnostics import Span
from assistant.languages.rapid.lift.flatten.data_names import ProgramData, parameter_nodes
from assistant.languages.rapid.tree import syntax as s
from assistant.languages.rapid.tree.walk import nodes, root
from assistant.program.rewriting import rewrite

_MOST_ROUNDS: Final = 12
"""Maximum rounds of removal; a variable that only unread variables read is removed in the next
round.
"""


OMISSION_MARK: Final = "\0"
"""Comment in place of an omitted statement, until the program is exported to another language."""


@dataclass(frozen=True, slots=True)
class UnreadVariable:
    """A variable that is left out, and where the data that it was a part of is declared."""

    name: str
    span: Span | None


def without_unread_data(
    modules: Sequence[s.Module], program: ProgramData
) -> tuple[list[s.Module], list[tuple[UnreadVariable, ...]]]:
    """The modules without the made variables that nothing reads, and those of each."""
    left = list(modules)
    gone: set[str] = set()
    # Removing an assignment may leave the data that it read without a reader.
    for _ in range(_MOST_ROUNDS if program.made else 0):
        dead = _dead_variables(left, program) - gone
        if not dead:
            break
        gone |= dead
        cut = _DeadDataRemoval(dead, _dropped_parameters(left, dead, program))
        left = [cut.module(module) for module in left]
    told = []
    for before, after in zip(modules, left, strict=True):
        stay = {id(item) for item in after.items}
        told.append(
            tuple(
                UnreadVariable(item.name, item.span)
                for item in before.items
                if isinstance(item, s.Data) and item.name.lower() in gone and id(item) not in stay
            )
        )
    return left, told


def _dead_variables(modules: Sequence[s.Module], program: ProgramData) -> set[str]:
    """Made variables that nothing asks for but what is assigned to others of these."""
    named: Counter[str] = Counter()
    inside: Counter[str] = Counter()
    needs: dict[str, set[str]] = {}
    live: set[str] = set()
    for node in nodes(tuple(modules)):
        match node:
            case s.NameRef(name):
                named[name.lower()] += 1
            # The caller reads a value assigned to a parameter by reference.
            case s.ParameterNode(mode, _, name) if mode:
                live.add(name.lower())
            case s.Assignment(target, value) if (found := root(target)) is not None:
                key = found.name.lower()
                # An assignment that calls a routine of the program has to stay, and all that it
                # reads with it.
                if key in program.made and not _calls_own_routine((target, value), program):
                    for part in nodes((target, value)):
                        if isinstance(part, s.NameRef):
                            inside[part.name.lower()] += 1
                            needs.setdefault(key, set()).add(part.name.lower())
    # Whatever is named outside of such assignments is read.
    live |= {name for name, count in named.items() if count > inside[name]}
    pending = list(live)
    while pending:
        for name in needs.pop(pending.pop(), set()) - live:
            live.add(name)
            pending.append(name)
    return {name for name in program.made if name not in live}


def _calls_own_routine(value: Any, program: ProgramData) -> bool:
    """True if computing a value calls a routine of the program."""
    return any(
        isinstance(node, s.FunctionCall) and node.name.lower() in program.own
        for node in nodes(value)
    )


def _dropped_parameters(
    modules: Sequence[s.Module], dead: Collection[str], program: ProgramData
) -> Mapping[str, frozenset[int]]:
    """Places of parameters that nothing reads, by routine, where every call can do without."""
    found: dict[str, frozenset[int]] = {}
    counts: dict[str, int] = {}
    for module in modules:
        for item in module.items:
            if isinstance(item, s.Routine) and item.name.lower() in program.routines:
                plain = all(not g.optional and len(g.alternatives) == 1 for g in item.parameters)
                names = [one.name.lower() for one in parameter_nodes(item)]
                places = frozenset(at for at, name in enumerate(names) if name in dead)
                if plain and places:
                    found[item.name.lower()] = places
                    counts[item.name.lower()] = len(names)
    if not found:
        return {}
    for node in nodes(tuple(modules)):
        if not isinstance(node, s.ProcedureCall | s.FunctionCall):
            continue
        if not isinstance(node.name, str):
            return {}  # it may call any of them
        key = node.name.lower()
        if key in found:
            values = [a.value for a in node.arguments if isinstance(a, s.Positional)]
            if len(values) != counts[key] or len(values) != len(node.arguments):
                del found[key]
                continue
            # An argument that calls a routine has an effect and stays.
            busy = {at for at, value in enumerate(values) if _calls_own_routine(value, program)}
            found[key] = found[key] - busy
    return found


class _DeadDataRemoval:
    """Takes variables out of modules. dropped: places of parameters by routine."""

    def __init__(self, dead: Collection[str], dropped: Mapping[str, frozenset[int]]) -> None:
        self.dead, self.dropped = dead, dropped

    def module(self, module: s.Module) -> s.Module:
        items: list[s.Item] = []
        for item in module.items:
            match item:
                case s.Data(name=name) if name.lower() in self.dead:
                    continue
                case s.Routine():
                    items.append(self._routine(item))
                case _:
                    items.append(item)
        same = len(items) == len(module.items)
        same = same and all(a is b for a, b in zip(items, module.items, strict=True))
        return module if same else replace(module, items=tuple(items))

    def _routine(self, routine: s.Routine) -> s.Routine:
        body = tuple(self._body(routine.body))
        handlers = tuple(replace(h, body=tuple(self._body(h.body))) for h in routine.handlers)
        places = self.dropped.get(routine.name.lower(), frozenset())
        groups = tuple(g for at, g in enumerate(routine.parameters) if at not in places)
        changed = replace(routine, body=body, handlers=handlers, parameters=groups)
        return routine if changed == routine else changed

    def _body(self, body: Sequence[s.StatementNode]) -> Iterator[s.StatementNode]:
        for node in body:
            match node:
                case s.Data(name=name) if name.lower() in self.dead:
                    continue
                case s.Assignment(target) if (found := root(target)) is not None:
                    if found.name.lower() in self.dead:
                        yield s.CommentLine(OMISSION_MARK, span=node.span)
                        continue
            yield self._inside(node)

    def _inside(self, node: s.StatementNode) -> Any:
        """A statement without what is left out of the bodies and calls in it."""
        match node:
            case s.IfThen(branches, otherwise):
                made = tuple(
                    replace(b, condition=self._calling(b.condition), body=tuple(self._body(b.body)))
                    for b in branches
                )
                other = None if otherwise is None else tuple(self._body(otherwise))
                return replace(node, branches=made, otherwise=other)
            case s.CompactIf(condition, statement):
                inner = tuple(self._body((statement,)))
                if inner:
                    return replace(node, condition=self._calling(condition), statement=inner[0])
                return s.IfThen((s.IfBranch(self._calling(condition), ()),), span=node.span)
            case s.ForLoop(body=body) | s.WhileLoop(body=body):
                return replace(self._calling(replace(node, body=())), body=tuple(self._body(body)))
            case s.TestOf(subject, cases, otherwise):
                chosen = tuple(
                    replace(self._calling(replace(c, body=())), body=tuple(self._body(c.body)))
                    for c in cases
                )
                other = None if otherwise is None else tuple(self._body(otherwise))
                subject = self._calling(subject)
                return replace(node, subject=subject, cases=chosen, otherwise=other)
        return self._calling(node)

    def _calling(self, node: Any) -> Any:
        """A statement or expression whose calls give nothing for what is left out."""
        if not self.dropped or node is None:
            return node

        def change(part: Any) -> Any:
            match part:
                case s.ProcedureCall(str(name), given) | s.FunctionCall(str(name), given):
                    places = self.dropped.get(name.lower())
                    if places:
                        rest = tuple(one for at, one in enumerate(given) if at not in places)
                        return replace(part, arguments=rest)
            return part

        return rewrite(node, change, ())
