"""Copy programs and complete backups between a controller and this computer.

`get`, `put`, `rm`, `backup` and `restore` look at everything before the first file is changed, and
ask before they delete or overwrite. Parts that a backup of a controller lacks are listed.
"""

from __future__ import annotations

import os
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Final

from assistant.base.diagnostics import Refused, error
from assistant.base.file_access import read_file
from assistant.base.source_text import lines_of
from assistant.cli.command import argument, command, option
from assistant.cli.controller_session import (
    CellArgument,
    ReplaceOption,
    Session,
    YesOption,
    confirm,
    connected,
    print_there,
)
from assistant.cli.options import FormatOption
from assistant.cli.presentation import Format, note, say, working

if TYPE_CHECKING:
    from assistant.controllers.controller import Restoring


_NO_PROGRAM: Final = error(
    "CL210", "there is no program `{name}` on {address}", "`robot-assistant ls` lists them"
)
_FILE_THERE: Final = error(
    "CL211",
    "`{name}` is there already and says something else; it was not touched",
    "name another place with -o, or add --replace",
)
_PROGRAM_THERE: Final = error(
    "CL212",
    "`{name}` is on {address} already and is something else; it was not touched",
    "add --replace, or use `robot-assistant deploy --replace {name}`, which keeps what was there",
)
_NO_PLAIN_NAME: Final = error(
    "CL213", "`{name}` cannot be a file here", "name the file to write with -o"
)
_FOLDER_THERE: Final = error(
    "CL214",
    "`{folder}` is there already: a backup gets a folder of its own",
    "name one that is not there",
)
_NO_BACKUP: Final = error(
    "CL215", "there is no folder `{folder}`", "name a folder that `backup` has written"
)
_ONE_FILE: Final = error("CL216", "several programs do not go into one file", "name a folder")


@command
class Get:
    """Copy programs from a controller."""

    cell: CellArgument
    names: tuple[str, ...] = argument("Programs, as `ls` lists them.")
    output: str | None = option("File, folder, or - to print.", "--output", "-o")
    replace: ReplaceOption
    format: FormatOption

    def run(self) -> int:
        """Write programs into files named like them, a folder that is there, or a file."""
        from assistant.base.file_sets import write_files

        into = Path(self.output or ".")
        if len(self.names) > 1 and (self.output == "-" or not into.is_dir()):
            raise Refused(_ONE_FILE(), exit_status=2)
        with connected(self.cell, "get") as there:
            found = {name: _read_program(there, name) for name in self.names}
        if self.output == "-":
            for data in found.values():
                sys.stdout.buffer.write(data)
            sys.stdout.flush()
            return 0
        folder = into if into.is_dir() else into.parent
        files = {
            _local_file_name(name) if into.is_dir() else into.name: d for name, d in found.items()
        }
        for name, data in files.items():
            path = folder / name
            if not self.replace and path.exists() and (path.is_dir() or read_file(path) != data):
                raise Refused(_FILE_THERE(path=str(path), name=path))
        written = write_files(files, folder)
        answer = {"written": [str(path) for path in written]}
        print_there(there, self.format, answer, (f"wrote {path}" for path in written))
        return 0


def _read_program(there: Session, name: str) -> bytes:
    data = there.session.read(name)
    if data is None:
        raise Refused(_NO_PROGRAM(name=name, address=there.one.address))
    return data


def _local_file_name(name: str) -> str:
    """The name of a program as a file's; raises Refused for one that leads elsewhere."""
    if Path(name).name != name or name in {"", ".", ".."} or os.sep in name or "\\" in name:
        raise Refused(_NO_PLAIN_NAME(name=name), exit_status=2)
    return name


@command
class Put:
    """Copy programs to a controller as they are; `deploy` also checks, keeps and compares."""

    cell: CellArgument
    files: tuple[Path, ...] = argument("Programs.")
    replace: ReplaceOption
    format: FormatOption

    def run(self) -> int:
        """Send files as programs; the existing programs are checked before the first file is
        written.
        """
        from assistant.base.source_text import read_bytes

        data = {file: read_bytes(file) for file in self.files}
        with connected(self.cell, "put") as there:
            session = there.session
            names = {file: session.name_for(file) for file in self.files}
            for file, name in names.items():
                session.check_text(name, data[file])
                before = session.read(name)
                same = before is None or session.stored(before) == session.stored(data[file])
                if not same and not self.replace:
                    address = there.one.address
                    raise Refused(_PROGRAM_THERE(path=str(file), name=name, address=address))
            for file, name in names.items():
                session.write(name, data[file])
        lines = (f"{file} is `{name}` on {there.one.name}" for file, name in names.items())
        print_there(there, self.format, {"programs": [*names.values()]}, lines)
        return 0


