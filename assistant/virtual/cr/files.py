"""Commands about files: directories, copies, attributes, and their content in blocks.

A file of this controller is a program, and its content the text of that: a controller of iron
keeps a form of its own, which only it can read.
"""

from __future__ import annotations

import re
from typing import Final

from assistant.virtual.cr.command import Command, bare, hexadecimal, parts, whole
from assistant.virtual.cr.state import BlockFile, CrSession, Cycles
from assistant.virtual.cr.store import ENCODING, CrRefusal, checked_name, program_of

PROGRAM_FOLDER: Final = "/robprg/dat/"
BLOCK_SIZE: Final = 120
"""Bytes of a file in one answer (FWRITE in BFP-A4288)."""
PLAIN_ATTRIBUTE: Final = 12
"""Attribute of a file that nothing protects (PDIR in BFP-A4288)."""
PROTECTED_ATTRIBUTE: Final = {"p": 1, "q": 2}
"""Bits of the attribute, which no manual tells: lines, variables."""
ALL_FILES: Final = "<*.*"


def _program_directory(session: CrSession, argument: str) -> str:
    name, first = _file_at(session, argument)
    if name is None:
        return ""
    program = session.state.store[name]
    cycles = session.state.cycles.get(name, Cycles())
    counts = [len(program.steps), len(program.variables)]
    return ";".join([_directory_entry(session, name, first), "", *map(str, counts), cycles.fields])


def _file_directory(session: CrSession, argument: str) -> str:
    name, first = _file_at(session, "TOP" if argument == ALL_FILES else argument)
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
    bits = sum(bit for letter, bit in PROTECTED_ATTRIBUTE.items() if letter in program.protected)
    return ";".join([*entry, str(PLAIN_ATTRIBUTE | bits)])


def _check_file(session: CrSession, argument: str) -> str:
    return "N" if checked_name(argument) in session.state.store else "F"


def _set_path(session: CrSession, argument: str) -> str:
    name = checked_name(argument)
    if name not in session.state.store:
        raise CrRefusal(4140)
    return f"{PROGRAM_FOLDER}{name}.{session.state.suffix}"


def _copy_file(session: CrSession, argument: str) -> str:
    old, new = _file_and_new_name(session, argument, missing=7000)
    program = session.state.store[old].copy()
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
    data = block.data[block.at : block.at + BLOCK_SIZE]
    block.at += len(data)
    return f"{data.hex().upper()};{int(block.at < len(block.data))}"


def _write_block(session: CrSession, argument: str) -> str:
    block = session.block
    if block is None or not block.writes:
        raise CrRefusal(4200)
    size, content = parts(argument, 2)
    hexadecimal(content or "0", 2 * BLOCK_SIZE)
    if len(content) != 2 * whole(size, 0, BLOCK_SIZE):
        raise CrRefusal(4460)
    block.data += bytes.fromhex(content)
    return ""


def _close_file(session: CrSession) -> str:
    """What was written becomes a program; 4160 if it is none."""
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
