"""Commands about signals: inputs, outputs, registers of a field bus, and hands."""

from __future__ import annotations

from collections.abc import Callable
from typing import Final

from assistant.virtual.cr.command import Command, bare, hexadecimal, parts, whole
from assistant.virtual.cr.state import FIRST_HAND, HANDS, CrSession
from assistant.virtual.cr.store import CrRefusal
from assistant.virtual.kernel.signals import Signals

WORD_BITS: Final = 16
LAST_SIGNAL: Final = 32767
REGISTERS: Final = range(6000, 6256)
"""Of CC-Link."""
MOST_REGISTERS: Final = 16
SHOWN_HANDS: Final = 8


def _read_inputs(session: CrSession, argument: str) -> str:
    session.state.machinery.feel()
    return _signal_word(session.state.board.inputs, argument)


def _read_outputs(session: CrSession, argument: str) -> str:
    return _signal_word(session.state.board.outputs, argument)


def _read_signals(session: CrSession, argument: str) -> str:
    first, second = parts(argument, 2)
    return _read_inputs(session, first) + _read_outputs(session, second)


def _signal_word(signals: Signals, argument: str) -> str:
    first = whole(argument, 0, LAST_SIGNAL, error=6600)
    return f"{sum(bool(signals.read(str(first + i))) << i for i in range(WORD_BITS)):04X}"


def _set_outputs(session: CrSession, argument: str) -> str:
    return _between_statements(session, lambda: _set_word(session.state.board.outputs, argument))


def _set_inputs(session: CrSession, argument: str) -> str:
    if session.state.real_inputs is None:
        raise CrRefusal(6630)
    return _between_statements(session, lambda: _set_word(session.state.board.inputs, argument))


def _between_statements(session: CrSession, change: Callable[[], None]) -> str:
    """Signals change between two statements of the programs that see them."""
    session.state.machinery.do(change)
    return ""


def _set_word(signals: Signals, argument: str) -> None:
    number, value = parts(argument, 2)
    first, word = whole(number, 0, LAST_SIGNAL, error=6600), hexadecimal(value, 4)
    for bit in range(WORD_BITS):
        signals.set(str(first + bit), float(word >> bit & 1))


def _read_input_registers(session: CrSession, argument: str) -> str:
    return _register_values(session.state.board.inputs, argument)


def _read_output_registers(session: CrSession, argument: str) -> str:
    return _register_values(session.state.board.outputs, argument)


def _register_values(signals: Signals, argument: str) -> str:
    first = _register_number(argument)
    return ";".join(str(int(signals.read(f"register{first + i}"))) for i in range(MOST_REGISTERS))


def _register_number(argument: str) -> int:
    return whole(argument, REGISTERS.start, REGISTERS.stop - 1, error=7780)


def _set_output_register(session: CrSession, argument: str) -> str:
    return _between_statements(
        session, lambda: _set_register(session.state.board.outputs, argument)
    )


def _set_input_register(session: CrSession, argument: str) -> str:
    if session.state.real_inputs is None:
        raise CrRefusal(6630)
    return _between_statements(session, lambda: _set_register(session.state.board.inputs, argument))


def _set_register(signals: Signals, argument: str) -> None:
    number, value = parts(argument, 2)
    signals.set(f"register{_register_number(number)}", float(hexadecimal(value, 4)))


def _use_pseudo_inputs(session: CrSession) -> str:
    """From now on IN= writes the inputs."""
    state = session.state
    if state.real_inputs is None:
        state.real_inputs = dict(state.board.inputs.values)
    return ""


def _use_real_inputs(session: CrSession) -> str:
    """The inputs are again what they were before they became pseudo inputs."""
    state = session.state
    before, state.real_inputs = state.real_inputs, None
    inputs = state.board.inputs

    def restore() -> None:
        for name in list(inputs.values) if before is not None else ():
            inputs.set(name, (before or {}).get(name, 0.0))

    return _between_statements(session, restore)


def _reset_outputs(session: CrSession) -> str:
    """All general outputs are off."""
    outputs = session.state.board.outputs
    hands = range(FIRST_HAND, FIRST_HAND + 2 * HANDS)

    def reset() -> None:
        for name in list(outputs.values):
            if name.isdigit() and int(name) not in hands:
                outputs.set(name, 0.0)

    return _between_statements(session, reset)


# --------------------------------------------------------------------------------------- hands


def _hand_command(*, opens: bool) -> Command:
    def handler(session: CrSession, argument: str) -> str:
        session.state.order_hand(whole(argument, 1, HANDS), opens)
        return ""

    return Command(handler)


def _read_hands(session: CrSession) -> str:
    """Eight times signal, 1 open or 2 closed, 1 for two valves; -1 for a hand that is not there."""
    told = []
    for hand in range(1, SHOWN_HANDS + 1):
        if hand > HANDS:
            told.append("-1;-1;-1")
        else:
            is_open = session.state.hands[hand]
            told.append(f"{FIRST_HAND + 2 * (hand - 1)};{1 if is_open else 2};1")
    return ";".join(told)


SIGNAL_COMMANDS: Final = {
    "IOSIGNAL": Command(_read_signals),
    "IN": Command(_read_inputs),
    "OUT": Command(_read_outputs),
    "OUT=": Command(_set_outputs),
    "IN=": Command(_set_inputs),
    "DIN": Command(_read_input_registers),
    "DOUT": Command(_read_output_registers),
    "DIN=": Command(_set_input_register),
    "DOUT=": Command(_set_output_register),
    "INDMY": Command(bare(_use_pseudo_inputs)),
    "INSET": Command(bare(_use_real_inputs)),
    "RSTIO": Command(bare(_reset_outputs)),
    "HNDON": _hand_command(opens=True),
    "HNDOFF": _hand_command(opens=False),
    "HNDSTS": Command(bare(_read_hands)),
}
