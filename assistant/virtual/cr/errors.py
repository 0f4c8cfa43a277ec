"""Commands about errors: the present one, what numbers mean, the history and its summary."""

from __future__ import annotations

from typing import Final

from assistant.virtual.cr.command import Command, bare, place, whole
from assistant.virtual.cr.error_log import LEVELS, error_level, error_message
from assistant.virtual.cr.state import CrSession

MOST_SUMMARIES: Final = 100


def _read_error(session: CrSession) -> str:
    alarm = session.state.alarm
    return f"{alarm[0]:04};{alarm[1]}" if alarm else ""


def _reset_alarm(session: CrSession) -> str:
    session.state.reset_error()
    return ""


def _read_message(session: CrSession, argument: str) -> str:
    del session
    return error_message(whole(argument, 1, 9999))


def _read_history(session: CrSession, argument: str) -> str:
    return _history_entry(session, argument, "0", "")


def _read_level_history(session: CrSession, argument: str) -> str:
    where, level, detail, *_ = [*argument.split(";"), "", ""]
    return _history_entry(session, where, level or "0", detail)


def _history_entry(session: CrSession, where: str, level: str, detail: str) -> str:
    """TOP is the newest; +1 goes to older ones."""
    entries = session.state.log.of(whole(level, 0, 3), detail)
    at = place(where, session.following.get("errors", 0), range(len(entries)))
    session.following["errors"] = min(at + 1, len(entries))
    return entries[at].fields if at < len(entries) else ""


def _clear_history(session: CrSession, argument: str) -> str:
    state = session.state
    state.log.clear(whole(argument, 0, 3))
    state.log.since["0"] = state.now()
    return ""


def _read_summary(session: CrSession, argument: str) -> str:
    log = session.state.log
    numbers = sorted(log.counts)
    at = whole(argument, 1, MOST_SUMMARIES) - 1
    if at >= len(numbers):
        return f"{len(numbers)};000000000;;;;;0"
    number = numbers[at]
    letter = next(letter for letter, level in LEVELS.items() if level == error_level(number))
    text = error_message(number)
    return f"{len(numbers)};{number:04}00000;{letter};{text};{text};;{log.counts[number]}"


def _read_dated_summary(session: CrSession, argument: str) -> str:
    log = session.state.log
    numbers = sorted(log.counts)
    at = int(argument) - 1 if argument.isdigit() else 0
    told = _read_summary(session, argument)
    return (
        f"{told};{log.latest[numbers[at]]:%y-%m-%d;%H:%M:%S}" if at < len(numbers) else f"{told};;"
    )


def _clear_summary(session: CrSession) -> str:
    state = session.state
    state.log.clear_summary()
    state.log.since["1"] = state.now()
    return ""


def _summary_date(session: CrSession, argument: str) -> str:
    state = session.state
    kind = str(whole(argument, 0, 1))
    return f"{state.log.since.get(kind, state.began):%y-%m-%d;%H:%M:%S}"


ERROR_COMMANDS: Final = {
    "ERROR": Command(bare(_read_error)),
    "RSTALRM": Command(bare(_reset_alarm)),
    "ERRORMES": Command(_read_message),
    "ERRORLOG": Command(_read_history),
    "ERRLOG2=": Command(_read_level_history),
    "ERRLOGCLR": Command(_clear_history),
    "ERRSUM": Command(_read_summary),
    "ERRSUM2=": Command(_read_dated_summary),
    "ERRSUMCLR": Command(bare(_clear_summary)),
    "SUMDATE": Command(_summary_date),
}
