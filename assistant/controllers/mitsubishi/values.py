"""Values on a CR controller: variables, signals and parameters, as MELFA-BASIC writes them.

Values are checked before they are sent, and compared within the decimals that a controller shows.
Variables of programs and of the controller: `VAL`, `VALS`, `GVALS`, `HOT` (BFP-A4288). Inputs,
outputs and hands: signals have numbers. Parameters: `PNR<name>` answers
`name;value[, value…];count`, `PMR=0|1` lists the changed ones, `PRM=<name>;<value>` writes. Most
take effect when the power comes on again.
The kinds of parameters are read from parameter files (.PRM) of RT ToolBox. After a head line they
have rows such as `MEXTL=Uf,0,0,150,%r0,%r0,%r0;`: U is a parameter of the user, M one of the maker;
then s is text, d, i and l are whole numbers, x hexadecimal, f others; `%r` precedes an angle in
radians. Seen in backups of CR750 and CR800 controllers (Borzyszkowski/Mitsubishi-Melfa-Robot,
KenanAegean/melfabasic-robotic-arm); no manual describes it.
A restore leaves some families of parameters out; their names are from BFP-A8869 and BFP-A5993.
"""

from __future__ import annotations

import re
import time
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from pathlib import Path as FilePath
from typing import Final, TypeVar

from assistant.base.data_classes import dataclass
from assistant.base.diagnostics import Refused
from assistant.base.file_access import read_file
from assistant.controllers import rules
from assistant.controllers.mitsubishi.link import BARE_ANSWER
from assistant.controllers.mitsubishi.programs import VT, checked_name, counted, editing
from assistant.controllers.mitsubishi.session import UNCHANGED, Session
from assistant.controllers.mitsubishi.state import running

T = TypeVar("T")
_SETTLING: Final = 1.0
"""Seconds for an assignment of EXEC to be carried out."""
_SETTLING_POLL: Final = 0.02
NUMBER_PATTERN: Final = r"[+-]?(?:\d+\.?\d*|\.\d+)(?:[Ee][+-]?\d+)?"
_LITERAL: Final = re.compile(
    rf"{NUMBER_PATTERN}|[+-]?&[HhBb][0-9A-Fa-f]+"
    r'|"[^"\x00-\x1f\x7f]*"'
    r"|\([-+0-9.,Ee ]*\)(?:\([-+0-9,&HhA-Fa-f ]*\))?",
    re.ASCII,
)
"""A number, a text, or a position or joints: what a value may be, and no expression."""
_VARIABLE_NAME: Final = re.compile(
    r"[A-Za-z]\w{0,39}[$%&!#]?(?:\(\d{1,4}(?:, ?\d{1,4}){0,2}\))?", re.ASCII
)
_PRINTABLE: Final = re.compile(r"[^\x00-\x1f\x7f;]*")
_SHOWN_ROUNDING: Final = 0.00501
"""Half of the last of two decimals, which is what a controller shows of positions."""
_RELATIVE_ROUNDING: Final = 1e-5
"""Part of a number that it may be off where more digits of it are shown."""
_TWO_DECIMALS: Final = re.compile(r"[+-]?\d*\.\d\d")


def bad_value(value: object, what: str, reason: str, form: str) -> Refused:
    """Return a Refused for an invalid request; its value is shown without control characters."""
    shown = str(value) if str(value).isprintable() else ascii(value)
    return Refused(rules.BAD_VALUE(place=what, value=shown, what=what, reason=reason, form=form))


def _checked_variable(name: str) -> str:
    """The name of a variable or of an element; raises Refused."""
    if _VARIABLE_NAME.fullmatch(name):
        return name.upper().replace(" ", "")
    raise bad_value(name, "a variable", "it is no name of the language", "`M1`, `P_00` or `M1(2)`")


