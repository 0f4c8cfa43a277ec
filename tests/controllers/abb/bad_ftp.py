"""An FTP server over a dictionary that can be told to misbehave, with TLS if asked for."""

import contextlib
import socket
import ssl
import tempfile
import threading
from pathlib import Path

import trustme

from assistant.controllers import connect


class FtpPeer:
    """files: what it holds. die_after: bytes of an upload after which it is gone.

    alter: what it makes of an upload. replaces: whether RNTO takes an existing name.
    forbid: (source, target) → whether RNTO is refused. listing, login: whether it allows them.
    """

    def __init__(
        self, files, *, die_after=None, alter=None, replaces=True, forbid=None, listing=True,
        login=True, tls=False,
    ):  # fmt: skip
        self.files = dict(files)
        self.folders: set[str] = set()
        self.password = "correct horse"
        self.certificate = None
        self.encrypted = set()
        self._die_after, self._alter = die_after, alter or (lambda data: data)
        self._replaces, self._forbid = replaces, forbid or (lambda *_: False)
        self._listing, self._login = listing, login
        self._context = None
        self._tls = tls

    @property
    def names(self):
        return [*self.files, *sorted(self.folders)]

    def __enter__(self):
        if self._tls:
            self._make_certificate()
        self._listener = socket.create_server(("127.0.0.1", 0))
        self._open = []
        self._thread = threading.Thread(target=self._accept)
        self._thread.start()
        return self

    def __exit__(self, *error):
        with contextlib.suppress(OSError):
            self._listener.shutdown(socket.SHUT_RDWR)
        self._listener.close()
        for connection in self._open:
            with contextlib.suppress(OSError):
                connection.shutdown(socket.SHUT_RDWR)
        self._thread.join()
        if self._tls:
            self._folder.cleanup()

    def _make_certificate(self):
        """A certificate for 127.0.0.1 of an authority that exists for this test only."""
        authority = trustme.CA()
        self._context = ssl.SSLContext(ssl.PROTOCOL_TLS_SERVER)
        authority.issue_cert("127.0.0.1").configure_cert(self._context)
        self._folder = tempfile.TemporaryDirectory()
        self.certificate = Path(self._folder.name) / "authority.pem"
        authority.cert_pem.write_to_path(self.certificate)

    def connect(self, **options):
        scheme = "ftps" if self._tls else "ftp"
        port = self._listener.getsockname()[1]
        address = f"{scheme}://user@127.0.0.1:{port}"
        return connect(address, password=self.password, timeout=10, **options)

    def _accept(self):
        with contextlib.suppress(OSError):
            while True:
                connection, _ = self._listener.accept()
                self._open.append(connection)
                with contextlib.suppress(OSError, ssl.SSLError), connection:
                    _Conversation(self, connection).run()


class _Conversation:
    def __init__(self, peer, connection):
        self.peer, self.connection = peer, connection
        self.private, self.source, self.data = False, None, None

    def run(self):
        try:
            self.talk()
        finally:
            self.connection.close()

    def talk(self):
        self.say("220 ready")
        while line := self.line():
            name, _, argument = line.partition(" ")
            act = getattr(self, f"do_{name.lower()}", None)
            if name == "QUIT":
                return self.say("221 bye")
            if act is None:
                self.say("502 not known")
            elif act(argument) == "dead":
                return None
        return None

    def say(self, text):
        self.connection.sendall(f"{text}\r\n".encode())

    def line(self):
        data = b""
        while not data.endswith(b"\n"):
            byte = self.connection.recv(1)
            if not byte:
                return ""
            data += byte
        return data.decode().strip()

    def do_auth(self, argument):
        if self.peer._context is None:
            return self.say("502 no TLS")
        self.say("234 go on")
        self.connection = self.peer._context.wrap_socket(self.connection, server_side=True)
        return None

    def do_user(self, argument):
        self.say("331 password")

    def do_pass(self, argument):
        right = self.peer._login and argument == self.peer.password
        self.say("230 in" if right else f"530 PASS {argument} is wrong")

    def do_pbsz(self, argument):
        self.say("200 ok")

    def do_prot(self, argument):
        self.private = argument == "P"
        self.say("200 ok")

    def do_cwd(self, argument):
        self.say("250 ok" if argument == "HOME:" else "550 no such folder")

    def do_type(self, argument):
        self.say("200 ok")

    def do_pasv(self, argument):
        self.data = socket.create_server(("127.0.0.1", 0))
        port = self.data.getsockname()[1]
        self.say(f"227 (127,0,0,1,{port // 256},{port % 256})")

    def do_epsv(self, argument):
        self.say("502 no")

    @contextlib.contextmanager
    def channel(self):
        self.say("150 go")
        with self.data:
            channel, _ = self.data.accept()
        if self.private:
            channel = self.peer._context.wrap_socket(channel, server_side=True)
        self.peer.encrypted.add(isinstance(channel, ssl.SSLSocket))
        with channel:
            yield channel
            if isinstance(channel, ssl.SSLSocket):
                with contextlib.suppress(OSError):
                    channel.unwrap()

    def do_nlst(self, argument):
        if not self.peer._listing:
            self.data.close()
            return self.say("550 permission denied")
        with self.channel() as channel:
            channel.sendall(
                "".join(f"{name}\r\n" for name in self.peer.names).encode(
                    "utf-8", "surrogateescape"
                )
            )
        return self.say("226 done")

    def do_retr(self, argument):
        if argument not in self.peer.files:
            self.data.close()
            return self.say("550 not found")
        with self.channel() as channel:
            channel.sendall(self.peer.files[argument])
        return self.say("226 done")

    def do_stor(self, argument):
        data = b""
        with self.channel() as channel:
            limit = self.peer._die_after
            while limit is None or len(data) < limit:
                piece = channel.recv(4096 if limit is None else limit - len(data))
                if not piece:
                    break
                data += piece
        self.peer.files[argument] = self.peer._alter(data)
        if self.peer._die_after is not None:
            self.connection.close()
            return "dead"
        return self.say("226 done")

    def do_rnfr(self, argument):
        self.source = argument
        self.say("350 to" if argument in self.peer.files else "550 not found")

    def do_rnto(self, argument):
        taken = argument in self.peer.files and not self.peer._replaces
        if taken or self.peer._forbid(self.source, argument):
            return self.say("550 file exists")
        self.peer.files[argument] = self.peer.files.pop(self.source)
        return self.say("250 ok")

    def do_dele(self, argument):
        gone = self.peer.files.pop(argument, None) is not None
        self.say("250 ok" if gone else "550 not found")

    def do_mkd(self, argument):
        taken = argument in self.peer.folders
        self.peer.folders.add(argument)
        self.say("550 file exists" if taken else f'257 "{argument}" made')

    def do_rmd(self, argument):
        self.peer.folders.discard(argument)
        self.say("250 ok")
