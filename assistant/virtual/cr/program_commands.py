"""Commands of the link about programs: editing, listing, variables and files.

Lines are checked by the parser and the rules of the language as they arrive. A file of this
controller is a program, and its content is the program's text; a real controller keeps a format
that only it can read.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from typing import Final

from assistant import languages
from assistant.base.diagnostics import Refused, Severity
from assistant.base.source_text import lines_of
from assistant.virtual.cr.command import (
    VT,
    Command,
    at_once,
    bare,
    hexadecimal,
    parts,
    place,
    whole,
)
from assistant.virtual.cr.state import TASKMAX, BlockFile, CrSession, Cycles
from assistant.virtual.cr.store import (
    ENCODING,
    LAST_LINE,
    CrProgram,
    CrRefusal,
    checked_name,
    class_of,
    listed_values,
    program_of,
)

_SYNTAX: Final = 4220
_CHARACTER: Final = 4310
_LINE_RULES: Final = {"MB106": 4300, "MB107": 4210, "MB109": 4420, "MB111": _SYNTAX}
"""Rules that one line alone can break → error number: long name, long step, step number out of
range, a word that this version lacks. Labels, blocks and values are checked when the program runs,
so other rules reject no line.
"""


def _check_line(language: str, line: str) -> None:
    """Raises CrRefusal with the number and the character (from 1) of what is wrong in a line."""
    parser = languages.get(language)
    try:
        source = parser.decode(line.encode(ENCODING))
    except Refused:
        raise CrRefusal(_CHARACTER, 1) from None
    tree = parser.parse(source)
    for finding in tree.findings:
        if finding.severity is Severity.ERROR:
            raise CrRefusal(_SYNTAX, finding.column or 1)
    for finding in parser.check([tree]):
        if finding.code in _LINE_RULES and finding.severity is Severity.ERROR:
            raise CrRefusal(_LINE_RULES[finding.code], finding.column or 1)


_DELETED_LINE: Final = re.compile(r"\s*\d*\s*", re.ASCII)
"""A number alone deletes its line, and is no line to parse."""
_FIRST_LINE: Final = 10
"""Number of the first line and step between lines if RENUM gets 0."""


def _new_program(session: CrSession) -> str:
    session.close()
    return ""


def _load_program(session: CrSession, argument: str) -> str:
    session.open(checked_name(argument))
    return ""


def _save_program(session: CrSession) -> str:
    program = session.edit
    assert session.name is not None
    state = session.state
    program.changed = state.now()
    state.store.save(session.name, program)
    state.forget(session.name)
    session.close()
    return ""


def _put_line(session: CrSession, argument: str) -> str:
    program = session.edit
    _put_checked_line(session, program, argument)
    return ""


def _put_lines(session: CrSession, argument: str) -> str:
    program, lines = session.edit, argument.split(VT)
    # Line by line only if something is wrong, to find which line it is.
    known = _are_correct(session.state.language, lines)
    for number, line in enumerate(lines, start=1):
        try:
            if line:
                _put_checked_line(session, program, line, known=known)
        except CrRefusal as error:
            raise CrRefusal(error.number, number, *error.places) from None
    return ""


def _are_correct(language: str, lines: Sequence[str]) -> bool:
    """True if no line has an error; one check of all lines takes the time of one line."""
    try:
        _check_line(
            language, "\r\n".join(line for line in lines if not _DELETED_LINE.fullmatch(line))
        )
    except CrRefusal:
        return False
    return True


def _put_checked_line(
    session: CrSession, program: CrProgram, line: str, *, known: bool = False
) -> None:
    """known: that nothing is wrong with the line."""
    if not known and not _DELETED_LINE.fullmatch(line):
        _check_line(session.state.language, line)
    program.put(line)
    session.changed = True


def _insert_line(session: CrSession, argument: str) -> str:
    """A line before the one that has its number; that and those that follow close up move on."""
    program = session.edit
    number, text = parts(argument, 2)
    at = whole(number, 1, LAST_LINE, error=4420)
    _check_line(session.state.language, f"{at} {text}")
    last = at
    while last in program.steps:
        last += 1
    if last > LAST_LINE:
        raise CrRefusal(4420, 1)
    steps = dict(program.steps)
    for line in range(last, at, -1):
        steps[line] = f"{line} {program.steps[line - 1].partition(' ')[2]}"
    program.renumber(steps)
    program.put(f"{at} {text}")
    session.changed = True
    return ""


def _clear_program(session: CrSession) -> str:
    session.edit.clear()
    session.changed = True
    return ""


def _delete_steps(session: CrSession, argument: str) -> str:
    program = session.edit
    first, last = _line_range(argument)
    gone = [number for number in program.steps if first <= number <= last]
    if not gone:
        raise CrRefusal(4230)
    program.renumber({n: line for n, line in program.steps.items() if n not in gone})
    session.changed = True
    return ""


def _line_range(argument: str) -> tuple[int, int]:
    """`<a>;<b>`, either may be missing."""
    found = re.fullmatch(r"(\d{0,5})(?:;(\d{0,5}))?", argument, re.ASCII)
    if found is None:
        raise CrRefusal(4460)
    first = int(found[1]) if found[1] else 1
    return first, int(found[2]) if found[2] else (first if found[2] is None else LAST_LINE)


def _renumber(session: CrSession, argument: str) -> str:
    """Jumps to line numbers are changed with them; 4410 where that cannot be done."""
    program = session.edit
    new, start, step, end = (whole(part, 0, LAST_LINE) for part in parts(argument, 4))
    numbers = sorted(program.steps)
    if not numbers:
        return ""
    if (start not in (0, numbers[0])) or (end != 0 and end < numbers[-1]):
        raise CrRefusal(4410)  # jumps between renumbered lines and others are not followed
    language = languages.get(session.state.language)
    text = "".join(f"{line}\n" for line in program.lines())
    try:
        made = language.render(
            language.renumber(language.parse(text), new or _FIRST_LINE, step or _FIRST_LINE)
        )
    except Refused:
        raise CrRefusal(4410) from None
    renumbered = CrProgram()
    for line in lines_of(made):
        renumbered.put(line)
    program.renumber(renumbered.steps)
    session.changed = True
    return ""


EDIT_COMMANDS: Final = {
    "NEW": Command(bare(_new_program)),
    "LOAD=": Command(_load_program),
    "SAVE": Command(bare(_save_program)),
    "EDATA": Command(_put_line),
    "EMDAT": Command(_put_lines),
    "EDINS=": Command(_insert_line),
    "ECLR": Command(bare(_clear_program)),
    "DELETE": Command(_delete_steps),
    "RENUM": Command(_renumber),
}


_LINE_LIST: Final = "lines"
_POSITION_LIST: Final = "positions"
_LISTING_WORDS: Final = ("TOP", "END", "+1", "-1", "")


def _list_lines(session: CrSession, argument: str) -> str:
    lines = session.edit.lines()
    start = place(argument, session.following.get(_LINE_LIST, 0), sorted(session.edit.steps))
    listed = at_once(lines[start:])
    behind = session.following[_LINE_LIST] = start + len(listed)
    return f"{VT.join(listed)};{len(listed)};{int(behind < len(lines))}" if listed else ""


def _list_line(session: CrSession, argument: str) -> str:
    lines = session.edit.lines()
    at = place(argument, session.following.get(_LINE_LIST, 0), sorted(session.edit.steps))
    session.following[_LINE_LIST] = min(at + 1, len(lines))
    return lines[at] if at < len(lines) else ""


def _list_position(session: CrSession, argument: str) -> str:
    positions = session.edit.positions()
    following = session.following.get(_POSITION_LIST, 0)
    if argument in _LISTING_WORDS:
        at = place(argument, following, range(len(positions)))
    else:
        names = [line.partition("=")[0].upper() for line in positions]
        at = place(argument, following, names)
    session.following[_POSITION_LIST] = min(at + 1, len(positions))
    return positions[at] if at < len(positions) else ""


def _count_lines(session: CrSession, argument: str) -> str:
    first, last = _line_range(argument)
    return f"{sum(first <= number <= last for number in session.edit.steps):04}"


def _find_text(session: CrSession, argument: str) -> str:
    """The first line from the top that has the text, and how many characters stand before it."""
    for line in session.edit.lines():
        if argument and argument in line:
            return f"{line};{line.index(argument)}"
    raise CrRefusal(4430)


LIST_COMMANDS: Final = {
    "LISTL": Command(_list_lines),
    "LISTI": Command(_list_line),
    "LISTP": Command(_list_position),
    "LISTCNT": Command(_count_lines),
    "ESEARCH": Command(_find_text),
}


_VARIABLE_NAME: Final = re.compile(r"([A-Z]\w*)([$%&!#]?)((?:\(\d+(?:,\d+){0,2}\))?)", re.ASCII)
_EXTERNAL_NAME: Final = re.compile(r"[A-Z]_")
_NUMBER_TEXT: Final = re.compile(
    r"[+-]?(?:\d+\.?\d*|\.\d+)(?:E[+-]?\d+)?", re.ASCII | re.IGNORECASE
)
_STRING_TEXT: Final = re.compile(r'"[^"]*"')
_POSITION_TEXT: Final = re.compile(r"(\([^()]*\))(\([^()]*\))?")
_VARIABLE_CLASSES: Final = "MCPJ"


def _write_variable(session: CrSession, argument: str) -> str:
    """A variable of the program that is open for editing."""
    name, value = assignment(argument)
    # A name with an underscore as its second character is a variable of all programs.
    if _EXTERNAL_NAME.match(name):
        session.state.set_variable(None, name, value)
    else:
        session.edit.keep(name, value)
        session.changed = True
    return ""


def _write_program_variable(session: CrSession, argument: str) -> str:
    """A variable of a program, which may run."""
    program, rest = parts(argument, 2)
    program = checked_name(program)
    if program not in session.state.store:
        raise CrRefusal(4140)
    name, value = assignment(rest)
    session.state.set_variable(None if _EXTERNAL_NAME.match(name) else program, name, value)
    return ""


def assignment(text: str) -> tuple[str, str]:
    """`name=value` with the value as a controller lists it; raises CrRefusal."""
    name, sign, value = text.partition("=")
    name, value = re.sub(r"\s", "", name).upper(), value.strip()
    found = _VARIABLE_NAME.fullmatch(name)
    if not sign or found is None:
        raise CrRefusal(4220)
    kind, made = found[1][0], ""
    if _NUMBER_TEXT.fullmatch(value):
        made = _shown_number(float(value))
    elif _STRING_TEXT.fullmatch(value):
        made = value
    elif place := _POSITION_TEXT.fullmatch(value):
        try:
            made = listed_values(place[1]) + re.sub(r"\s", "", place[2] or "")
        except ValueError:
            raise CrRefusal(4220) from None
    if not made:
        raise CrRefusal(4220)
    given = class_of(f"{name}={made}")
    # A position without flags looks like joint angles; the name says which it is.
    if given == "J" and kind == "P":
        made += "(0,0)"
        given = "P"
    if (kind in _VARIABLE_CLASSES or found[2] == "$") and given != (
        "C" if found[2] == "$" else kind
    ):
        raise CrRefusal(4390)
    return name, made


def _shown_number(value: float) -> str:
    """Return a number in the form of the controller's listings: `+3`, `-0.25`."""
    return f"{value:+.10g}"