def _checked_value(value: str) -> str:
    """Return a value other than an expression; raises Refused."""
    if _LITERAL.fullmatch(value.strip(" ")):
        return value.strip(" ")
    raise bad_value(
        value,
        "a value",
        "it is no number, text or position",
        '`2.5`, `"text"` or `(x,y,z,a,b,c)(f1,f2)`',
    )


def _checked_text(text: str, what: str, form: str) -> str:
    """Printable text without `;`, which would end an argument; raises Refused."""
    if _PRINTABLE.fullmatch(text):
        return text
    reason = "it holds a control character or a semicolon"
    raise bad_value(text, what, reason, form)


def same_value(one: str, two: str) -> bool:
    """True if two values are equal, numbers within the precision that a controller shows."""
    if '"' in one or '"' in two:
        return _inside(one) == _inside(two)
    left, right = _parts(one), _parts(two)
    return len(left) == len(right) and all(map(_near, left, right))


def _inside(text: str) -> str:
    """A text without its quotation marks, which not all controllers show."""
    return text.strip(" ").removeprefix('"').removesuffix('"')


def _parts(text: str) -> list[str]:
    return [part.strip(" ()") for part in re.split(r",|\)\s*\(", text.strip())]


def _near(one: str, two: str) -> bool:
    if re.fullmatch(NUMBER_PATTERN, one) and re.fullmatch(NUMBER_PATTERN, two):
        # Numbers with two decimals were rounded by the controller; others have more digits.
        rounded = any(map(_TWO_DECIMALS.fullmatch, (one, two)))
        most = _RELATIVE_ROUNDING * max(abs(float(one)), abs(float(two)))
        return abs(float(one) - float(two)) <= (max(_SHOWN_ROUNDING, most) if rounded else most)
    return one.upper() == two.upper()


def _read_until_settled(read: Callable[[], T], good: Callable[[T], bool]) -> T:
    """Read until the result is as expected, or until the time-out; return the last result.

    EXEC is answered when a statement is accepted; its effect comes a moment later.
    """
    end = time.monotonic() + _SETTLING
    while not good(now := read()) and time.monotonic() < end:
        time.sleep(_SETTLING_POLL)
    return now


_VARIABLE_CLASSES: Final = "MCPJ"
"""Numbers, texts, positions, joints."""
_EXTERNAL_NAME: Final = re.compile(r"[A-Z]_", re.IGNORECASE)
"""Beginning of the names of variables that belong to no program."""
ACTING_VARIABLE: Final = re.compile(r"M_(?:D?OUT|HND|YDEV|UDEV|TOOL|SVO)[A-Z0-9]*(?:\(.*)?")
"""Status variables that set outputs, open hands or choose a tool: no memory of a program."""
_MOST_VARIABLES: Final = 100_000
"""Variables after which an endless list counts as a fault."""


def read_variable(session: Session, name: str, program: str = "", slot: int = 1) -> str:
    """The value, of a program that is named or else of the one in the slot."""
    name = _checked_variable(name)
    if _EXTERNAL_NAME.match(name):
        return _value(session, "GVAL", name, slot)
    if program and checked_name(program) != selected_program(session, slot):
        with editing(session, program, f"reading {name} of `{program}`", UNCHANGED):
            return _value(session, "VAL", name, session.edit_slot)
    return _value(session, "VAL", name, slot)


def write_variable(
    session: Session, name: str, value: str, program: str = "", slot: int = 1
) -> None:
    """Sets a variable and reads it back; while its program runs, numbers only.

    A running program may have changed it by the time that it is read.
    """
    name, value = _checked_variable(name), _checked_value(value)
    _carried(session, name, value)
    doing = f"setting {name}"
    state = f"{name} is as it was or as it should be"
    if _EXTERNAL_NAME.match(name):
        if ACTING_VARIABLE.fullmatch(name):
            reason = "it acts on what is connected"
            raise bad_value(name, "a variable to be set", reason, "outputs, or the hand, instead")
        with session.right(doing):
            session.ask(f"EXEC{name}={value}", doing=doing, state=state, shape=BARE_ANSWER)
    else:
        owner = checked_name(program) if program else selected_program(session, slot)
        if not owner:
            raise Refused(session.alarm(5100, doing))
        session.ask(f"HOT{owner};{name}={value}", doing=doing, state=state, shape=BARE_ANSWER)

    def now() -> str:
        try:
            return read_variable(session, name, program, slot)
        except rules.Lost:
            raise
        except Refused:
            return "no value"  # an external one that is being made

    back = _read_until_settled(now, lambda told: same_value(told, value) or running(session))
    if not same_value(back, value) and not running(session):
        raise Refused(rules.NOT_TAKEN(place=name, what=name, sent=value, back=back))


