"""Commands of the link for maintenance: errors and their history, parameters, meters, restart.

The virtual controller does not measure anything: it answers values of a healthy robot at rest,
those that BFP-A4288 shows where it shows some. The slot table is a set of parameters.
"""

from __future__ import annotations

from typing import Final

from assistant.virtual.cr.command import (
    VT,
    Command,
    at_once,
    bare,
    fixed,
    hexadecimal,
    parts,
    place,
    whole,
)
from assistant.virtual.cr.state import (
    LEVELS,
    TASKMAX,
    VALUE_SEPARATOR,
    CrSession,
    error_level,
    error_message,
)
from assistant.virtual.cr.store import CrRefusal, checked_name

_BATTERY: Final = 14600
"""Hours that a battery lasts: 2715 and 11885 in the sample of PTIME."""
AXES: Final = 8
_ORIGIN: Final = "Z2UOGQ;Z2VX5I;Z2#46Z;Z2NXW5;004QA5;0XB462;Y91%K5"
"""Origin data with their check sum, as BFP-A4288 shows them."""
_ORIGIN_TYPES: Final = ("0", "1", "3", "4", "5", "7")
_OPTION_SLOTS: Final = 3
_ALL_METERS: Final = "Z"


def _zero_values(count: int, zero: str = "0") -> Command:
    return fixed(";".join([zero] * count))


def _read_meters(session: CrSession) -> str:
    """Power, servos of all and of the first mechanism, 14 unused, programs, unused, battery used
    and left, mechanisms.
    """
    hours = session.state.hours
    left = max(_BATTERY - hours["B"], 0)
    told = [hours["T"], hours["S"], hours["S"], *[0] * 14, hours["D"], 0, hours["B"], left, 1]
    return ";".join(map(str, told))


def _clear_meter(session: CrSession, argument: str) -> str:
    hours = session.state.hours
    if argument != _ALL_METERS and argument not in hours:
        raise CrRefusal(4460)
    for kind in hours if argument == _ALL_METERS else [argument]:
        hours[kind] = 0
    return ""


def _read_battery(session: CrSession) -> str:
    hours = session.state.hours
    return f"{hours['S']};{max(_BATTERY - hours['B'], 0)}"


def _read_option(session: CrSession, argument: str) -> str:
    """The network; the other slots are empty."""
    if whole(argument or "1", 1, _OPTION_SLOTS) > 1:
        return ""
    parameters = session.state.parameters
    ports = parameters["NETPORT"]
    counts = "/".join(["1"] + ["0"] * 8)
    return "\v".join(
        [
            f"Ethernet;IP Addr {parameters['NETIP'][0]}",
            f"PortNo(R-time) {ports[0]}",
            f"PortNo(OPT11-19) {'/'.join(ports[1:])}",
            f"Connect Count(OPT11-19) {counts}",
            "MAC Addr 00:00:00:00:00:00",
            "H/W Ver: 0",
        ]
    )


def _read_currents(session: CrSession, argument: str) -> str:
    del session
    return ";".join(["0.00"] * AXES * (3 if whole(argument, 0, 1) else 4))


def _release_brakes(session: CrSession, argument: str) -> str:
    """They have no effect: nothing pulls at the arm here. Servos must be off."""
    if hexadecimal(argument, 2) and session.state.servo:
        raise CrRefusal(5640)
    return ""


def _set_origin(session: CrSession, argument: str) -> str:
    """The origin is where it was: the arm knows its joints."""
    kind, axes = parts(argument, 2)
    hexadecimal(axes, 2)
    if kind not in _ORIGIN_TYPES:
        raise CrRefusal(5410)
    _refuse_servo_on(session)
    return ""


def _set_origin_data(session: CrSession, argument: str) -> str:
    if len(argument.split(";")) not in (7, 9):
        raise CrRefusal(4460)
    _refuse_servo_on(session)
    return ""


def _refuse_servo_on(session: CrSession) -> None:
    if session.state.servo:
        raise CrRefusal(5640)


def _read_forecast(session: CrSession, argument: str) -> str:
    del session
    whole(argument, 0, 2)
    return ";".join(["23999"] * 6 + ["0"] * 2)


def _reset_forecast(session: CrSession, argument: str) -> str:
    del session
    for part in parts(argument, 2):
        hexadecimal(part, 2)
    return ""


def _set_forecast_dates(session: CrSession, argument: str) -> str:
    whole(argument, 1, 3)
    when = f"{session.state.began:%Y/%m/%d;%H:%M:%S}"
    return ";".join([when] * AXES + ["0"] * AXES)


def _restart(session: CrSession) -> str:
    session.state.restart()
    return ""


