"""Controllers with programs, whose whole state can be looked at and brought back.

Each has two programs of an earlier deployment and some of somebody else; a deployment is to change
both and to bring a third one.
"""

import contextlib
import os
import subprocess
import time

import pytest

from assistant import deploy as deploying
from assistant.controllers import connect
from assistant.deploy.site import of_deployments
from assistant.virtual.cr import VirtualCr
from assistant.virtual.cr.store import program_of
from assistant.virtual.irc5 import VirtualIrc5
from tests.controllers.abb import ftp_servers
from tests.controllers.abb.sftp_server import PASSWORD, SftpServer
from tests.deploy.meddling import Meddler

MODULE = "MODULE {}\r\n  PROC {}()\r\n    WaitTime {};\r\n  ENDPROC\r\nENDMODULE\r\n"
PROGRAM = (
    "10 OVRD 50\r\n20 DLY {}\r\n30 END\r\nP1=(+{}.00,+0.00,+450.00,+0.00,+180.00,+0.00)(6,0)\r\n"
)


def module(name, value, rows=0):
    text = MODULE.format(name, f"{name}_main", value)
    return (text + "! a comment that makes it longer\r\n" * rows).encode()


class Bench:
    """port: of the proxy in front of it, which clients use. local: the files to deploy."""

    names = ("a.mod", "b.mod", "c.mod")
    refusals = (b"550 refused\r\n", b"452 no room\r\n", b"421 going down\r\n")
    """What a server may answer instead of doing what it was asked for."""

    def __init__(self, folder):
        self.folder = folder
        self.history = folder / "history"
        self.old_files, self.local = self.sources(folder)

    def sources(self, folder):
        """Local files of the earlier deployment, and those to deploy."""
        found = []
        for value, names in ((1, self.names[:2]), (2, self.names)):
            (folder / f"v{value}").mkdir()
            files = []
            for number, name in enumerate(names):
                files.append(folder / f"v{value}" / self.file(name))
                files[-1].write_bytes(self.source(name, value, 20 * number))
            found.append(files)
        return found

    def file(self, name):
        return name

    def source(self, name, value, rows):
        return module(name.split(".")[0], value, rows)

    @contextlib.contextmanager
    def ready(self):
        """Running, with the earlier deployment."""
        with self.running(), Meddler(self.real_port) as self.proxy:
            self.put_foreign()
            self.first(self.client())
            self.start = self.state()
            self.old = self.programs()
            self.new = {**self.old, **dict(zip(self.names, self.wanted(), strict=True))}
            yield self

    def first(self, client):
        done = deploying.deploy(
            deploying.plan(self.old_files, client, history=self.history),
            history=self.history,
            files_only=True,
        )
        assert done.ok

    def wanted(self):
        return [file.read_bytes() for file in self.local]

    def deploy(self, patience=0.0):
        """None where it could not be begun."""
        client = self.client()
        plan = deploying.plan(self.local, client, history=self.history)
        return deploying.deploy(plan, history=self.history, files_only=True, patience=patience)

    def arguments(self):
        """Of the command line, for the same."""
        files = [str(file) for file in self.local]
        history = ["--history", str(self.history)]
        return ["deploy", *files, "--to", self.address(), "--files-only", *history]

    def refused(self, steps):
        """Steps of a conversation, with what may be answered instead."""
        return [(step, answer) for step in range(steps) for answer in self.refusals]

    @contextlib.contextmanager
    def refusing(self, step, answer):
        self.proxy.arm(step=step, answer=answer)
        yield
        self.proxy.arm()

    def resume(self):
        return deploying.resume(self.client(), history=self.history, patience=3.0)

    def rollback(self):
        return deploying.rollback(self.client(), history=self.history, patience=3.0)

    def client(self):
        return connect(self.address(), password=self.password, timeout=5.0)

    def quiet(self):
        """Waits until what is left of a conversation has come to its end; the state then."""
        self.proxy.calm()
        last = self.state()
        while True:
            time.sleep(0.02)
            now = self.state()
            if now == last:
                return now
            last = now

    def state(self):
        return files_below(self.home), files_below(self.history)

    def restore(self, state):
        for folder, files in zip((self.home, self.history), state, strict=True):
            make_files(folder, files)

    def programs(self):
        """Those that count: no rests of transfers, nothing that deployments keep."""
        files = files_below(self.home)
        return {name: data for name, data in files.items() if name in FOREIGN or not ours(name)}

    def rests(self):
        """What should be gone once a deployment has ended."""
        found = set(files_below(self.home)) - set(FOREIGN)
        return sorted(n for n in found if "~" in n or n.endswith((".lock", ".claim.json")))

    def record(self):
        return files_below(self.home).get("robot-assistant.json")

    def put_foreign(self):
        make_files(self.home, FOREIGN)


