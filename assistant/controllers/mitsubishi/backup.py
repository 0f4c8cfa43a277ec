"""Backup of a CR controller in a folder of plain text, and its restore.

identity.json             identity of the controller
parameters.txt            the changed ones, `NAME=value` each, sorted
programs/NAME.prg         the controller's listing: steps, then positions; NAME_ for CON, NUL …
variables/NAME.txt        the other variables of that program, where it has any
variables/externals.txt   variables that belong to no program
not-kept.txt              files of the controller other than programs, if any: names only
backup.json               hashes of the other files

A restore shows the differences first. Items that only the controller has stay, and so do parameters
of the origin, of safety and of the network unless they are named. Replaced items are saved next to
the backup, in a folder that can be restored itself.
"""

from __future__ import annotations

import difflib
import json
import re
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import asdict, field
from pathlib import Path as FilePath
from typing import Final

from assistant.base.data_classes import dataclass
from assistant.base.diagnostics import Refused
from assistant.base.source_text import visible
from assistant.controllers import backup_folder, rules
from assistant.controllers.mitsubishi import programs, state, values
from assistant.controllers.mitsubishi.operation import SCRATCH
from assistant.controllers.mitsubishi.session import Session
from assistant.controllers.mitsubishi.values import SECRET_PARAMETER, ParameterKind, why_left_out

KIND: Final = "melfa"
_IDENTITY: Final = "identity.json"
_PARAMETERS: Final = "parameters.txt"
DEVICE: Final = re.compile(r"CON|PRN|AUX|NUL|(?:COM|LPT)[0-9]")
"""Names that stand for devices in Windows, where no file can have them ("Naming Files, Paths, and
Namespaces" of Microsoft)."""
_AFTER_DEVICE: Final = "_"
_EXTERNALS: Final = "variables/externals.txt"
NOT_KEPT: Final = "not-kept.txt"


def backup(session: Session, folder: str | FilePath) -> tuple[str, ...]:
    """Writes the folder, which appears whole or not at all; its files, relative to it."""
    with backup_folder.appearing_folder(folder, KIND) as place, session.scope():
        identity = asdict(state.identify(session))
        backup_folder.put_file(place, _IDENTITY, (json.dumps(identity, indent=2) + "\n").encode())
        there, others = programs.directory(session)
        if others:
            text = "".join(f"{name}\n" for name in others)
            backup_folder.put_file(place, NOT_KEPT, text.encode())
        # The scratch program is this tool's own, and must not come back with a restore.
        for name in (entry.name for entry in there if entry.name != SCRATCH):
            backup_folder.put_file(place, _program_file(name), programs.listed(session, name))
            _put_lines(place, _variable_file(name), values.program_variables(session, name))
        _put_lines(place, _EXTERNALS, values.external_variables(session))
        # Passwords of the controller do not belong in a folder of plain text.
        told = values.read_parameters(session, _without_secrets(values.changed_parameters(session)))
        backup_folder.put_file(place, _PARAMETERS, _parameter_text(told))
    return (backup_folder.INDEX, *backup_folder.backup_files(FilePath(folder)))


def _program_file(name: str) -> str:
    return f"programs/{_stem(name)}.prg"


def _variable_file(name: str) -> str:
    return f"variables/{_stem(name)}.txt"


def _stem(name: str) -> str:
    """Return the name of a program's file, valid in every system."""
    return f"{name}{_AFTER_DEVICE}" if DEVICE.fullmatch(name) else name


def _program_of(file: str) -> str:
    """The program that a file is of."""
    return FilePath(file).stem.removesuffix(_AFTER_DEVICE)


def _without_secrets(names: Iterable[str]) -> list[str]:
    return [name for name in names if not SECRET_PARAMETER.fullmatch(name)]


def _parameter_text(values: Mapping[str, str]) -> bytes:
    """`NAME=value` each, sorted."""
    lines = (f"{name}={values[name]}\n" for name in sorted(values))
    return "".join(lines).encode(programs.ENCODING)


def assignments(data: bytes) -> dict[str, str]:
    """Name → value of the lines of a file."""
    pairs = (line.text.partition("=") for line in programs.program_lines(data))
    blanks = programs.BLANKS
    return {name.strip(blanks): value.strip(blanks) for name, _, value in pairs}


def _variable_text(lines: Iterable[str]) -> bytes:
    """The lines sorted by name, P2 before P10."""
    ordered = sorted(lines, key=lambda line: programs.natural_order(line.partition("=")[0].upper()))
    return "".join(f"{line}\n" for line in ordered).encode(programs.ENCODING)


