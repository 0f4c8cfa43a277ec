"""Outputs that are pulsed, inverted or set later: as pulses of the one or the other value."""

from __future__ import annotations

from collections.abc import Container, Iterator
from typing import Final

from assistant.base.diagnostics import Findings
from assistant.languages.patterns import Called
from assistant.languages.rapid import rules
from assistant.languages.rapid.lift.instructions import NameResolver, lift_call
from assistant.languages.rapid.tree import syntax as s
from assistant.program import expressions as e
from assistant.program import statements as p
from assistant.program.analysis.io_use import OFF_VALUES
from assistant.program.program import Program
from assistant.program.rewriting import records
from assistant.program.vendor_statements import effect_of

DEFAULT_PULSE: Final = e.Number(0.2)
"""Seconds of a pulse that states none (RAPID reference manual, PulseDO)."""
_ZERO, _ONE = e.Number(0), e.Number(1)


def switched_outputs(program: Program) -> frozenset[str]:
    """Lower-case names of outputs that something may switch on, and not only for a pulse."""
    found: set[str] = set()
    for record in records((program.procedures, program.declarations)):
        match record:
            case p.SetSignal(name, value, pulse) | p.Trigger(name, value, pulse=pulse):
                if pulse is None and value not in OFF_VALUES:
                    found.add(name.lower())
            case p.Opaque() as kept if not kept.text.lower().startswith("pulsedo"):
                found |= effect_of(kept).names
            case e.Verbatim() as kept:
                found |= effect_of(kept).writes
    for declaration in program.declarations:
        found |= effect_of(declaration).names
    return frozenset(found)


def inverse_pulse(
    call: Called[s.Expression], meaning: NameResolver, on: Container[str], findings: Findings
) -> Iterator[p.Statement]:
    r"""`PulseDO` without `\High`: the value that the output does not have.

    on: lower-case names of outputs that may be on there.
    """
    signal = _digital_output(call, meaning)
    length = call.options.get("plength")
    if signal is None or call.options.keys() - {"plength"} or len(call.given) != 1:
        return
    seconds = DEFAULT_PULSE if length is None else meaning.expression(length)
    if signal.lower() in on:
        yield _other_value(signal, seconds)
    else:
        findings.append(rules.PULSE_FROM_OFF(name=signal))
        yield p.SetSignal(signal, _ONE, seconds)


def inverted_output(call: Called[s.Expression], meaning: NameResolver) -> Iterator[p.Statement]:
    """`InvertDO`."""
    signal = _digital_output(call, meaning)
    if signal is not None and len(call.given) == 1 and not call.options:
        yield _other_value(signal, None)


def _other_value(signal: str, seconds: e.Expression | None) -> p.If:
    """The other value than that which an output has, for some seconds or from now on."""
    is_off = e.Binary("=", e.Name(signal), _ZERO)
    on, off = (p.SetSignal(signal, value, seconds) for value in (_ONE, _ZERO))
    return p.If((p.Branch(is_off, (on,)),), (off,))


def delayed_output(call: Called[s.Expression], meaning: NameResolver) -> Iterator[p.Statement]:
    r"""`SetDO \SDelay`: until then the output has the value that it has, which is a pulse of it."""
    signal, delay = _digital_output(call, meaning), call.options.get("sdelay")
    if signal is None or delay is None or len(call.options) != 1 or len(call.given) != 2:
        return
    value = None if call.given[1] is None else meaning.known(meaning.expression(call.given[1]))
    match value:
        case e.Number(number):
            after = e.Number(int(number != 0))
        case e.Name(name) if name.lower() in ("high", "low"):
            after = e.Number(int(name.lower() == "high"))
        case _:
            return
    before = e.Number(1 - after.value)
    changes = e.Binary("=", e.Name(signal), before)
    later = p.SetSignal(signal, before, meaning.expression(delay))
    yield p.If((p.Branch(changes, (later,)),))


def _digital_output(call: Called[s.Expression], meaning: NameResolver) -> str | None:
    """The name of the output that a call is about, which is digital then."""
    match call.given:
        case (s.NameRef() as node, *_):
            said = lift_call(Called("SetDO", (node, s.NumberLiteral("1"))), meaning)
            return said.signal if isinstance(said, p.SetSignal) else None
    return None