def _variable_type(session: CrSession, argument: str) -> str:
    """Return M, C, P or J for a variable that has a value or is used in a line of the program."""
    name = argument.strip().upper()
    program = session.edit
    lines = program.variables | program.values
    if name in lines:
        return class_of(lines[name])
    used = re.compile(rf"(?<![\w.]){re.escape(name)}(?![\w$%&!#(])", re.IGNORECASE | re.ASCII)
    if not _VARIABLE_NAME.fullmatch(name) or not any(
        used.search(s) for s in program.steps.values()
    ):
        return ""
    return "C" if name.endswith("$") else name[0] if name[0] in "PJ" else "M"


def _read_variable(session: CrSession, argument: str) -> str:
    lines, at, key = _requested_variables(session, argument, shared=False)
    session.following[key] = min(at + 1, len(lines))
    return lines[at] if at < len(lines) else ""


def _read_variables(session: CrSession, argument: str) -> str:
    return _listed_together(session, *_requested_variables(session, argument, shared=False))


def _read_shared_variable(session: CrSession, argument: str) -> str:
    lines, at, key = _requested_variables(session, argument, shared=True)
    session.following[key] = min(at + 1, len(lines))
    return lines[at] if at < len(lines) else ""


def _read_shared_variables(session: CrSession, argument: str) -> str:
    return _listed_together(session, *_requested_variables(session, argument, shared=True))


