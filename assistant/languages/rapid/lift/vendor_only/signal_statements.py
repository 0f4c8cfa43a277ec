"""Signal statements that RAPID alone has: second names, pulses, inversion and delay.

A signal with a second name (`AliasIO`) is called by its first one, if the second stands for it all
through the program. `PulseDO` and `InvertDO` take the value that the output has not; a pulse lasts
0.2 s by default. `SetDO` with a delay waits, where no move begins meanwhile.
"""

from __future__ import annotations

import math
import re
from collections import Counter
from collections.abc import Container, Iterator
from dataclasses import replace
from typing import Any, Final

from assistant.base.diagnostics import Findings
from assistant.languages.patterns import Called
from assistant.languages.rapid import rules
from assistant.languages.rapid.lift.statements import NameResolver, lift_call
from assistant.languages.rapid.lift.vendor_statements import instruction_of, word_of
from assistant.languages.rapid.tables.signals import SIGNAL_TYPES
from assistant.languages.rapid.text import verbatim
from assistant.languages.rapid.tree import syntax as s
from assistant.languages.rapid.tree.walk import called
from assistant.program import expressions as e
from assistant.program import statements as p
from assistant.program.analysis.io_use import OFF_VALUES
from assistant.program.program import Declaration, Program, Signal, walk
from assistant.program.rewriting import Body, map_bodies, records, rewrite
from assistant.program.vendor_statements import effect_of

_DEFAULT_PULSE: Final = e.Number(0.2)
"""Seconds of a pulse that states none (RAPID reference manual, PulseDO)."""
_MOVING_WORDS: Final = ("move", "trigg", "arc", "paint", "search", "spot", "disp", "mtrigg")
"""How names of instructions begin that move the robot."""
_ZERO, _ONE = e.Number(0), e.Number(1)


def switched_outputs(program: Program) -> frozenset[str]:
    """Lower-case names of outputs that something may switch on, and not only for a pulse."""
    found: set[str] = set()
    for record in records((program.procedures, program.declarations)):
        match record:
            case p.SetSignal(name, value, pulse) | p.Trigger(name, value, pulse=pulse):
                # A pulse ends by itself, so the output is off again for the next one.
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
    seconds = _DEFAULT_PULSE if length is None else meaning.expression(length)
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


def delayed_output(
    call: Called[s.Expression],
    meaning: NameResolver,
    findings: Findings,
    *,
    moves: bool,
) -> Iterator[p.Statement]:
    r"""`SetDO \SDelay`: the program waits and sets the output then, if it has another value.

    A pulse of the value that the output has would not wait, but what it leaves is not documented.
    moves: whether the robot moves while the delay lasts; then the instruction stays.
    """
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
    if moves:
        findings.append(rules.SET_ON_WAY(name=signal))
        return
    findings.append(rules.DELAY_WAITS(name=signal))
    changes = e.Binary("=", e.Name(signal), e.Number(1 - after.value))
    later = p.Wait(meaning.expression(delay)), p.SetSignal(signal, after)
    yield p.If((p.Branch(changes, later),))


def delays_into_moves(program: Program) -> frozenset[int]:
    r"""`id`s of the `SetDO \SDelay` behind which a move begins before the delay is surely over."""
    found: set[int] = set()

    def body(statements: Body) -> Body:
        for place, node in enumerate(statements):
            map_bodies(node, body)
            delay = _delay_of(node)
            if delay is not None and _moves_within(statements[place + 1 :], delay):
                found.add(id(node))
        return statements

    for procedure in program.procedures:
        body(procedure.body)
    return frozenset(found)


def _delay_of(node: p.Statement) -> float | None:
    r"""Seconds of a `SetDO \SDelay`, without end if they are worked out; None for all else."""
    call = instruction_of(node) if isinstance(node, p.Opaque) else None
    known = None if call is None or word_of(call) != "setdo" else called(call)
    delay = None if known is None else known.options.get("sdelay")
    if delay is None:
        return None
    return float(delay.text) if isinstance(delay, s.NumberLiteral) else math.inf


def _moves_within(statements: Body, seconds: float) -> bool:
    """True if a move begins in the seconds before the first statements."""
    for node in statements:
        match node:
            case p.Move() | p.MoveCircular() | p.MoveJoints() | p.Follow():
                return True
            case p.Wait(e.Number(waited)):
                seconds -= waited
                if seconds <= 0:
                    return False
            case p.Opaque():
                call = instruction_of(node)
                if call is not None and word_of(call).startswith(_MOVING_WORDS):
                    return True
            case p.SetSignal() | p.Assign() | p.Comment():
                continue
            case _:
                return False  # what lasts for an unknown time, or leads elsewhere
    return False