FOREIGN = {"other.mod": module("other", 7), "z.mod~": b"somebody kept this\r\n", "notes.txt": b"x"}


def ours(name):
    return of_deployments(name)


def files_below(folder):
    """Every file with its bytes; of folders None."""
    found = {}
    for path in sorted(folder.rglob("*")):
        with contextlib.suppress(FileNotFoundError):
            found[path.relative_to(folder).as_posix()] = (
                None if path.is_dir() else path.read_bytes()
            )
    found.pop("lock", None)
    return {name: data for name, data in found.items() if not name.endswith("/lock")}


def make_files(folder, files):
    """The folder has these files and no others."""
    folder.mkdir(parents=True, exist_ok=True)
    for name in sorted(set(files_below(folder)) - set(files), reverse=True):
        path = folder / name
        path.rmdir() if path.is_dir() else path.unlink()
    for name, data in files.items():
        if data is None:
            (folder / name).mkdir(parents=True, exist_ok=True)
        else:
            (folder / name).parent.mkdir(parents=True, exist_ok=True)
            if not (folder / name).is_file() or (folder / name).read_bytes() != data:
                (folder / name).write_bytes(data)


class FtpBench(Bench):
    """A server of `ftp_servers`. server: which, with its options."""

    def __init__(self, folder, server):
        super().__init__(folder)
        self._server = server

    @contextlib.contextmanager
    def running(self):
        root = self.folder / "root"
        root.mkdir()
        with self._server(root) as server:
            self.home, self.real_port, self._user = server.home, server.port, server.user
            yield

    password = ftp_servers.PASSWORD

    def address(self):
        return f"ftp://{self._user}@127.0.0.1:{self.proxy.port}/HOME:"

    @contextlib.contextmanager
    def room_for(self, size):
        """Meanwhile its disk has so many bytes left."""
        if os.getuid() or os.name == "nt":
            pytest.skip("only root can make a small disk")
        files = files_below(self.home)
        done = subprocess.run(
            ["mount", "-t", "tmpfs", "-o", "size=96k", "tmpfs", str(self.home)],
            capture_output=True, check=False,
        )  # fmt: skip
        if done.returncode:
            pytest.skip("no small disk can be mounted")
        try:
            make_files(self.home, files)
            left = os.statvfs(self.home)
            filler = left.f_bavail * left.f_frsize - size
            (self.home / "filler.bin").write_bytes(bytes(max(0, filler)))
            yield
            self.proxy.calm()
            (self.home / "filler.bin").unlink()
            files = self.quiet()[0]
        finally:
            self.proxy.calm()
            subprocess.run(["umount", "-l", str(self.home)], check=True)
        make_files(self.home, files)


class SftpBench(FtpBench):
    password = PASSWORD

    def __init__(self, folder, **options):
        super().__init__(folder, None)
        self._options = options

    @contextlib.contextmanager
    def running(self):
        self.home = self.folder / "root"
        self.home.mkdir()
        with SftpServer(self.home, **self._options) as self.server:
            self.real_port = self.server.port
            yield

    def refused(self, steps):
        """Only the server can answer otherwise: what goes by is encrypted."""
        self.server.requests = 0
        assert self.deploy().ok
        self.restore(self.start)
        return [(step, b"failure") for step in range(self.server.requests)]

    @contextlib.contextmanager
    def refusing(self, step, answer):
        self.proxy.arm()
        self.server.requests, self.server.refuse = 0, step
        yield
        self.proxy.arm()
        self.server.refuse = None

    def address(self):
        pinned = f"fingerprint={self.server.fingerprint}"
        return f"sftp://user@127.0.0.1:{self.proxy.port}?{pinned}"