def _put_lines(place: FilePath, name: str, lines: list[str]) -> None:
    if lines:
        backup_folder.put_file(place, name, _variable_text(lines))


_BACKUP_FILE: Final = re.compile(
    r"programs/[A-Z0-9]{1,12}_?\.prg|variables/(?:[A-Z0-9]{1,12}_?|externals)\.txt"
)
_BEFORE_FOLDER: Final = "before"


@dataclass(frozen=True, slots=True)
class Item:
    """An item that differs. before: its content on the controller, None if missing there.

    file: its file in a backup. restore: writes it and checks that it arrived.
    """

    name: str
    file: str
    before: bytes | None
    after: bytes
    restore: Callable[[], None]


@dataclass
class Restoring:
    """A restore that has not happened yet; see `Restoring` of all controllers.

    kept: the folder with what was replaced, once `apply` has begun.
    """

    items: Sequence[Item]
    left_out: Mapping[str, str]
    folder: FilePath
    kept: FilePath | None = field(default=None, init=False)

    @property
    def changes(self) -> dict[str, str]:
        """Unified differences by what they are of."""
        return {item.name: _difference(item) for item in self.items}

    @property
    def needs_restart(self) -> bool:
        """True if it includes parameters, many of which take effect only after a restart."""
        return any(item.file == _PARAMETERS for item in self.items)

    def apply(self) -> None:
        """Restores one after the other; raises Refused with what has been restored by then."""
        if not self.items:
            return
        self.kept = self._keep()
        done: list[str] = []
        for item in self.items:
            try:
                item.restore()
            except Refused as error:
                partly = rules.RESTORED_PARTLY(
                    place=item.name,
                    name=item.name,
                    done=", ".join(done) or "nothing",
                    kept=self.kept,
                )
                raise type(error)(*error.findings, partly) from error
            done.append(item.name)

    def _keep(self) -> FilePath:
        """Save the present content into a new folder next to the backup."""
        number = 1
        while (
            kept := self.folder.with_name(f"{self.folder.name}.{_BEFORE_FOLDER}-{number}")
        ).exists():
            number += 1
        with backup_folder.appearing_folder(kept, KIND) as place:
            # Several parameters share one file, which is written once.
            together: dict[str, list[bytes]] = {}
            for item in self.items:
                if item.before is not None:
                    together.setdefault(item.file, []).append(item.before)
            for name, parts in together.items():
                backup_folder.put_file(place, name, b"".join(parts))
        return kept


def restoring(
    session: Session,
    folder: str | FilePath,
    only: Sequence[str],
    kinds: Mapping[str, ParameterKind],
) -> Restoring:
    """Compare a backup with the controller and return the restore; raises Refused.

    only: names of files, or of parameters; these are restored and nothing else.
    """
    place = FilePath(folder)
    saved = backup_folder.backup_contents(place, KIND)
    wanted = assignments(saved.get(_PARAMETERS, b""))
    files = {name: data for name, data in saved.items() if _BACKUP_FILE.fullmatch(name)}
    _all_there(only, [*files, *wanted, *([_PARAMETERS] if _PARAMETERS in saved else [])])
    left_out = _of_another_robot(session, saved)
    with session.scope():
        items = [
            *_programs(session, files, only),
            *_variables(session, files, only, left_out),
            *_parameters(session, wanted, only, kinds, left_out),
        ]
        if not only:
            alone = {_program_file(name) for name in programs.names(session)} - {*files}
            left_out |= dict.fromkeys(sorted(alone), "only the controller has it, and it stays")
    return Restoring(items, left_out, place)


def _of_another_robot(session: Session, saved: Mapping[str, bytes]) -> dict[str, str]:
    """That the backup is of another robot, by the file that says so."""
    try:
        told = json.loads(saved.get(_IDENTITY, b"{}"))
    except ValueError:
        return {}
    robot, here = told.get("robot") if isinstance(told, dict) else None, session.about.robot
    if not isinstance(robot, str) or robot == here:
        return {}
    # The names come from a file and a controller: control characters must not reach a terminal.
    one, other = (name if name.isprintable() else ascii(name) for name in (robot, here))
    return {_IDENTITY: f"the backup is of a `{one}`, this is a `{other}`: positions may differ"}


def _all_there(only: Sequence[str], names: Sequence[str]) -> None:
    missing = [name for name in only if name not in names]
    if missing:
        known = ", ".join(sorted(names)[:20])
        raise Refused(
            *(rules.NOT_IN_BACKUP(place=name, name=name, known=known) for name in missing),
            exit_status=2,
        )