def write_saved_variables(session: Session, program: str, changed: Mapping[str, str]) -> None:
    """Sets variables of a program as it is kept, in the edit slot; all of them or none."""
    checked_name(program)
    doing = f"setting variables of `{program}`"
    state = f"`{program}` there is as it was"
    slot = session.edit_slot
    wanted = {_checked_variable(n): _checked_value(v) for n, v in changed.items()}
    for name, value in wanted.items():
        _carried(session, name, value)
    with editing(session, program, doing, state):
        for name, value in wanted.items():
            command = f"VAL={name}={value}"
            session.ask(command, doing=doing, state=state, slot=slot, shape=BARE_ANSWER)
        session.ask("SAVE", doing=doing, state="they may or may not be set", shape=BARE_ANSWER)
    # Read again after SAVE: the edit slot would show its own copy.
    with editing(session, program, f"reading variables of `{program}`", UNCHANGED):
        for name, value in wanted.items():
            back = _value(session, "VAL", name, slot)
            if not same_value(back, value):
                raise Refused(rules.NOT_TAKEN(place=name, what=name, sent=value, back=back))


def _carried(session: Session, name: str, value: str) -> None:
    """Raises Refused for what no command can hold; HOT is the longest, with its program."""
    if not session.carries(f"HOT{'X' * 12};{name}={value}"):
        reason = "the controller link cannot carry it"
        raise bad_value(value[:40], name, reason, "less text, of characters that it has")


def selected_program(session: Session, slot: int) -> str:
    """The program in a slot, "" for none."""
    told = session.ask("PRGRD", doing="asking for the program of a slot", slot=slot)
    return told.text.partition(".")[0].strip()


def external_variables(session: Session) -> list[str]:
    """All variables that belong to no program, `name=value` each."""
    return [line for kind in _VARIABLE_CLASSES for line in _listed(session, "GVALS", kind, 1)]


def program_variables(session: Session, name: str) -> list[str]:
    """The variables of a program but for positions, which are part of its listing."""
    doing = f"reading the variables of `{name}`"
    with editing(session, name, doing, UNCHANGED):
        slot = session.edit_slot
        return [line for kind in "MCJ" for line in _listed(session, "VALS", kind, slot)]


def _listed(session: Session, command: str, kind: str, slot: int) -> Iterator[str]:
    doing = "listing variables"
    where = "<"
    for _ in range(_MOST_VARIABLES):
        text = session.ask(f"{command}{where};{kind}", doing=doing, slot=slot).text
        if not text.strip("; "):
            return
        body, _, more = counted(session, text, doing)
        for item in body.split(VT):
            line = item.strip().removesuffix(";")
            if line and "=" not in line:
                session.garbled(doing, text)
            if line:
                yield line
        if not more:
            return
        where = "+1"


def _value(session: Session, command: str, name: str, slot: int) -> str:
    doing = f"reading {name}"
    text = session.ask(f"{command}{name};{_class_of(name)}", doing=doing, slot=slot).text
    if not text.strip():
        raise Refused(session.alarm(4340, doing))
    told, sign, value = text.partition("=")
    # The answer names the variable: a late answer to another command is recognised.
    if not sign or told.strip().upper() != name:
        session.garbled(doing, text)
    return value.strip().removesuffix(";")


