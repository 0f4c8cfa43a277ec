"""Mirrored files: what a function reads here is read by another computer as if it were there.

The other computer has a folder, the mirror, in which the files have the paths that they have
here. It begins with the files that the arguments name. Whatever a function looks at beyond them,
be it the presence of a file, ends the function: it runs again with a mirror that holds this, too.
So its answer is the one that it would give here, and only files that it reads travel.

`SentFiles` is the side of the files, `Mirror` the other one. What cannot be mirrored, such as a
pipe, raises `NotMirrored` there, and the function has to run where the files are.
"""

from __future__ import annotations

import hashlib
import io
import os
import pickle
import re
import stat
import sys
from collections import Counter
from collections.abc import Callable, Iterable, Mapping, Sequence
from contextlib import suppress
from dataclasses import field
from pathlib import Path as FilePath
from pathlib import PurePath
from typing import Any, Final, Literal, NamedTuple

from assistant.base.budgets import FACTOR_VARIABLE
from assistant.base.data_classes import dataclass
from assistant.base.file_access import read_file

MOST_BYTES: Final = 1 << 30
"""Bytes of a file that still travels."""
_MOST_LINKS: Final = 40
"""Links that the system follows in one path."""
_LONGEST_NAME: Final = 4096
"""Characters of a text that may be a path."""
_VARIABLES: Final = (FACTOR_VARIABLE, "OPENBLAS_NUM_THREADS")
"""Environment variables that answers depend on."""
_ABSOLUTE: Final = re.compile(r"/[^/\s]")
"""Beginning of a text that counts as an absolute path; a `/` alone may divide numbers."""
_TEXT, _PATH = "t", "p"
"""Beginnings of the marks of texts and paths that are other ones on the other computer."""
_SETTINGS: Final = ".toml"
"""End of the files beside a source, of its name, that most probably belong to it."""


class Entry(NamedTuple):
    """The kind of thing at a path. size: of a file. target: of a link.

    An unreadable file and a `special` one, such as a pipe, travel by name only; a path that cannot
    be examined does not travel.
    """

    kind: Literal["folder", "file", "link", "absent", "unreadable", "special", "unknown"]
    size: int = 0
    target: str = ""


ABSENT: Final = Entry("absent")
FOLDER: Final = Entry("folder")


class Want(NamedTuple):
    """A request for a path of the files' computer: its entry, the names in a folder, or the bytes
    of a file.
    """

    what: Literal["entry", "names", "bytes"]
    path: str


def walk(path: str, look: Callable[[str], Entry], follow: bool = True) -> tuple[str, Entry]:
    """Return where an absolute path leads, by what stands at each folder on the way.

    follow: also a link at its end.
    """
    left = path.split("/")[::-1]
    at, links = "/", 0
    while left:
        name = left.pop()
        if name in ("", "."):
            continue
        if name == "..":
            at = os.path.dirname(at)  # noqa: PTH120 (of a computer that need not be this one)
            continue
        here = f"{at.rstrip('/')}/{name}"
        entry = look(here)
        if entry.kind == "link" and (follow or left):
            links += 1
            if links > _MOST_LINKS:
                return here, ABSENT
            left += entry.target.split("/")[::-1]
            at = "/" if entry.target.startswith("/") else at
        elif entry.kind == "folder":
            at = here
        else:
            return here, entry if not any(left) else ABSENT
    return at, FOLDER


@dataclass(frozen=True, slots=True)
class Part:
    """Bytes that the mirror has to hold; `key` says which. what: names of a folder, or a file."""

    want: Want
    key: str
    data: bytes


@dataclass(frozen=True, slots=True)
class Call:
    """A call of a function for the other computer.

    call: function and argument. folder: in which it runs. entries: by path. parts: names and files;
    of those that the mirror has already the bytes may be empty. environment: variables.
    """

    call: bytes
    folder: str
    entries: Mapping[str, Entry]
    parts: Sequence[Part]
    environment: Mapping[str, str | None]


class NotMirrored(Exception):
    """A path that cannot be mirrored."""


# The side of the files.


class _CallPickler(pickle.Pickler):
    """Marks absolute paths, for the mirror has other ones, and collects all that may be a path."""

    def __init__(self, file: io.BytesIO) -> None:
        super().__init__(file, protocol=pickle.HIGHEST_PROTOCOL)
        self.paths: dict[str, None] = {}

    def persistent_id(self, obj: Any) -> str | None:
        # One text: what a tuple holds would be asked for again.
        if type(obj) is str:
            if not 0 < len(obj) < _LONGEST_NAME or "\0" in obj or "\n" in obj:
                return None
            self.paths[obj] = None
            return _TEXT + obj if _ABSOLUTE.match(obj) else None
        if isinstance(obj, PurePath):
            self.paths[str(obj)] = None
            return _PATH + str(obj) if obj.is_absolute() else None
        return None


