"""The commands of the controller link: what each needs and what it answers.

Answers, arguments and error numbers are those of the manual BFP-A4288 and the controllers'
error lists. Commands that would move the arm are not here: they answer 6010.
"""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

from assistant.virtual.cr import editing
from assistant.virtual.cr.state import TASKMAX, CrSession
from assistant.virtual.cr.store import CrRefusal, checked_name

if TYPE_CHECKING:
    from assistant.robots import Robot

JOG_SPEEDS: Final = "3,5,A,1E,32,46,64"
"""Percent, hexadecimal."""

Handler = Callable[[CrSession, str], str]


@dataclass(frozen=True, slots=True)
class Command:
    """handler: session and argument → answer. right: needs the operation right."""

    handler: Handler
    right: bool = False


def execute(session: CrSession, text: str) -> str:
    """The answer to `[robot];[slot];COMMAND`, without `QoK`; raises CrRefusal."""
    head = re.match(r"(\d*);(\d*);", text)
    if head is None:
        raise CrRefusal(6010)
    if int(head[1][:3] or 1) > 3:
        raise CrRefusal(5430)
    session.slot = int(head[2][:3] or 1)
    if session.slot > TASKMAX + 1:
        raise CrRefusal(5420)
    body = text[head.end() :]
    name = next((n for n in BY_LENGTH if body.startswith(n)), None)
    if name is None:
        raise CrRefusal(6010)
    command, argument = COMMANDS[name], body[len(name) :]
    if command.right and session.state.right is not session:
        raise CrRefusal(6020)
    return command.handler(session, argument)


def bare(handler: Callable[[CrSession], str]) -> Handler:
    """A command that nothing may follow."""

    def answer(session: CrSession, argument: str) -> str:
        if argument:
            raise CrRefusal(6010)
        return handler(session)

    return answer


def _open(session: CrSession, argument: str) -> str:
    state = session.state
    world, joints = _axes_there(state.robot)
    return ";".join(
        [
            f"{world:02X}",
            f"{joints:02X}",
            state.flags(),
            JOG_SPEEDS,
            state.suffix,
            "PRM",
            state.robot.name.upper(),
            state.robot.controller,
            "MELFA",
            f"{state.clock():%y-%m-%d}",
            "Ver.VIRTUAL",
            "JPN" if argument.endswith(";JPN") else "ENG",
            "VIRTUAL CONTROLLER",
            "1;1",
            f"{TASKMAX};",
        ]
    )


def _axes_there(robot: Robot) -> tuple[int, int]:
    """Bits of X Y Z A B C and of J1 to J6 that the arm has; a SCARA turns about Z only."""
    joints = sum(1 << place for place in robot.places if place < 6)
    world = {"five-axis": 0x1F, "scara": 0x27}.get(robot.arm.kind, 0x3F)
    return world, joints


def _close(session: CrSession) -> str:
    session.hang_up()
    return ""


def _take_right(session: CrSession) -> str:
    if session.state.right not in (None, session):
        raise CrRefusal(6020)
    session.state.right = session
    return ""


def _give_right(session: CrSession) -> str:
    if session.state.right is session:
        session.state.right = None
    return ""


def _directory(session: CrSession, argument: str) -> str:
    store = session.state.store
    names = list(store)
    top = argument in ("TOP", "")
    if not top and not re.fullmatch(r"\d{1,5}", argument):
        raise CrRefusal(4460)
    index = 0 if top else int(argument) - 1
    if not 0 <= index < len(names):
        return ""
    name = names[index]
    program = store[name]
    changed = program.changed or session.state.clock()
    entry = [f"{name}.{session.state.suffix}", str(program.size), f"{changed:%y-%m-%d%H:%M:%S}"]
    if top:
        entry += [str(len(store)), str(store.capacity - store.used)]
    counts = [len(program.steps), len(program.variables), 0, 0, 0, 0]
    return ";".join([*entry, "", "", *map(str, counts)])


def _file_check(session: CrSession, argument: str) -> str:
    return "N" if checked_name(argument) in session.state.store else "F"


def _file_delete(session: CrSession, argument: str) -> str:
    name = checked_name(argument)
    if name in session.state.selected.values():
        raise CrRefusal(4190)
    if name in session.state.edited:
        raise CrRefusal(4170)
    session.state.store.delete(name)
    return ""


def _free(session: CrSession) -> str:
    store = session.state.store
    return f"{store.capacity};{store.used};{100 * store.used // store.capacity}"


def _select(session: CrSession, argument: str) -> str:
    name = checked_name(argument)
    if name not in session.state.store:
        raise CrRefusal(4140)
    if not 1 <= session.slot <= TASKMAX:
        raise CrRefusal(5420)
    session.state.selected[session.slot] = name
    return ""


def _selected(session: CrSession) -> str:
    name = session.state.selected.get(session.slot)
    return f"{name}.{session.state.suffix}" if name else ""


def _reset_program(session: CrSession) -> str:
    """Nothing runs here, so the slot's program stands at its first line already."""
    if not 1 <= session.slot <= TASKMAX:
        raise CrRefusal(5420)
    return ""