def _class_of(name: str) -> str:
    """By the first letter, which tells it but for names that a program has declared as numbers."""
    if "$" in name:
        return "C"
    return name[0] if name[0] in _VARIABLE_CLASSES else "M"


_SIGNAL_WORD: Final = re.compile(r"[0-9A-F]{4}", re.IGNORECASE)
_WORD_BITS: Final = 16
_LAST_SIGNAL: Final = 32767
_HANDS: Final = range(1, 9)
_HAND_OPEN, _HAND_CLOSED = 1, 2


def inputs(session: Session, names: Sequence[str]) -> dict[str, float]:
    return _read_signals(session, "IN", names)


def outputs(session: Session, names: Sequence[str]) -> dict[str, float]:
    return _read_signals(session, "OUT", names)


def _read_signals(session: Session, command: str, names: Sequence[str]) -> dict[str, float]:
    """The signals by their names; one command reads 16 from the number that it states."""
    numbers = {name: number_of(name) for name in names}
    bits: dict[int, float] = {}
    for number in sorted(set(numbers.values())):
        # A word of 16 signals may hold later ones already.
        if number not in bits:
            doing = f"reading {'inputs' if command == 'IN' else 'outputs'} from {number}"
            word = int(session.ask(f"{command}{number}", doing=doing, shape=_SIGNAL_WORD).text, 16)
            bits |= {number + bit: float(word >> bit & 1) for bit in range(_WORD_BITS)}
    return {name: bits[number] for name, number in numbers.items()}


def set_output(session: Session, name: str, value: float) -> None:
    """Switches one output, by the statement of the language; others stay as they are.

    OUT= of the link writes 16 outputs at once, and would undo what a program does to the
    other 15 in the meantime.
    """
    number = number_of(name)
    if value not in (0, 1):
        raise bad_value(f"{value:g}", "an output", "it is on or off", "0 or 1")
    doing = f"switching output {number}"
    with session.right(doing):
        session.ask(f"EXECM_OUT({number})={value:.0f}", doing=doing, shape=BARE_ANSWER)
    back = _read_until_settled(lambda: outputs(session, [name])[name], lambda now: now == value)
    if back != value:
        raise Refused(
            rules.NOT_TAKEN(
                place=name, what=f"output {number}", sent=f"{value:g}", back=f"{back:g}"
            )
        )


def hand(session: Session, number: int, *, is_open: bool) -> None:
    """Open or close a hand; raises Refused if no hand has that number."""
    doing = f"{'opening' if is_open else 'closing'} hand {number}"
    there = _hand_states(session)
    # Only a controller that reports its hands can tell that one is missing.
    if number not in _HANDS or (there is not None and there.get(number) is None):
        raise bad_value(
            number, "a hand", "the controller has none of that number", "the number of a hand"
        )
    session.ask(f"HND{'ON' if is_open else 'OFF'}{number}", doing=doing, shape=BARE_ANSWER)
    told = _hand_states(session)
    if told is not None and told.get(number) != (_HAND_OPEN if is_open else _HAND_CLOSED):
        words = {_HAND_OPEN: "open", _HAND_CLOSED: "closed"}
        raise Refused(
            rules.NOT_TAKEN(
                place=str(session.address),
                what=f"hand {number}",
                sent="open" if is_open else "closed",
                back=words.get(told.get(number) or 0, "something else"),
            )
        )


def _hand_states(session: Session) -> dict[int, int | None] | None:
    """1 open or 2 closed by the number of a hand, None for no hand; None if it is not told."""
    answer = session.attempt("HNDSTS", doing="asking for the hands")
    fields = answer.text.strip("; ").split(";")
    if not answer.ok or len(fields) % 3 or not all(re.fullmatch(r"-?\d+", f) for f in fields):
        return None
    states = [int(field) for field in fields]
    return {
        n: None if states[at] < 0 else states[at + 1]
        for n, at in enumerate(range(0, len(states), 3), 1)
    }


