"""Signals that are set and waited for, for a language that addresses them by their bits.

An error tells of a number that the bits of a signal cannot hold.
"""

from __future__ import annotations

from collections.abc import Iterator

from assistant.program import expressions as e
from assistant.program import statements as p
from assistant.program.passes.rewording import Rewording


def set_signal(r: Rewording, node: p.SetSignal) -> Iterator[p.Statement]:
    check_fit(r, node.signal, node.value)
    yield node


def wait_signal(r: Rewording, node: p.WaitSignal) -> Iterator[p.Statement]:
    """One for another value than a number, or for an analog signal, is a wait for a condition."""
    if isinstance(node.value, e.Number) and not _is_analog(r, node.signal):
        check_fit(r, node.signal, node.value)
        yield node
    else:
        condition = e.Binary("=", e.Name(node.signal), node.value)
        yield p.WaitUntil(condition, node.timeout, span=node.span)


def wait_until(r: Rewording, node: p.WaitUntil) -> Iterator[p.Statement]:
    """One for bits of a signal and a number is a wait for the signal."""
    match node.condition:
        case e.Binary("=", e.Name(name)) if _is_analog(r, name):
            yield node
        case e.Binary("=", e.Name(name), e.Number() as value) if r.spelling.signal(name):
            check_fit(r, name, value)
            yield p.WaitSignal(name, value, node.timeout, span=node.span)
        case e.Name(name) if r.spelling.signal(name):
            yield p.WaitSignal(name, e.Number(1), node.timeout, span=node.span)
        case _:
            yield node


def _is_analog(r: Rewording, name: str) -> bool:
    signal = r.spelling.signal(name)
    return signal is not None and signal.kind == "analog"


def check_fit(r: Rewording, name: str, value: e.Expression) -> None:
    """An error where a digital signal or a group is to have what its bits cannot hold."""
    signal, rule = r.spelling.signal(name), r.job.can.no_fit
    if signal is None or signal.kind == "analog" or not isinstance(value, e.Number):
        return
    most = (1 << signal.bits) - 1
    if rule and not (0 <= value.value <= most and value.value == int(value.value)):
        bits = "1 bit" if signal.bits == 1 else f"{signal.bits} bits"
        r.job.findings.append(rule(bits=bits, name=name, value=value.value, most=most))