def _state(session: CrSession) -> str:
    state = session.state
    program = _selected(session)
    edit = 1 if session.name else 0
    fields = [program, str(_first_step(session)), str(state.override), str(edit), _bits(session)]
    return ";".join([*fields, "1", "1", *[""] * 7, program, "REP", "START", "1", "1"])


def _short_state(session: CrSession) -> str:
    return f"{_bits(session)};1;1"


def _first_step(session: CrSession) -> int:
    name = session.state.selected.get(session.slot)
    store = session.state.store
    return min(store[name].steps, default=0) if name and name in store else 0


def _bits(session: CrSession) -> str:
    """Run bits, stop bits, error number.

    Run: 01 repeat, 02 cycle stop off, 80 operation right. Stop: 02 stopped, 10 selectable.
    """
    state = session.state
    run = 0x01 | 0x02 | (0x80 if state.right is not None else 0)
    stop = 0x02 | 0x10
    return f"{run:02X}{stop:02X}{state.alarm[0] if state.alarm else 0}"


def _joints(session: CrSession, argument: str) -> str:
    return _position(session, session.state.shown_joints(), "****,****", argument)


def _pose(session: CrSession, argument: str) -> str:
    return _position(session, session.state.shown_pose(), session.state.flags(), argument)


def _position(session: CrSession, shown: list[tuple[str, str]], flags: str, axis: str) -> str:
    """`name;value;…;;flags;override;speed;limits`; an axis (1 to 8) chooses one of them."""
    if axis and not re.fullmatch(r"[1-8]", axis):
        raise CrRefusal(4460)
    chosen = shown[int(axis) - 1 : int(axis)] if axis else shown
    values = "".join(f"{name};{value};" for name, value in chosen)
    return f"{values};{flags};{session.state.override};0.00;00000000"


def _error(session: CrSession) -> str:
    alarm = session.state.alarm
    return f"{alarm[0]:04};{alarm[1]}" if alarm else ""


def _reset_alarm(session: CrSession) -> str:
    session.state.alarm = None
    return ""


def _override(session: CrSession) -> str:
    return str(session.state.override)


def _set_override(session: CrSession, argument: str) -> str:
    if not re.fullmatch(r"\d{1,3}", argument) or not 1 <= int(argument) <= 100:
        raise CrRefusal(4460)
    session.state.override = int(argument)
    return argument


def _time(session: CrSession) -> str:
    return f"{session.state.clock():%y-%m-%d%H:%M:%S}"


def _parameter(session: CrSession, argument: str) -> str:
    values = _parameters(session).get(argument.upper())
    if values is None:
        raise CrRefusal(7080)
    return f"{argument.upper()};{', '.join(values)};{len(values)}"


def _parameters(session: CrSession) -> dict[str, list[str]]:
    """The parameters that the virtual controller has."""
    robot = session.state.robot
    limits = [f"{float(v):.2f}" for pair in robot.limits for v in pair]
    return {
        "RLNG": ["1" if session.state.language == "melfa-basic-4" else "2"],
        "TASKMAX": [str(TASKMAX)],
        "MEXTL": ["0.00"] * 6,
        "MEXBS": ["0.00"] * 6,
        "MEJAR": limits,
    }


COMMANDS: Final = {
    # session
    "OPEN=": Command(_open),
    "CLOSE": Command(bare(_close)),
    "CNTLON": Command(bare(_take_right)),
    "CNTLOFF": Command(bare(_give_right)),
    # edit
    "NEW": Command(bare(editing.new)),
    "LOAD=": Command(editing.load),
    "SAVE": Command(bare(editing.save)),
    "EDATA": Command(editing.put_line),
    "EMDAT": Command(editing.put_lines),
    "ECLR": Command(bare(editing.clear)),
    "DELETE": Command(editing.delete_steps),
    "LISTL": Command(editing.list_lines),
    "LISTI": Command(editing.list_line),
    "LISTP": Command(editing.list_position),
    "LISTCNT": Command(editing.count_steps),
    # files
    "PDIR": Command(_directory),
    "FCHECK": Command(_file_check),
    "FDEL": Command(_file_delete),
    "EFREE": Command(bare(_free)),
    # programs in slots
    "PRGLOAD=": Command(_select, right=True),
    "PRGRD": Command(bare(_selected)),
    "RSTPRG": Command(bare(_reset_program)),
    # state
    "STATE": Command(bare(_state)),
    "DSTATE": Command(bare(_short_state)),
    "JPOSF": Command(_joints),
    "PPOSF": Command(_pose),
    "ERROR": Command(bare(_error)),
    "RSTALRM": Command(bare(_reset_alarm)),
    "OVRD=": Command(_set_override, right=True),
    "OVRD": Command(bare(_override)),
    "TIME": Command(bare(_time)),
    "PNR": Command(_parameter),
    "PAR": Command(_parameter),
}

BY_LENGTH: Final = sorted(COMMANDS, key=len, reverse=True)
"""Longest first, so that OVRD= is not taken for OVRD."""