class _ResultUnpickler(pickle.Unpickler):
    def persistent_load(self, pid: Any) -> Any:
        if isinstance(pid, bytes):
            return pid
        return FilePath(pid[1:]) if pid[0] == _PATH else pid[1:]


@dataclass(slots=True)
class Packed:
    """A function with its argument, and what of the files it is known to want."""

    call: bytes
    wants: dict[Want, None]


class SentFiles:
    """The files of this computer, each looked at once: all calls find the same.

    Files that several calls have wanted are sent with each, so that only the first ones ask.
    """

    def __init__(self) -> None:
        self.folder = os.getcwd()  # noqa: PTH109
        self._entries: dict[str, Entry] = {}
        self._parts: dict[Want, Part] = {}
        self._times = Counter[Want]()
        self._named: dict[str, tuple[Want, ...]] = {}

    def packed(self, function: Callable[..., Any], argument: object) -> Packed:
        """Return a call with the files that its argument names, and those that belong to them."""
        file = io.BytesIO()
        pickler = _CallPickler(file)
        pickler.dump((function, argument))
        wants = dict.fromkeys([Want("entry", self.folder)])
        for path in pickler.paths:
            wants |= dict.fromkeys(self._wants_of(path))
        return Packed(file.getvalue(), wants)

    def _wants_of(self, path: str) -> tuple[Want, ...]:
        """Requests for a path that an argument may name."""
        if path not in self._named:
            self._named[path] = self._look_at(os.path.join(self.folder, path))  # noqa: PTH118
        return self._named[path]

    def _look_at(self, path: str) -> tuple[Want, ...]:
        place, entry = walk(path, self._entry)
        if entry.kind != "file":
            return (Want("entry", path),) if entry.kind in ("folder", "link") else ()
        folder, name = os.path.split(place)
        names = Want("names", folder)
        stem = name.partition(".")[0] + "."
        files = [
            Want("bytes", f"{folder.rstrip('/')}/{one}")
            for one, found in self._names(folder).items()
            if one == name or (one.startswith(stem) and one.endswith(_SETTINGS))
            if found.kind == "file"
        ]
        return Want("entry", path), names, *files

    def learn(self, packed: Packed, wants: Iterable[Want]) -> bool:
        """Note what a call wanted besides; return False if all of it has travelled already."""
        fresh = [one for one in dict.fromkeys(wants) if one not in packed.wants]
        packed.wants |= dict.fromkeys(fresh)
        self._times.update(fresh)
        return bool(fresh)

    def call(self, packed: Packed) -> Call:
        """Return all that is known to be wanted; raises NotMirrored."""
        entries: dict[str, Entry] = {}
        parts: dict[Want, Part] = {}

        def look(path: str) -> Entry:
            return entries.setdefault(path, self._entry(path))

        def add(want: Want) -> None:
            place, entry = walk(want.path, look, follow=want.what != "entry")
            if want.what == "entry":
                walk(want.path, look)
            elif entry.kind == ("folder" if want.what == "names" else "file"):
                own = Want(want.what, place)
                parts[own] = self._part(own, entry)

        for want in packed.wants:
            add(want)
        for want, times in self._times.items():
            if times > 1 and want not in packed.wants:
                with suppress(NotMirrored):  # this call may do without
                    add(want)
        variables = {name: os.environ.get(name) for name in _VARIABLES}
        return Call(packed.call, self.folder, entries, tuple(parts.values()), variables)

    def _entry(self, path: str) -> Entry:
        if path not in self._entries:
            self._entries[path] = _entry_at(path)
        return self._entries[path]

    def _names(self, folder: str) -> Mapping[str, Entry]:
        try:
            found: dict[str, Entry] = pickle.loads(self._part(Want("names", folder), FOLDER).data)  # noqa: S301
        except NotMirrored:
            return {}
        return found

    def _part(self, want: Want, entry: Entry) -> Part:
        if want not in self._parts:
            try:
                data = _bytes_of(want, entry)
            except (OSError, ValueError) as error:
                raise NotMirrored(want.path) from error
            key = hashlib.sha256(data).hexdigest()
            self._parts[want] = Part(want, key, data)
        return self._parts[want]