def _requested_variables(
    session: CrSession, argument: str, *, shared: bool
) -> tuple[list[str], int, str]:
    """Return the variables of the requested class, the index of the first wanted, and the name of
    the listing. `<` is the first, `>` the last; the class after a name is optional.
    """
    where, _, kind = argument.partition(";")
    kind = kind or _VARIABLE_CLASSES
    if any(letter not in _VARIABLE_CLASSES for letter in kind):
        raise CrRefusal(4460)
    key = f"{'shared' if shared else 'own'} {kind}"
    lines = (_shared_program(session) if shared else _program_of_slot(session)).valued(kind)
    names = [line.partition("=")[0].upper() for line in lines]
    at = place(where, session.following.get(key, 0), names, top="<", end=">")
    return lines, at, key


def _listed_together(session: CrSession, lines: list[str], at: int, key: str) -> str:
    listed = at_once(lines[at:], f";{VT}")
    behind = session.following[key] = at + len(listed)
    if not listed:
        return ""
    return f"{f';{VT}'.join(listed)};{len(listed)};{int(behind < len(lines))}"


def _shared_program(session: CrSession) -> CrProgram:
    return session.state.machinery.shared_now()


def _program_of_slot(session: CrSession) -> CrProgram:
    """The program of the slot; where it has none, and in the edit slot, the one that is open."""
    state = session.state
    name = state.selected.get(session.slot) if session.slot <= TASKMAX else None
    if name is None or name not in state.store:
        return session.edit
    return state.program_now(name)


