"""Real FTP servers on this computer, each over a folder `HOME:` in a folder of its own."""

import contextlib
import errno
import getpass
import grp
import hashlib
import os
import shutil
import socket
import subprocess
import threading
import time
from pathlib import Path

import pytest

from assistant.controllers import connect

PASSWORD = "correct horse"
PATHS = os.pathsep.join((os.environ.get("PATH", ""), "/usr/sbin", "/usr/local/sbin"))

MODULES = [
    *(Path(place).parent / "lib" / "proftpd" for place in PATHS.split(os.pathsep)),
    *(Path("/usr/lib/proftpd"), Path("/usr/libexec/proftpd")),
]
"""Where modules of proftpd are: beside its program, or in the system's place."""


class Server:
    """root: what it serves. commands: those that it got, where it is one that tells."""

    def __init__(self, root, port, user, commands=None, certificate=None):
        self.root, self.port, self.user, self.commands = root, port, user, commands
        self.certificate = certificate
        self.home = root / "HOME:"
        self.home.mkdir(exist_ok=True)

    def client(self, options="", port=None, timeout=10.0):
        scheme = "ftps" if self.certificate else "ftp"
        address = f"{scheme}://{self.user}@127.0.0.1:{port or self.port}/HOME:{options}"
        return connect(address, password=PASSWORD, timeout=timeout, certificate=self.certificate)


@contextlib.contextmanager
def pyftpdlib(root, *, without=(), replaces=True):
    """A server in a thread. without: commands that it does not know. replaces: whether a rename
    takes the name of a file that is there.
    """
    from pyftpdlib.authorizers import DummyAuthorizer
    from pyftpdlib.filesystems import AbstractedFS
    from pyftpdlib.handlers import FTPHandler
    from pyftpdlib.ioloop import IOLoop
    from pyftpdlib.servers import FTPServer

    authorizer, commands = DummyAuthorizer(), []
    authorizer.add_user("user", PASSWORD, str(root), perm="elradfmw")

    class Session(FTPHandler):
        use_sendfile = False

        def log_cmd(self, cmd, arg, code, text):
            commands.append(cmd)

    class Files(AbstractedFS):
        def chdir(self, path):
            """The folder of this process, which has other threads, stays."""
            with os.scandir(path):
                self.cwd = self.fs2ftp(path)

        def rename(self, src, dst):
            if not replaces and os.path.lexists(dst):
                raise FileExistsError(errno.EEXIST, "there is one")
            super().rename(src, dst)

    Session.authorizer, Session.abstracted_fs = authorizer, Files
    Session.proto_cmds = {k: v for k, v in FTPHandler.proto_cmds.items() if k not in without}
    server = FTPServer(("127.0.0.1", 0), Session, ioloop=IOLoop())
    stopping = threading.Event()

    def serve():
        while not stopping.is_set():
            server.ioloop.loop(timeout=0.02, blocking=False)
        server.close_all()

    thread = threading.Thread(target=serve, daemon=True)
    thread.start()
    try:
        yield Server(root, server.address[1], "user", commands)
    finally:
        stopping.set()
        thread.join(10)


def never_replacing(root):
    return pyftpdlib(root, replaces=False)


@contextlib.contextmanager
def vsftpd(root, certificate=None):
    """certificate: file with it and its key, for TLS; transfers have to go on with its session."""
    config, empty = root.parent / "vsftpd.conf", root.parent / "empty"
    empty.mkdir()
    port = free_port()
    settings = {
        "listen": "YES", "listen_address": "127.0.0.1", "listen_port": port, "background": "NO",
        "anonymous_enable": "YES", "anon_root": root, "anon_upload_enable": "YES",
        "anon_mkdir_write_enable": "YES", "anon_other_write_enable": "YES", "anon_umask": "022",
        "write_enable": "YES", "no_anon_password": "YES", "secure_chroot_dir": empty,
        "ftp_username": getpass.getuser(), "run_as_launching_user": "YES",
        "seccomp_sandbox": "NO", "allow_writeable_chroot": "YES", "anon_world_readable_only": "NO",
        "xferlog_enable": "NO", "isolate": "NO", "isolate_network": "NO",
    }  # fmt: skip
    if certificate is not None:
        settings |= {
            "ssl_enable": "YES", "allow_anon_ssl": "YES", "require_ssl_reuse": "YES",
            "rsa_cert_file": certificate, "rsa_private_key_file": certificate,
            "force_anon_logins_ssl": "YES", "force_anon_data_ssl": "YES", "ssl_tlsv1": "YES",
        }  # fmt: skip
    config.write_text("".join(f"{name}={value}\n" for name, value in settings.items()))
    with running([program("vsftpd"), str(config)], port):
        yield Server(root, port, "anonymous", certificate=certificate)