@command
class Rm:
    """Delete programs on a controller that nothing there has loaded. Asks before."""

    cell: CellArgument
    names: tuple[str, ...] = argument("Programs or other files, as `ls` lists.")
    yes: YesOption
    format: FormatOption

    def run(self) -> int:
        """Delete programs; all of them are checked before the first one is deleted."""
        from assistant.deploy.preconditions import check_removable, found_programs, unseen_use

        with connected(self.cell, "rm") as there:
            address = there.one.address
            found = found_programs(there.session, self.names)
            missing = [
                _NO_PROGRAM(name=name, address=address) for name, one in found.items() if not one
            ]
            wanted = list(dict.fromkeys(one for one in found.values() if one))
            check_removable(there.session, [name for name, one in found.items() if not one])
            if missing:
                raise Refused(*missing)
            check_removable(there.session, wanted)
            for finding in unseen_use(there.session, wanted):
                note(str(address), finding)
            listed = ", ".join(f"`{name}`" for name in wanted)
            confirm(there.one, f"deletes {listed}, which nothing brings back", self.yes)
            for name in wanted:
                there.session.remove(name)
        lines = (f"deleted `{name}` on {there.one.name}" for name in wanted)
        print_there(there, self.format, {"deleted": wanted}, lines)
        return 0


@command
class Backup:
    """Write programs, parameters and variables of a controller into a folder."""

    cell: CellArgument
    folder: Path = argument("A folder that is not there yet.")
    format: FormatOption

    def run(self) -> int:
        if self.folder.exists():
            raise Refused(_FOLDER_THERE(path=str(self.folder), folder=self.folder), exit_status=2)
        with connected(self.cell, "backup") as there, working(f"backing up {there.one.name}"):
            files = there.controller.backup(self.folder)
            _note_left_out(str(there.one.address), self.folder)
        answer = {"folder": str(self.folder), "files": [*files]}
        lines = (f"{len(files)} files of {there.one.name} are in {self.folder}",)
        print_there(there, self.format, answer, lines)
        return 0


def _note_left_out(address: str, folder: Path) -> None:
    """Says what a controller has that its backup has not."""
    from assistant.controllers import rules
    from assistant.controllers.mitsubishi.backup import NOT_KEPT

    listed = folder / NOT_KEPT
    if listed.is_file():
        names = lines_of(listed.read_text("utf-8", errors="replace"))
        some = ", ".join(names[:5]) + (" …" if len(names) > 5 else "")
        note(address, rules.LEFT_OUT(path=str(folder), count=len(names), names=some, file=listed))


@command
class Restore:
    """Show what differs from a backup, and bring it back; origin, safety, network only by name."""

    cell: CellArgument
    folder: Path = argument("A folder that `backup` has written.")
    only: tuple[str, ...] = option(
        "Only this file or parameter, also of those left out; repeatable."
    )
    dry_run: bool = option("Only show what would change.")
    yes: YesOption
    format: FormatOption

    def run(self) -> int:
        """Shows what differs, asks, and brings it back."""
        if not self.folder.is_dir():
            raise Refused(_NO_BACKUP(path=str(self.folder), folder=self.folder), exit_status=2)
        with connected(self.cell, "restore") as there:
            with working(f"comparing with {there.one.name}"):
                restoring = there.controller.restore(self.folder, only=self.only)
            if self.format is Format.TEXT:
                _print_changes(restoring)
            wanted = bool(restoring.changes) and not self.dry_run
            if wanted:
                sys.stdout.flush()
                confirm(
                    there.one, f"changes {len(restoring.changes)} parts of the controller", self.yes
                )
                with working(f"restoring {there.one.name}"):
                    restoring.apply()
        if not restoring.changes:
            lines = [f"{there.one.name} is as the backup says: nothing to restore"]
        else:
            lines = [f"{there.one.name}: {'restored' if wanted else 'nothing has been changed'}"]
            if wanted and restoring.needs_restart:
                lines.append("some parameters may hold only after the controller is restarted")
        answer = {
            "restored": wanted,
            "changes": dict(restoring.changes),
            "left_out": dict(restoring.left_out),
            "needs_restart": restoring.needs_restart,
        }
        print_there(there, self.format, answer, lines)
        return 0


def _print_changes(restoring: Restoring) -> None:
    for what, difference in restoring.changes.items():
        say(what)
        sys.stdout.write(difference if difference.endswith("\n") else difference + "\n")
    for what, why in restoring.left_out.items():
        say(f"left out: {what}: {why}")