MAINTENANCE_COMMANDS: Final = {
    "PTIME": Command(bare(_read_meters)),
    "PTIMEDEL=": Command(_clear_meter),
    "ENCBATTM": Command(bare(_read_battery)),
    "OPNUMRD": fixed(str(_OPTION_SLOTS)),
    "OPSTSRD": Command(_read_option),
    "THMRD": fixed("39.5"),
    "ETEMP": fixed("38;39;41;39;36;36;0;0;41;42;44;41;38;37;0;0"),
    "EMISS": _zero_values(AXES),
    "SRVENC": _zero_values(4 * AXES),
    "SRVDRP": _zero_values(2 * AXES),
    "SRVSPD": _zero_values(3 * AXES),
    "SRVCUR": Command(_read_currents),
    "SRVLCR": _zero_values(2 * AXES, "0.00"),
    "SRVVOL": _zero_values(3 + AXES),
    "SVMONRST=": fixed(""),
    "RAREAD=": fixed("1;VIRTUAL001;2014/04/09 17:14:02"),
    "BREAKON": Command(_release_brakes, right=True),
    "BREAKONF": Command(_release_brakes),
    "HOME": Command(_set_origin, right=True),
    "AXDATINST": Command(bare(lambda _: ""), right=True),
    "DATINST": Command(_set_origin_data, right=True),
    "DATRD": fixed(_ORIGIN),
    "RSTPWR": Command(bare(_restart)),
    "RPWRCHK=": fixed("1"),
    "MFTIME=": Command(_set_forecast_dates),
    "MFRST=": Command(_reset_forecast),
    "MFFCST=": Command(_read_forecast),
}


_MOST_SUMMARIES: Final = 100


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
    # Each session has its own place in the listing.
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
    at = whole(argument, 1, _MOST_SUMMARIES) - 1
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


_KEYWORD: Final = "MELFA"
"""Opens protected parameters (KEYWD in BFP-A4288)."""
_SLOT_MODES: Final = ("REP", "CYC")
_START_CONDITIONS: Final = ("START", "ALWAYS", "ERROR")
_MOST_PRIORITY: Final = 31


def _read_parameter(session: CrSession, argument: str) -> str:
    return _parameter_answer(session, argument, all_levels=session.keyword)


def _read_any_parameter(session: CrSession, argument: str) -> str:
    return _parameter_answer(session, argument, all_levels=True)


def _parameter_answer(session: CrSession, argument: str, *, all_levels: bool) -> str:
    name = argument.strip().upper()
    values = session.state.parameters.read(name, all_levels=all_levels)
    return f"{name};{VALUE_SEPARATOR.join(values)};{len(values)}"


def _write_parameter(session: CrSession, argument: str) -> str:
    return _set_parameter(session, argument, all_levels=session.keyword)


def _write_any_parameter(session: CrSession, argument: str) -> str:
    return _set_parameter(session, argument, all_levels=True)


def _set_parameter(session: CrSession, argument: str, *, all_levels: bool) -> str:
    name, values = parts(argument, 2)
    session.state.parameters.write(name.strip().upper(), values, all_levels=all_levels)
    return ""


def _read_changed(session: CrSession, argument: str) -> str:
    """0 begins anew, 1 goes on; the answer tells first whether more follow."""
    if whole(argument, 0, 1) == 0:
        # A new listing takes the names of this moment; going on must not skip any.
        session.listed = session.state.parameters.changed
    names = at_once(session.listed)
    session.listed = session.listed[len(names) :]
    return f"{int(bool(session.listed))};{len(names)};{VT.join(names)}"


def _undo_parameter(session: CrSession, argument: str) -> str:
    mechanism, name = parts(argument, 2)
    whole(mechanism, 0, 3)
    session.state.parameters.undo(name.strip().upper())
    return ""


def _undo_all_parameters(session: CrSession) -> str:
    session.state.parameters.undo_all()
    return ""


def _check_keyword(session: CrSession, argument: str) -> str:
    session.keyword = argument == _KEYWORD
    return ""


# ---------------------------------------------------------------------------------- slot table


def _read_slot_row(session: CrSession) -> str:
    return ";".join(session.state.parameters[_slot_row_name(session)])


def _set_slot_row(session: CrSession, argument: str) -> str:
    """Holds from the next start on, as the parameter does."""
    program, mode, condition, priority = parts(argument, 4)
    if program:
        program = checked_name(program)
    if mode not in _SLOT_MODES or condition not in _START_CONDITIONS:
        raise CrRefusal(4460)
    lines = whole(priority, 1, _MOST_PRIORITY)
    values = VALUE_SEPARATOR.join([program, mode, condition, str(lines)])
    # The table is a protected parameter, which this command may write.
    session.state.parameters.write(_slot_row_name(session), values, all_levels=True)
    return ""


def _slot_row_name(session: CrSession) -> str:
    if not 1 <= session.slot <= TASKMAX:
        raise CrRefusal(5420)
    return f"SLT{session.slot}"


PARAMETER_COMMANDS: Final = {
    "PNR": Command(_read_parameter),
    "PAR": Command(_read_any_parameter),
    "PRM=": Command(_write_parameter),
    "PAW=": Command(_write_any_parameter),
    "PAW2=": Command(_write_any_parameter),
    "PMR=": Command(_read_changed),
    "PRMUNDO": Command(_undo_parameter),
    "PRMINIT": Command(bare(_undo_all_parameters)),
    "KEYWDp": Command(_check_keyword),
    "SLOTRD": Command(bare(_read_slot_row)),
    "SLOTSET": Command(_set_slot_row),
}
