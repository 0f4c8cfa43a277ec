"""Vendor statements of a lifted program: the instruction in each, and its replacement.

A vendor statement holds its text; the instruction is read from it again. `with_lowered_calls`
replaces calls of named instructions, and of functions whose result is assigned, by neutral
statements.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator, Mapping
from dataclasses import field, replace
from typing import Any, Final, TypeAlias

from assistant.base.data_classes import dataclass
from assistant.languages.patterns import Called
from assistant.languages.rapid.lift.statements import NameResolver, lift_instruction
from assistant.languages.rapid.text import verbatim
from assistant.languages.rapid.tree import syntax as s
from assistant.languages.rapid.tree.walk import called, name_of
from assistant.program import expressions as e
from assistant.program import statements as p
from assistant.program.program import Program
from assistant.program.rewriting import Body, map_bodies

GATEWAY: Final = "gateway"
"""Option that frames a gateway message, see `tables/bytes.txt`."""


def is_vendor_text(record: Any) -> bool:
    return isinstance(record, p.Opaque | e.Verbatim) and record.language == verbatim.LANGUAGE


def instruction_of(node: p.Opaque) -> s.ProcedureCall | None:
    """The one instruction that a text of RAPID says."""
    if is_vendor_text(node):
        match verbatim.understood(verbatim.statements, node.text):
            case (s.ProcedureCall(name=str()) as call,):
                return call
    return None


def is_by_gateway(node: p.Statement) -> bool:
    """True if a statement says something to a gateway, or hears it."""
    call = instruction_of(node) if isinstance(node, p.Opaque) else None
    options = () if call is None else (a for a in call.arguments if isinstance(a, s.Option))
    return any(one.name.lower() == GATEWAY for one in options)


def word_of(call: s.ProcedureCall) -> str:
    """The instruction in lower case."""
    return str(call.name).lower()


def lifted_call(
    call: s.ProcedureCall, node: p.Opaque, meaning: NameResolver
) -> Iterator[p.Statement]:
    """The statement that a call is, if there is one, in the place of a text."""
    said = lift_instruction(call, meaning)
    if said is not None:
        yield replace(said, span=node.span)


def without_options(call: s.ProcedureCall, options: Collection[str]) -> s.ProcedureCall:
    """The call without some of its options, whose names are in lower case."""
    rest = tuple(
        one
        for one in call.arguments
        if not (isinstance(one, s.Option) and one.name.lower() in options)
    )
    return replace(call, arguments=rest)


Replacement: TypeAlias = Iterator[p.Statement]


@dataclass(frozen=True, slots=True)
class VendorCall:
    """call: of an instruction or a function. answer: of a function, where its result goes.

    sizes: the extents of arrays, by lower-case name.
    """

    call: Called[s.Expression]
    value: Callable[[s.Expression], e.Expression]
    answer: e.Expression | None = None
    sizes: Mapping[str, tuple[int, ...]] = field(default_factory=dict)

    @property
    def word(self) -> str:
        return self.call.word.lower()

    def given(self, at: int) -> e.Expression | None:
        node = self.call.given[at] if at < len(self.call.given) else None
        return None if node is None else self.value(node)

    def name(self, at: int) -> str:
        """The name that an argument is; raises NotExpressible for anything else."""
        node = self.call.given[at] if at < len(self.call.given) else None
        found = name_of(node)
        if not found:
            raise NotExpressible
        return found

    def option(self, name: str) -> e.Expression | None:
        node = self.call.options.get(name)
        return None if node is None else self.value(node)

    def only(self, *names: str) -> bool:
        """True if the call has no options except these."""
        return set(self.call.options) <= set(names)


class NotExpressible(Exception):
    """A call that has no other words in this form."""

    def __init__(self, reason: e.Reason | None = None) -> None:
        super().__init__()
        self.reason = reason


CallLowering: TypeAlias = Callable[[VendorCall, p.Statement], Replacement]


def with_lowered_calls(
    program: Program,
    instructions: Collection[str],
    functions: Collection[str],
    saying: CallLowering,
) -> Program:
    """Return the program with some of its calls lowered; a call remains unchanged if its lowering
    raises NotExpressible.

    instructions, functions: lower-case names; functions apply only where their result is assigned.
    """
    sizes = _array_sizes(program)

    def body(statements: Body) -> Body:
        return tuple(part for node in statements for part in said(node))

    def said(node: p.Statement) -> Replacement:
        call = _vendor_call(node, instructions, functions)
        if call is None:
            yield map_bodies(node, body)
            return
        call = replace(call, sizes=sizes)
        try:
            made = tuple(saying(call, node))
        except NotExpressible as unsaid:
            if isinstance(node, p.Opaque) and unsaid.reason is not None:
                node = replace(node, reason=unsaid.reason)
            yield node
            return
        yield from (replace(one, span=node.span) for one in made)

    procedures = tuple(replace(q, body=body(q.body)) for q in program.procedures)
    return replace(program, procedures=procedures)


def _array_sizes(program: Program) -> Mapping[str, tuple[int, ...]]:
    """The extents of arrays; of a name that several arrays have only where these are equal."""
    found: dict[str, set[tuple[int, ...]]] = {}
    for table in (program.variables, *(q.variables for q in program.procedures)):
        for name, variable in table.items():
            found.setdefault(name.lower(), set()).add(variable.size)
    return {name: sizes.pop() for name, sizes in found.items() if len(sizes) == 1}


def _vendor_call(
    node: p.Statement, instructions: Collection[str], functions: Collection[str]
) -> VendorCall | None:
    expression = NameResolver().expression
    match node:
        case p.Opaque(verbatim.LANGUAGE, text):
            match verbatim.understood(verbatim.statements, text):
                case (s.ProcedureCall(name=str(word)) as call,) if word.lower() in instructions:
                    found = called(call)
                    return None if found is None else VendorCall(found, expression)
        case p.Assign(target, e.Apply(function, given)) if function.lower() in functions:
            # Only names can be turned back into nodes of RAPID.
            names = [s.NameRef(one.name) for one in given if isinstance(one, e.Name)]
            if len(names) == len(given):
                return VendorCall(Called(function, names), expression, target)
        case p.Assign(target, e.Verbatim(verbatim.LANGUAGE, text)) if (
            text.partition("(")[0].strip().lower() in functions
        ):
            match verbatim.understood(verbatim.expression, text):
                case s.FunctionCall() as function_call:
                    found = called(function_call)
                    return None if found is None else VendorCall(found, expression, target)
    return None