def _digital_output(call: Called[s.Expression], meaning: NameResolver) -> str | None:
    """The name of the output that a call is about, which is digital then."""
    match call.given:
        case (s.NameRef() as node, *_):
            # Reading it as SetDO notes the kind of the signal, and refuses what is no signal.
            said = lift_call(Called("SetDO", (node, s.NumberLiteral("1"))), meaning)
            return said.signal if isinstance(said, p.SetSignal) else None
    return None


def with_aliases(program: Program) -> Program:
    """Return the program without aliases that mean one signal throughout.

    The removed aliases are declared, get their signal from one `AliasIO`, and appear in no other
    vendor statement.
    """
    given: Counter[str] = Counter()
    meant: dict[str, str] = {}
    for node in program.statements():
        if isinstance(node, p.Opaque) and (pair := _alias_of(node)) is not None:
            given[pair[1]] += 1
            meant[pair[1]] = pair[0]
    if not meant:
        return program
    declared = {name: signal for d in program.declarations for name, signal in _declared_signals(d)}
    inside = {
        name
        for q in program.procedures
        for node in walk(q.body)
        if isinstance(node, p.Opaque)
        for name, _ in _declared_signals(node)
    }
    known = {*program.variables, *(n for q in program.procedures for n in q.variables)}
    data = {name.lower() for name in known}
    names = {
        alias: source
        for alias, source in meant.items()
        # A name that is given twice may mean another signal in each place.
        if given[alias] == 1
        and alias in declared
        and alias not in inside
        and source.lower() not in data
        and source.lower() not in declared
    }
    names = {
        alias: source for alias, source in names.items() if not _is_named_in_text(program, alias)
    }
    return _with_signal_names(program, names, declared) if names else program


def _alias_of(node: p.Opaque) -> tuple[str, str] | None:
    """Return the signal and its lower-case alias; None if the statement does not give the signal by
    name.
    """
    call = instruction_of(node)
    if call is None or word_of(call) != "aliasio":
        return None
    found = called(call)
    match found.given if found is not None else ():
        case (s.NameRef(source) | s.StringLiteral(source), s.NameRef(alias)):
            return source, alias.lower()
    return None


def _declared_signals(kept: Declaration | p.Opaque) -> list[tuple[str, Signal]]:
    read = verbatim.items if isinstance(kept, Declaration) else verbatim.statements
    match verbatim.understood(read, kept.text):
        case (s.Data(type=type, name=str(name), dimensions=()),) if type.lower() in SIGNAL_TYPES:
            return [(name.lower(), SIGNAL_TYPES[type.lower()])]
    return []


def _is_named_in_text(program: Program, alias: str) -> bool:
    """True if a vendor statement or declaration that remains names the alias."""
    word = re.compile(rf"\b{re.escape(alias)}\b", re.IGNORECASE)
    # Text cannot be renamed, so any mention in it keeps the alias.
    for record in records((program.procedures, program.declarations)):
        if isinstance(record, p.Opaque | e.Verbatim | Declaration) and word.search(record.text):
            of_alias = isinstance(record, p.Opaque) and _alias_of(record) is not None
            if not of_alias and not (isinstance(record, Declaration) and _declared_signals(record)):
                return True
    return False


def _with_signal_names(
    program: Program, names: dict[str, str], declared: dict[str, Signal]
) -> Program:
    def named(part: Any) -> Any:
        match part:
            case p.SetSignal(name) | p.WaitSignal(name) | p.Trigger(name):
                return replace(part, signal=names.get(name.lower(), name))
            case e.Name(name) if name.lower() in names:
                return e.Name(names[name.lower()])
        return part

    def gone(node: p.Statement) -> bool:
        pair = _alias_of(node) if isinstance(node, p.Opaque) else None
        return pair is not None and pair[1] in names

    def body(statements: Body) -> Body:
        return tuple(map_bodies(node, body) for node in statements if not gone(node))

    procedures = tuple(replace(q, body=body(rewrite(q.body, named))) for q in program.procedures)
    left = tuple(
        d for d in program.declarations if not any(n in names for n, _ in _declared_signals(d))
    )
    signals = {n: x for n, x in program.signals.items() if n.lower() not in names}
    there = {n.lower() for n in signals}
    for alias, source in names.items():
        # Two aliases may mean one signal.
        if source.lower() not in there:
            there.add(source.lower())
            signals[source] = declared[alias]
    return replace(program, procedures=procedures, declarations=left, signals=signals)