def _entry_at(path: str) -> Entry:
    try:
        found = os.lstat(path)
        if stat.S_ISLNK(found.st_mode):
            return Entry("link", target=os.readlink(path))  # noqa: PTH115
    except (FileNotFoundError, NotADirectoryError):
        return ABSENT
    except (OSError, ValueError):
        return Entry("unknown")
    if stat.S_ISDIR(found.st_mode):
        return FOLDER
    if not stat.S_ISREG(found.st_mode):
        return Entry("special")
    return Entry("file" if os.access(path, os.R_OK) else "unreadable", found.st_size)


def _bytes_of(want: Want, entry: Entry) -> bytes:
    """A file, or the names in a folder with their entries."""
    if want.what == "bytes":
        if entry.size > MOST_BYTES:
            raise ValueError(want.path)
        return read_file(want.path, MOST_BYTES)
    found = sorted(FilePath(want.path).iterdir())
    return pickle.dumps({one.name: _entry_at(str(one)) for one in found})


def result_of(data: bytes) -> Any:
    """Return what a function returned over there, with the paths of this computer.

    Raises the OSError that it raised.
    """
    result = _ResultUnpickler(io.BytesIO(data)).load()
    if isinstance(result, _Raised):
        raise result.error
    return result


# The other side.


@dataclass(frozen=True, slots=True)
class _Raised:
    error: OSError


class _Lacking(BaseException):
    """A function looked for what the mirror does not hold. No `Exception`: nothing goes on."""


class _CallUnpickler(pickle.Unpickler):
    def __init__(self, file: io.BytesIO, root: str) -> None:
        super().__init__(file)
        self._root = root

    def persistent_load(self, pid: Any) -> Any:
        place = self._root + pid[1:]
        return FilePath(place) if pid[0] == _PATH else place


class _ResultPickler(pickle.Pickler):
    """Takes the folder of the mirror out of paths and texts."""

    def __init__(self, file: io.BytesIO, root: str) -> None:
        super().__init__(file, protocol=pickle.HIGHEST_PROTOCOL)
        self._root, self._octets = root, root.encode()

    def persistent_id(self, obj: Any) -> str | bytes | None:
        if type(obj) is str:
            return _TEXT + self._plain(obj) if self._root in obj else None
        if type(obj) is bytes:
            return obj.replace(self._octets, b"") if self._octets in obj else None
        if isinstance(obj, PurePath) and str(obj).startswith(self._root):
            return _PATH + self._plain(str(obj))
        return None

    def _plain(self, text: str) -> str:
        return text.replace(self._root, "") if text != self._root else "/"


@dataclass(frozen=True, slots=True)
class Answered:
    """The outcome of a function: its result, or what it lacks; neither if it cannot run."""

    result: bytes | None = None
    wants: tuple[Want, ...] = ()