def number_of(name: str) -> int:
    """The number of a signal; raises Refused."""
    if re.fullmatch(r"\d{1,5}", name, re.ASCII) and int(name) <= _LAST_SIGNAL:
        return int(name)
    raise bad_value(
        name, "a signal", "signals of this controller have numbers", f"0 to {_LAST_SIGNAL}"
    )


_KIND_FILE_HEAD: Final = "NARC parameter system"
_KIND_ROW: Final = re.compile(r"([A-Z][A-Z0-9_]{0,15})=([UM])([sdilfx]),(.*);")
_KIND_FORMS: Final = {
    "s": (r".*", "text"),
    "d": (r"[+-]?\d+", "a whole number"),
    "i": (r"[+-]?\d+", "a whole number"),
    "l": (r"[+-]?\d+", "a whole number"),
    "x": (r"[+-]?\d+|(?:0x|&H)?[0-9A-Fa-f]+", "a hexadecimal number"),
    "f": (r"[+-]?(?:\d+\.?\d*|\.\d+)(?:[Ee][+-]?\d+)?", "a number"),
}


@dataclass(frozen=True, slots=True)
class ParameterKind:
    """letter: see `_KIND_FORMS`. count: of values. own: whether it is one of the user's."""

    letter: str
    count: int
    own: bool

    def check(self, name: str, value: str) -> None:
        """Raises Refused if a value is of another kind, or if there are not as many."""
        pattern, words = _KIND_FORMS[self.letter]
        parts = [part.strip() for part in value.split(",")]
        wrong = next((part for part in parts if not re.fullmatch(pattern, part)), None)
        if wrong is not None:
            reason = f"`{wrong}` is not {words}"
        elif len(parts) != self.count:
            reason = f"it has {len(parts)} values"
        else:
            return
        form = f"{self.count} times {words}" if self.count > 1 else words
        raise bad_value(value, name, reason, form)


def parameter_kinds(files: Iterable[str | FilePath]) -> dict[str, ParameterKind]:
    """Read kinds of parameters by name from parameter files; raises Refused for other files."""
    found: dict[str, ParameterKind] = {}
    for file in files:
        path = FilePath(file)
        try:
            text = read_file(path).decode("latin-1")
        except OSError as error:
            reason = error.strerror or str(error)
            raise Refused(rules.NO_PARAMETERS(path=str(path), file=path, reason=reason)) from None
        if _KIND_FILE_HEAD not in text.partition(";")[0]:
            reason = "it does not begin as a parameter file of RT ToolBox"
            raise Refused(rules.NO_PARAMETERS(path=str(path), file=path, reason=reason))
        for row in _KIND_ROW.finditer(text):
            name, owner, letter, body = row.groups()
            found[name] = ParameterKind(letter, len(_row_values(body)), owner == "U")
    return found


def _row_values(body: str) -> list[str]:
    """Return the values of a row; texts are in quotes and may hold commas."""
    return re.findall(r'"[^"]*"|[^,]+', body)


_PARAMETER_NAME: Final = re.compile(r"[A-Z][A-Z0-9_]{0,15}")
_MOST_LISTS: Final = 10_000
"""Answers after which an endless list counts as a fault."""


def read_parameters(session: Session, names: Sequence[str] = ()) -> dict[str, str]:
    """Values by name, of the changed ones without names."""
    wanted = (
        [checked_parameter_name(name) for name in names] if names else changed_parameters(session)
    )
    return {name: read_parameter(session, name) for name in wanted}


def read_parameter(session: Session, name: str) -> str:
    """The value as the controller writes it, several with commas between."""
    doing = f"reading parameter {name}"
    text = session.ask(f"PNR{name}", doing=doing).text
    told, _, rest = text.partition(";")
    value, separator, count = rest.rpartition(";")
    if told.strip().upper() != name or not separator or not count.strip().isdecimal():
        session.garbled(doing, text)
    return value.strip()


