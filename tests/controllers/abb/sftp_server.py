"""A real SSH server with SFTP over a folder, by asyncssh, in a thread of its own."""

import asyncio
import io
import logging
import threading

import asyncssh

from assistant.controllers import connect

PASSWORD = "correct horse"
KEY = asyncssh.generate_private_key("ssh-ed25519")


class SftpServer:
    """A context manager. replaces: whether a rename takes the name of a file that is there.

    drip: seconds from byte to byte of a file, which never ends then. also: names in listings.
    requests: how many came that change or open something; refuse: the one (from 0) that fails.
    """

    def __init__(self, root, *, replaces=True, drip=None, also=()):
        self.root, self.key = root, KEY
        self.requests, self.refuse = 0, None
        self._replaces, self._drip, self._also = replaces, drip, also
        self._ready = threading.Event()
        self._thread = threading.Thread(target=self._serve, daemon=True)
        self.logins = 0

    @property
    def fingerprint(self):
        return self.key.get_fingerprint()

    @property
    def known_hosts(self):
        """A line of a file of known hosts."""
        return f"[127.0.0.1]:{self.port} {self.key.export_public_key().decode()}"

    def client(self, *, port=None, timeout=5.0, options=None, password=PASSWORD, **more):
        pinned = f"?fingerprint={self.fingerprint}" if options is None else options
        address = f"sftp://user@127.0.0.1:{port or self.port}{pinned}"
        return connect(address, password=password, timeout=timeout, **more)

    def __enter__(self):
        logging.getLogger("asyncssh").setLevel(logging.CRITICAL)
        self._thread.start()
        assert self._ready.wait(10)
        return self

    def __exit__(self, *error):
        self._loop.call_soon_threadsafe(self._stop.set)
        self._thread.join(10)
        assert not self._thread.is_alive()

    def _serve(self):
        asyncio.run(self._listen())

    async def _listen(self):
        server, replaces, connections = self, self._replaces, []
        drip, also = self._drip, self._also
        self._loop = asyncio.get_running_loop()

        class Login(asyncssh.SSHServer):
            def connection_made(self, conn):
                connections.append(conn)

            def begin_auth(self, username):
                return True

            def password_auth_supported(self):
                return True

            def validate_password(self, username, password):
                server.logins += 1
                return (username, password) == ("user", PASSWORD)

        class Files(asyncssh.SFTPServer):
            def __init__(self, channel):
                super().__init__(channel, chroot=str(server.root).encode())

            def asked(self):
                number, server.requests = server.requests, server.requests + 1
                if number == server.refuse:
                    raise asyncssh.SFTPFailure("no room")

            def write(self, file_obj, offset, data):
                self.asked()
                return super().write(file_obj, offset, data)

            def remove(self, path):
                self.asked()
                return super().remove(path)

            def rename(self, old, new):
                self.asked()
                return super().rename(old, new)

            def mkdir(self, path, attrs):
                self.asked()
                return super().mkdir(path, attrs)

            def rmdir(self, path):
                self.asked()
                return super().rmdir(path)

            def open(self, path, pflags, attrs):
                self.asked()
                return super().open(path, pflags, attrs) if drip is None else io.BytesIO()

            async def read(self, file_obj, offset, size):
                if drip is None:
                    return super().read(file_obj, offset, size)
                await asyncio.sleep(drip)
                return b"x"

            async def scandir(self, path):
                async for entry in super().scandir(path):
                    yield entry
                for name in also:
                    yield asyncssh.SFTPName(name, attrs=asyncssh.SFTPAttrs(permissions=0o100644))

            def posix_rename(self, old, new):
                self.asked()
                if not replaces:
                    raise asyncssh.SFTPOpUnsupported("no such extension")
                return super().posix_rename(old, new)

        self._stop = asyncio.Event()
        listener = await asyncssh.listen(
            "127.0.0.1", 0, server_factory=Login, sftp_factory=Files, server_host_keys=[KEY]
        )
        self.port = listener.get_port()
        self._ready.set()
        await self._stop.wait()
        listener.close()
        for connection in connections:
            connection.abort()
            await connection.wait_closed()