class Irc5Bench(Bench):
    scheme = "ftp"

    @contextlib.contextmanager
    def running(self):
        self.home = self.folder / "home"
        services = {} if self.scheme == "rws" else {"rws": None}
        with VirtualIrc5(self.home, rwss=None, **services) as self.controller:
            self.password = self.controller.password
            self.real_port = self.port_of(self.controller)
            yield

    def port_of(self, controller):
        return controller.port

    def address(self):
        return f"{self.scheme}://engineer@127.0.0.1:{self.proxy.port}"

    @contextlib.contextmanager
    def room_for(self, size):
        used = sum(len(data) for data in files_below(self.home).values() if data is not None)
        options = {"password": self.password, "quota": used + size, "rws": None, "rwss": None}
        with VirtualIrc5(self.home, **options) as small:
            self.proxy.serve(small.port)
            try:
                yield
            finally:
                self.proxy.calm()
                self.proxy.serve(self.real_port)


class RwsBench(Irc5Bench):
    scheme = "rws"
    refusals = tuple(
        b"HTTP/1.1 %s\r\nContent-Type: text/plain\r\nContent-Length: 2\r\n\r\nno" % status
        for status in (b"403 Forbidden", b"500 Internal Server Error", b"503 Service Unavailable")
    )
    room_for = None

    def port_of(self, controller):
        return controller.rws_port


class CrBench(Bench):
    names = ("A", "B", "C")
    refusals = (b"QeR4200\r", b"QeR4110\r", b"QeR4170\r")
    password = None

    def file(self, name):
        return f"{name.lower()}.prg"

    def source(self, name, value, rows):
        lines = "".join(f"{40 + n} ' A COMMENT THAT MAKES IT LONGER\r\n" for n in range(rows))
        head, _, tail = PROGRAM.format(value, value).partition("30 END\r\n")
        return f"{head}30 END\r\n{lines}{tail}".encode()

    @contextlib.contextmanager
    def running(self):
        with VirtualCr(folder=self.folder / "cr") as self.controller:
            self.real_port = self.controller.port
            yield

    def address(self):
        return f"melfa://127.0.0.1:{self.proxy.port}"

    def client(self):
        return connect(self.address(), timeout=5.0)

    def programs(self):
        return {name: self.controller.text(name).encode() for name in self.controller.names()}

    def state(self):
        return self.programs(), files_below(self.history)

    def restore(self, state):
        programs, history = state
        store = self.controller.state.store
        for name in set(self.controller.names()) - set(programs):
            store.delete(name)
        for name, text in programs.items():
            store.save(name, program_of(text.decode()))
        make_files(self.history, history)

    def rests(self):
        return []

    def record(self):
        return None

    def put_foreign(self):
        self.controller.state.store.save("OTHER", program_of(PROGRAM.format(7, 7)))

    @contextlib.contextmanager
    def room_for(self, size):
        store = self.controller.state.store
        before, store.capacity = store.capacity, store.used + size
        try:
            yield
        finally:
            store.capacity = before


BENCHES = {
    "irc5 ftp": Irc5Bench,
    "irc5 rws": RwsBench,
    "cr": CrBench,
    "proftpd": lambda folder: FtpBench(folder, ftp_servers.proftpd),
    "vsftpd": lambda folder: FtpBench(folder, ftp_servers.vsftpd),
    "never replaces": lambda folder: FtpBench(folder, ftp_servers.never_replacing),
    "sftp": SftpBench,
    "sftp, never replaces": lambda folder: SftpBench(folder, replaces=False),
}