VARIABLE_COMMANDS: Final = {
    "VAL=": Command(_write_variable),
    "HOT": Command(_write_program_variable),
    "VTYPRD": Command(_variable_type),
    "VAL": Command(_read_variable),
    "VALS": Command(_read_variables),
    "GVAL": Command(_read_shared_variable),
    "GVALS": Command(_read_shared_variables),
}


_PROGRAM_FOLDER: Final = "/robprg/dat/"
_BLOCK_SIZE: Final = 120
"""Bytes of a file in one answer (FWRITE in BFP-A4288)."""
_PLAIN_ATTRIBUTE: Final = 12
"""Attribute of a file that nothing protects (PDIR in BFP-A4288)."""
_PROTECTED_ATTRIBUTE: Final = {"p": 1, "q": 2}
"""Bits of the attribute, which no manual tells: lines, variables."""
_ALL_FILES: Final = "<*.*"


def _program_directory(session: CrSession, argument: str) -> str:
    name, first = _file_at(session, argument)
    if name is None:
        return ""
    program = session.state.store[name]
    cycles = session.state.cycles.get(name, Cycles())
    counts = [len(program.steps), len(program.variables)]
    return ";".join([_directory_entry(session, name, first), "", *map(str, counts), cycles.fields])


def _file_directory(session: CrSession, argument: str) -> str:
    name, first = _file_at(session, "TOP" if argument == _ALL_FILES else argument)
    return "" if name is None else _directory_entry(session, name, first)


def _file_at(session: CrSession, argument: str) -> tuple[str | None, bool]:
    """The file at a place of the directory, None behind its end; whether it is the first one."""
    names = list(session.state.store)
    top = argument in ("TOP", "")
    index = 0 if top else whole(argument, 0, 99999) - 1
    return (names[index] if 0 <= index < len(names) else None), top


def _directory_entry(session: CrSession, name: str, first: bool) -> str:
    """Name, size, date, and the attribute; of the first one also how many there are and room."""
    state, store = session.state, session.state.store
    program = store[name]
    changed = program.changed or state.now()
    entry = [f"{name}.{state.suffix}", str(program.size), f"{changed:%y-%m-%d%H:%M:%S}"]
    if first:
        entry += [str(len(store)), str(store.capacity - store.used)]
    bits = sum(bit for letter, bit in _PROTECTED_ATTRIBUTE.items() if letter in program.protected)
    return ";".join([*entry, str(_PLAIN_ATTRIBUTE | bits)])


def _check_file(session: CrSession, argument: str) -> str:
    return "N" if checked_name(argument) in session.state.store else "F"


def _set_path(session: CrSession, argument: str) -> str:
    name = checked_name(argument)
    if name not in session.state.store:
        raise CrRefusal(4140)
    return f"{_PROGRAM_FOLDER}{name}.{session.state.suffix}"


def _copy_file(session: CrSession, argument: str) -> str:
    old, new = _file_and_new_name(session, argument, missing=7000)
    program = session.state.store[old].copy()
    # A copy is not protected.
    program.protected = set()
    session.state.store.save(new, program)
    return ""


def _rename_file(session: CrSession, argument: str) -> str:
    old, new = _file_and_new_name(session, argument, missing=7020)
    _refuse_in_use(session, old)
    store = session.state.store
    program = store[old].copy()
    store.delete(old)
    store.save(new, program)
    session.state.forget(old)
    return ""


def _file_and_new_name(session: CrSession, argument: str, missing: int) -> tuple[str, str]:
    """A file that there is, and the name of one that there is not yet or that may be replaced."""
    old, new = map(checked_name, parts(argument, 2))
    if old not in session.state.store:
        raise CrRefusal(missing)
    _refuse_in_use(session, new)
    return old, new


