"""Commands for maintenance: meters, temperatures, servos, brakes, origin, restart.

What a controller of iron measures, the virtual one does not: it answers values of a healthy robot
at rest, where BFP-A4288 shows some, those.
"""

from __future__ import annotations

from typing import Final

from assistant.virtual.cr.command import Command, bare, fixed, hexadecimal, parts, whole
from assistant.virtual.cr.state import CrSession
from assistant.virtual.cr.store import CrRefusal

BATTERY: Final = 14600
"""Hours that a battery lasts: 2715 and 11885 in the sample of PTIME."""
AXES: Final = 8
ORIGIN: Final = "Z2UOGQ;Z2VX5I;Z2#46Z;Z2NXW5;004QA5;0XB462;Y91%K5"
"""Origin data with their check sum, as BFP-A4288 shows them."""
ORIGIN_TYPES: Final = ("0", "1", "3", "4", "5", "7")
OPTION_SLOTS: Final = 3
ALL_METERS: Final = "Z"


def _zero_values(count: int, zero: str = "0") -> Command:
    return fixed(";".join([zero] * count))


def _read_meters(session: CrSession) -> str:
    """Power, servos of all and of the first mechanism, 14 unused, programs, unused, battery used
    and left, mechanisms.
    """
    hours = session.state.hours
    left = max(BATTERY - hours["B"], 0)
    told = [hours["T"], hours["S"], hours["S"], *[0] * 14, hours["D"], 0, hours["B"], left, 1]
    return ";".join(map(str, told))


def _clear_meter(session: CrSession, argument: str) -> str:
    hours = session.state.hours
    if argument != ALL_METERS and argument not in hours:
        raise CrRefusal(4460)
    for kind in hours if argument == ALL_METERS else [argument]:
        hours[kind] = 0
    return ""


def _read_battery(session: CrSession) -> str:
    hours = session.state.hours
    return f"{hours['S']};{max(BATTERY - hours['B'], 0)}"


def _read_option(session: CrSession, argument: str) -> str:
    """The network; the other slots are empty."""
    if whole(argument or "1", 1, OPTION_SLOTS) > 1:
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
    if kind not in ORIGIN_TYPES:
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
    "OPNUMRD": fixed(str(OPTION_SLOTS)),
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
    "DATRD": fixed(ORIGIN),
    "RSTPWR": Command(bare(_restart)),
    "RPWRCHK=": fixed("1"),
    "MFTIME=": Command(_set_forecast_dates),
    "MFRST=": Command(_reset_forecast),
    "MFFCST=": Command(_read_forecast),
}