def changed_parameters(session: Session) -> list[str]:
    """Names of the parameters that are not as they were delivered, sorted."""
    doing = "listing the changed parameters"
    found: set[str] = set()
    for index in range(_MOST_LISTS):
        text = session.ask(f"PMR={int(index > 0)}", doing=doing).text
        if not text.strip("; "):
            break
        more, _, rest = text.partition(";")
        count, _, names = rest.partition(";")
        if more.strip() not in ("0", "1") or not count.strip().isdecimal():
            session.garbled(doing, text)
        listed = [name.strip(" ;") for name in names.split(VT)]
        found |= {name for name in listed if _PARAMETER_NAME.fullmatch(name)}
        if more.strip() == "0":
            break
    return sorted(found)


def write_parameter(
    session: Session, name: str, value: str, kinds: Mapping[str, ParameterKind]
) -> None:
    """Writes a parameter and reads it back; kinds: of parameters that a file tells."""
    checked_parameter_name(name)
    _checked_text(value, f"parameter {name}", "numbers or text with commas between")
    if name in kinds:
        kinds[name].check(name, value)
    doing = f"writing parameter {name}"
    command = f"PRM={name};{value}"
    if not session.carries(command):
        reason = "the controller link cannot carry it"
        raise bad_value(value, name, reason, "less text")
    state = f"{name} is as it was or as it should be"
    session.ask(command, doing=doing, state=state, shape=BARE_ANSWER)
    back = read_parameter(session, name)
    if not same_value(back, value):
        raise Refused(rules.NOT_TAKEN(place=name, what=f"parameter {name}", sent=value, back=back))


def checked_parameter_name(name: str) -> str:
    """A name of a parameter; raises Refused."""
    if _PARAMETER_NAME.fullmatch(name):
        return name
    reason = "names of parameters have up to 16 capital letters and digits"
    raise bad_value(name, "a parameter", reason, "`MEXTL`")


_ORIGIN: Final = "it belongs to the origin of this arm; another one would move to wrong places"
_SAFETY: Final = "it limits what the arm may do, or watches over it"
_NETWORK: Final = "it belongs to the lines of this controller; another one could not be reached"
_MACHINE: Final = "it says what this controller and its arm are"

_LEFT_OUT_PARAMETERS: Final = (
    (re.compile(r"DATINST.*|HOME.*|JRC.*|USE?RORG|ME?ORG.*|ORG.*|MEDORG.*"), _ORIGIN),
    (re.compile(r"MEINS.*|MEOFF.*|DJNT"), _ORIGIN),
    (re.compile(r"ME[JPM]AR|AREA.*|USERAREA.*|SFC.*|COL.*|CAV.*|ESP.*|DOOR.*|AUTOENA"), _SAFETY),
    (re.compile(r"SF[A-Z]*|SS[12].*|SLS.*|SLP.*|STR(?:DLY|CRC).*|SRSW.*|SRPRM.*"), _SAFETY),
    (re.compile(r"NET.*|COMDEV|CBAU.*|CPRC.*|CPRTY.*|CSTOP.*|CTERM.*|CLEN.*|COMSPEC"), _NETWORK),
    (re.compile(r"MXTCOM.*|MONMODE|MONPORT"), _NETWORK),
    (re.compile(r"RCSERIAL|RCTYPE|MECHA\d*|MAINVER|SRVVER\d*|.*VER|PRGEXT"), _MACHINE),
)
"""Patterns of names → why a restore leaves them out."""
SECRET_PARAMETER: Final = re.compile(r".*(?:PSW|PSSW|PASSW|PWD|KEYW).*")
"""Names of parameters that may hold a password: no backup has them."""


def why_left_out(name: str) -> str | None:
    """Why a restore leaves a parameter out, None if it does not."""
    return next(
        (reason for pattern, reason in _LEFT_OUT_PARAMETERS if pattern.fullmatch(name)), None
    )