def _chosen(name: str, only: Sequence[str]) -> bool:
    return not only or name in only


def _programs(session: Session, files: Mapping[str, bytes], only: Sequence[str]) -> Iterator[Item]:
    there = programs.names(session)
    for file, data in files.items():
        name = _program_of(file)
        if not file.startswith("programs/") or not _chosen(file, only):
            continue
        before = programs.listed(session, name) if name in there else None
        # Compared in one form: the controller lists with other blanks and decimals than were sent.
        if before is None or programs.listed_form(before) != programs.listed_form(data):
            programs.check_text(session, name, data)
            yield Item(file, file, before, data, _program_writer(session, name, data))


def _program_writer(session: Session, name: str, data: bytes) -> Callable[[], None]:
    def restore() -> None:
        programs.write(session, name, data)
        # Read back: SAVE confirms that the program was stored, not what was stored.
        sent, back = (
            programs.listed_form(data),
            programs.listed_form(programs.listed(session, name)),
        )
        if sent != back:
            pairs = enumerate(zip(sent, back, strict=False), start=1)
            at = next((at for at, (one, two) in pairs if one != two), min(len(sent), len(back)) + 1)
            state = "it stays as it is there now"
            raise Refused(
                rules.ALTERED(
                    place=name, name=name, sent=len(sent), back=len(back), at=at, state=state
                )
            )

    return restore


def _variables(
    session: Session, files: Mapping[str, bytes], only: Sequence[str], left_out: dict[str, str]
) -> Iterator[Item]:
    there = programs.names(session)
    for file, data in files.items():
        name = _program_of(file)
        shared = file == _EXTERNALS
        if not _chosen(file, only) or not (shared or file.startswith("variables/")):
            continue
        lines = (
            values.external_variables(session)
            if shared
            else values.program_variables(session, name)
            if name in there
            else []
        )
        now, saved = assignments(_variable_text(lines)), assignments(data)
        # Writing these moves or switches something that is connected: a restore must never do that.
        acting = [n for n in saved if shared and values.ACTING_VARIABLE.fullmatch(n.upper())]
        left_out |= dict.fromkeys(acting, "it acts on what is connected to the controller")
        saved = {n: v for n, v in saved.items() if n not in acting}
        # Only what differs: writing a variable needs its program to stand.
        changed = {
            n: v for n, v in saved.items() if n not in now or not values.same_value(now[n], v)
        }
        if changed:
            before = _variable_text(f"{n}={now[n]}" for n in changed if n in now)
            after = _variable_text(f"{n}={v}" for n, v in changed.items())
            writer = _variable_writer(session, "" if shared else name, changed)
            yield Item(file, file, before or None, after, writer)


def _variable_writer(
    session: Session, program: str, changed: Mapping[str, str]
) -> Callable[[], None]:
    def restore() -> None:
        if program:
            values.write_saved_variables(session, program, changed)
            return
        with session.scope():
            for name, value in changed.items():
                values.write_variable(session, name, value)

    return restore


def _parameters(
    session: Session,
    wanted: Mapping[str, str],
    only: Sequence[str],
    kinds: Mapping[str, ParameterKind],
    left_out: dict[str, str],
) -> Iterator[Item]:
    for name, value in sorted(wanted.items()):
        if not _chosen(name, only) and _PARAMETERS not in only:
            continue
        values.checked_parameter_name(name)
        told = session.attempt(f"PNR{name}", doing=f"reading parameter {name}")
        now = values.read_parameter(session, name) if told.ok else None
        if now is not None and values.same_value(now, value):
            continue
        reason = None if name in only else why_left_out(name)
        if reason is not None:
            left_out[name] = reason
            continue
        before = None if now is None else _parameter_text({name: now})
        writer = _parameter_writer(session, name, value, kinds)
        yield Item(name, _PARAMETERS, before, _parameter_text({name: value}), writer)


def _parameter_writer(
    session: Session, name: str, value: str, kinds: Mapping[str, ParameterKind]
) -> Callable[[], None]:
    return lambda: values.write_parameter(session, name, value, kinds)


def _difference(item: Item) -> str:
    """A unified difference, without control characters."""
    left, right = _shown(item.before or b""), _shown(item.after)
    origin = f"{item.name} (on the controller)" if item.before is not None else "/dev/null"
    lines = difflib.unified_diff(left, right, origin, f"{item.name} (restored)", lineterm="")
    return "".join(f"{line}\n" for line in lines)


def _shown(data: bytes) -> list[str]:
    lines = programs.program_lines(data)
    return [visible(line.text) for line in lines]