def _refuse_in_use(session: CrSession, name: str) -> None:
    """Refuses a program that is edited or selected."""
    state = session.state
    if name in state.selected.values():
        raise CrRefusal(4190)
    if state.is_edited(name):
        raise CrRefusal(4170)


def _delete_file(session: CrSession, argument: str) -> str:
    name = checked_name(argument)
    _refuse_in_use(session, name)
    session.state.store.delete(name)
    session.state.forget(name)
    return ""


def _protect_file(session: CrSession, argument: str) -> str:
    name, sign = parts(argument, 2)
    name = checked_name(name)
    if name not in session.state.store:
        raise CrRefusal(4140)
    if not re.fullmatch(r"[+-][pq]", sign):
        raise CrRefusal(4460)
    protected = session.state.store[name].protected
    (protected.add if sign[0] == "+" else protected.discard)(sign[1])
    return ""


def _delete_all(session: CrSession) -> str:
    """All programs are gone."""
    state = session.state
    # All are checked before the first is deleted.
    for name in state.store:
        _refuse_in_use(session, name)
    for name in list(state.store):
        state.store.delete(name)
        state.forget(name)
    return ""


# ------------------------------------------------------------------------------------ blocks


def _open_file(session: CrSession, argument: str) -> str:
    name, mode = parts(argument, 2)
    name = checked_name(name)
    if mode not in ("r", "w"):
        raise CrRefusal(5410)
    if session.block is not None:
        raise CrRefusal(6050)
    if mode == "w":
        _refuse_in_use(session, name)
        session.block = BlockFile(name, True, bytearray())
    elif name in session.state.store:
        data = session.state.store[name].text().encode(ENCODING)
        session.block = BlockFile(name, False, bytearray(data))
    else:
        raise CrRefusal(4140)
    return ""


def _read_block(session: CrSession) -> str:
    block = session.block
    if block is None or block.writes:
        raise CrRefusal(5140)
    data = block.data[block.at : block.at + _BLOCK_SIZE]
    block.at += len(data)
    return f"{data.hex().upper()};{int(block.at < len(block.data))}"


def _write_block(session: CrSession, argument: str) -> str:
    block = session.block
    if block is None or not block.writes:
        raise CrRefusal(4200)
    size, content = parts(argument, 2)
    hexadecimal(content or "0", 2 * _BLOCK_SIZE)
    if len(content) != 2 * whole(size, 0, _BLOCK_SIZE):
        raise CrRefusal(4460)
    block.data += bytes.fromhex(content)
    return ""


def _close_file(session: CrSession) -> str:
    """Store the written data as a program; raises CrRefusal 4160 if it is not a program."""
    # The file is closed even if its content is refused below.
    block, session.block = session.block, None
    if block is None:
        raise CrRefusal(6050)
    if block.writes:
        _refuse_in_use(session, block.name)
        program = program_of(bytes(block.data).decode(ENCODING), strict=True)
        program.changed = session.state.now()
        session.state.store.save(block.name, program)
        session.state.forget(block.name)
    return ""


def _free_room(session: CrSession) -> str:
    store = session.state.store
    return f"{store.capacity};{store.used};{100 * store.used // store.capacity}"


def _cycle_time(session: CrSession, argument: str) -> str:
    return session.state.cycles.get(_existing_file(session, argument), Cycles()).fields


def _clear_cycle_time(session: CrSession, argument: str) -> str:
    session.state.cycles.pop(_existing_file(session, argument), None)
    return ""


def _existing_file(session: CrSession, argument: str) -> str:
    name = checked_name(argument)
    if name not in session.state.store:
        raise CrRefusal(4140)
    return name


FILE_COMMANDS: Final = {
    "PDIR": Command(_program_directory),
    "FDIR": Command(_file_directory),
    "FCHECK": Command(_check_file),
    "FPATH=": Command(_set_path),
    "FCOPY": Command(_copy_file),
    "FDEL": Command(_delete_file),
    "FRENAME": Command(_rename_file),
    "FATTRIB": Command(_protect_file),
    "FINIT": Command(bare(_delete_all)),
    "FOPEN": Command(_open_file),
    "FREAD": Command(bare(_read_block)),
    "FWRITE": Command(_write_block),
    "FCLOSE": Command(bare(_close_file)),
    "EFREE": Command(bare(_free_room)),
    "CYCLETIME": Command(_cycle_time),
    "CYCLECLR": Command(_clear_cycle_time),
}