@contextlib.contextmanager
def proftpd(root, certificate=None, begins=""):
    """begins: folder below the root in which a session begins."""
    config, users = root.parent / "proftpd.conf", root.parent / "users"
    port, name = free_port(), getpass.getuser()
    hashed = crypted(PASSWORD)
    users.write_text(f"user:{hashed}:{os.getuid()}:{os.getgid()}::{root / begins}:/bin/sh\n")
    users.chmod(0o600)
    root.parent.chmod(0o755)
    config.write_text(
        f"ServerType standalone\nDefaultAddress 127.0.0.1\nPort {port}\nUseIPv6 off\n"
        f"User {name}\nGroup {grp.getgrgid(os.getgid()).gr_name}\n"
        f"AuthUserFile {users}\nAuthOrder mod_auth_file.c\n"
        f"RequireValidShell off\nRootLogin on\nDefaultRoot {root}\nAllowOverwrite on\n"
        f"AllowStoreRestart on\nScoreboardFile {root.parent}/scores\nPidFile {root.parent}/pid\n"
        f"WtmpLog off\nTransferLog none\nSystemLog {root.parent}/log\nUseReverseDNS off\n"
        "<IfModule mod_delay.c>\nDelayEngine off\n</IfModule>\n"
        "<IfModule mod_ident.c>\nIdentLookups off\n</IfModule>\n"
    )
    if certificate is not None:
        module = find_file("mod_tls.so", MODULES)
        tls = (
            f"ModulePath {module.parent}\nLoadModule mod_tls.c\nTLSEngine on\nTLSRequired on\n"
            f"TLSRSACertificateFile {certificate}\nTLSRSACertificateKeyFile {certificate}\n"
        )
        config.write_text(tls + config.read_text())
    with running([program("proftpd"), "-n", "-q", "-c", str(config)], port):
        yield Server(root, port, "user", certificate=certificate)


@contextlib.contextmanager
def pure_ftpd(root):
    if os.getuid():
        pytest.skip("pure-ftpd needs root")
    users, port = root.parent / "users", free_port()
    line = f"user:{crypted(PASSWORD)}:65534:65534::{root}/./::::::::::::\n"
    users.write_text(line)
    database = root.parent / "users.pdb"
    subprocess.run(
        [program("pure-pw"), "mkdb", str(database), "-f", str(users)], check=True, timeout=10
    )
    os.chown(root, 65534, 65534)
    for folder in (root.parent, *root.parent.parents[:3]):
        folder.chmod(0o755)
    command = [program("pure-ftpd"), "-S", f"127.0.0.1,{port}", "-l", f"puredb:{database}", "-H"]
    with running([*command, "-u", "1", "-A"], port):
        server = Server(root, port, "user")
        os.chown(server.home, 65534, 65534)
        yield server


SERVERS = {
    "pyftpdlib": pyftpdlib, "vsftpd": vsftpd, "proftpd": proftpd, "pure-ftpd": pure_ftpd,
}  # fmt: skip


def own_certificate(folder, host="127.0.0.1"):
    """A file with a key and the certificate that a controller made of it for itself."""
    key, made = folder / "key.pem", folder / "own.pem"
    command = ["req", "-x509", "-newkey", "ec", "-pkeyopt", "ec_paramgen_curve:prime256v1"]
    names = ["-subj", "/CN=a robot", "-addext", f"subjectAltName=DNS:{host}"]
    files = ["-nodes", "-days", "2", "-keyout", str(key), "-out", str(made)]
    subprocess.run(
        [program("openssl"), *command, *names, *files], check=True, capture_output=True, timeout=10
    )
    made.write_bytes(key.read_bytes() + made.read_bytes())
    made.chmod(0o600)
    return made


def find_file(name, folders):
    """A file of a server's package, skipped where the package is not there."""
    for folder in folders:
        if (Path(folder) / name).is_file():
            return Path(folder) / name
    pytest.skip(f"{name} is not installed")


def program(name):
    found = shutil.which(name, path=PATHS)
    if found is None:
        pytest.skip(f"{name} is not installed")
    return found


def crypted(password):
    openssl = program("openssl")
    salt = hashlib.sha256(password.encode()).hexdigest()[:8]
    done = subprocess.run(
        [openssl, "passwd", "-6", "-salt", salt, password], capture_output=True, check=True
    )
    return done.stdout.decode().strip()


def free_port():
    with socket.create_server(("127.0.0.1", 0)) as listener:
        return listener.getsockname()[1]


@contextlib.contextmanager
def running(command, port):
    """A server as a process of its own, until its port is open."""
    process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
    try:
        for _ in range(200):
            if process.poll() is not None:
                raise AssertionError(process.stdout.read().decode())
            with contextlib.suppress(OSError), socket.create_connection(("127.0.0.1", port), 1):
                break
            time.sleep(0.02)
        yield
    finally:
        process.terminate()
        process.communicate(timeout=10)