@dataclass(slots=True)
class Mirror:
    """The mirror in this process. root: its folder, with all links in it followed.

    entries: what stands at paths. listed: folders of which all names are there. held: what stands
    where, by its key. wants: what the function lacked. watching: while a function runs.
    """

    root: str
    entries: dict[str, Entry] = field(default_factory=dict)
    listed: dict[str, dict[str, Entry]] = field(default_factory=dict)
    held: dict[str, str] = field(default_factory=dict)
    wants: list[Want] = field(default_factory=list)
    failed: bool = False
    watching: bool = False

    def run(self, call: Call) -> Answered:
        self._take(call)
        os.chdir(self.root + call.folder)
        for name, value in call.environment.items():
            os.environ.pop(name, None)
            if value is not None:
                os.environ[name] = value
        self.wants, self.failed = [], False
        self.watching = True
        result = None
        try:
            function, argument = _CallUnpickler(io.BytesIO(call.call), self.root).load()
            result = function(argument)
        except _Lacking:
            pass
        except OSError as error:
            result = _Raised(error)
        except Exception:
            if not (self.wants or self.failed):
                raise
        finally:
            self.watching = False
        # A function that caught the exception has answered without the missing file.
        if self.failed:
            return Answered()
        if self.wants:
            return Answered(wants=tuple(self.wants))
        file = io.BytesIO()
        _ResultPickler(file, self.root).dump(result)
        return Answered(file.getvalue())

    def _take(self, call: Call) -> None:
        for path, entry in call.entries.items():
            self._add(path, entry)
        for part in call.parts:
            path = part.want.path
            if part.want.what == "bytes":
                if self.held.get(path) != part.key:
                    FilePath(self.root + path).write_bytes(part.data)
                    self.held[path] = part.key
            elif path not in self.listed:
                names: dict[str, Entry] = pickle.loads(part.data)  # noqa: S301
                self.listed[path] = names
                for name, entry in names.items():
                    self._add(f"{path.rstrip('/')}/{name}", entry)

    def _add(self, path: str, entry: Entry) -> None:
        """Have at a path what the files' computer has there; of a file, its size."""
        if path in self.entries:
            return
        self.entries[path] = entry
        place = FilePath(self.root + path)
        place.parent.mkdir(parents=True, exist_ok=True)
        if entry.kind == "folder":
            place.mkdir(exist_ok=True)
        elif entry.kind == "special":
            os.mkfifo(place)
        elif entry.kind in ("file", "unreadable"):
            with place.open("wb") as file:
                file.truncate(entry.size)
        elif entry.kind == "link":
            inner = entry.target.startswith("/")
            place.symlink_to(self.root + entry.target if inner else entry.target)

    def look(self, path: str) -> Entry:
        """Return the entry of a path; raise KeyError if it is not known."""
        above, name = os.path.split(path)
        if path not in self.entries and above in self.listed:
            return self.listed[above].get(name, ABSENT)
        return self.entries[path]

    def inside(self, path: Any) -> str | None:
        """The path on the files' computer, None for one of this computer."""
        if isinstance(path, int):
            return None
        text = os.path.join(os.getcwd(), os.fsdecode("." if path is None else path))  # noqa: PTH109, PTH118
        if not f"{text}/".startswith(f"{self.root}/"):
            return None
        depth = 0
        for name in (rest := text[len(self.root) :]).split("/"):
            depth += 0 if name in ("", ".") else -1 if name == ".." else 1
            if depth < 0:  # the mirror has a folder above the outermost one
                self.give_up()
        return rest or "/"

    def require(self, path: Any, what: Literal["entry", "names", "bytes"], follow: bool) -> None:
        """Ends the function if the mirror does not hold what it is about to look at."""
        own = self.inside(path)
        if own is None:
            return
        try:
            place, entry = walk(own, self.look, follow)
        except KeyError:
            self.lack(Want("entry", own))
        if entry.kind in ("unreadable", "special", "unknown"):
            self.give_up()
        lacks_names = what == "names" and entry.kind == "folder" and place not in self.listed
        if lacks_names or (what == "bytes" and entry.kind == "file" and place not in self.held):
            self.lack(Want(what, own))

    def lack(self, want: Want) -> None:
        self.wants.append(want)
        raise _Lacking

    def give_up(self) -> None:
        self.failed = True
        raise _Lacking


def answer(given: tuple[str, Call]) -> Answered:
    """Run a call in the mirror at a folder; one folder in a process, which does nothing else."""
    root, call = given
    if not _MIRRORS:
        _MIRRORS.append(Mirror(os.path.realpath(root)))
        _watch(_MIRRORS[0])
    return _MIRRORS[0].run(call)


_MIRRORS: Final[list[Mirror]] = []
_LISTING_EVENTS: Final = ("os.listdir", "os.scandir")
_WRITING: Final = os.O_WRONLY | os.O_RDWR


def _watch(mirror: Mirror) -> None:
    """Have the mirror see each look at a file from now on.

    Python reports files that are opened and folders that are listed, but no look at whether a file
    is there: those functions are replaced.
    """
    # Nothing is imported from a folder of somebody else.
    sys.path[:] = [one for one in sys.path if FilePath(one).is_absolute()]

    def report(event: str, arguments: tuple[Any, ...]) -> None:
        if not mirror.watching:
            return
        if event == "open":
            path, _, flags = arguments
            if isinstance(flags, int) and flags & _WRITING and mirror.inside(path) is not None:
                mirror.give_up()  # it would be written nowhere
            mirror.require(path, "bytes", follow=True)
        elif event in _LISTING_EVENTS:
            mirror.require(arguments[0], "names", follow=True)

    def watched(function: Callable[..., Any], follow: bool) -> Callable[..., Any]:
        def call(path: Any, *arguments: Any, **options: Any) -> Any:
            if mirror.watching and options.get("dir_fd") is None:
                mirror.require(path, "entry", follow and options.get("follow_symlinks", True))
            return function(path, *arguments, **options)

        return call

    sys.addaudithook(report)
    for name, follow in (("stat", True), ("access", True), ("lstat", False), ("readlink", False)):
        setattr(os, name, watched(getattr(os, name), follow))
