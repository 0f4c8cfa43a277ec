"""Attacks on deployments: where a password might stay, and whom it might be given to."""

import base64
import io
import json
import logging
import os
import shutil
import socket
import stat
import sys
import zipfile
from contextlib import contextmanager
from pathlib import Path
from urllib.parse import quote, quote_plus
from xml.sax.saxutils import escape

import pytest
import trustme

from assistant import deploy as deploying
from assistant.base.diagnostics import Refused
from assistant.cli import main
from assistant.cli.rollout import junit_report
from assistant.controllers import connect
from assistant.deploy import EVERY, Cell, deploy_to_all
from assistant.virtual.irc5 import VirtualIrc5
from tests.controllers.abb.bad_ftp import FtpPeer
from tests.controllers.abb.sftp_server import PASSWORD, SftpServer

SECRET = "zQ9/+x%&<s3cret"
MODULE = "MODULE SEAM\r\n  PROC seam_main()\r\n    WaitTime {};\r\n  ENDPROC\r\nENDMODULE\r\n"
OLD, NEW = MODULE.format(1).encode(), MODULE.format(2).encode()


def spellings(secret, user="engineer"):
    """A password as it is, and as it looks on its way."""
    both = f"{user}:{secret}".encode()
    forms = {secret, quote(secret), quote(secret, safe=""), quote_plus(secret), escape(secret)}
    forms |= {json.dumps(secret)[1:-1], repr(secret)[1:-1]}
    coded = [base64.b64encode(data).rstrip(b"=") for data in (both, secret.encode())]
    return {form.encode() for form in forms} | {*coded, secret[::-1].encode()}


def contents(folder):
    """Every file below a folder, and what is in those that are archives, with their names."""
    for file in sorted(folder.rglob("*")):
        if file.is_file():
            data = file.read_bytes()
            yield str(file), data
            if zipfile.is_zipfile(io.BytesIO(data)):
                with zipfile.ZipFile(io.BytesIO(data)) as archive:
                    yield from ((info.filename, archive.read(info)) for info in archive.infolist())


def assert_nowhere(secret, folders=(), *texts):
    looked = [pair for folder in folders for pair in contents(folder)]
    looked += [("said", text.encode("utf-8", "surrogateescape")) for text in texts]
    for form in spellings(secret):
        assert not [name for name, data in looked if form in data or form in os.fsencode(name)]


@contextmanager
def irc5(folder, scheme):
    kinds = {"rws": None, "rwss": None, scheme: 0}
    ports = {kind: kinds[kind] for kind in ("rws", "rwss")}
    with VirtualIrc5(folder, password=SECRET, **ports) as there:
        address = {"ftp": "address", "rws": "rws_address", "rwss": "rwss_address"}[scheme]
        yield getattr(there, address), SECRET, there.certificate if scheme == "rwss" else None


@contextmanager
def sftp(folder, scheme):
    with SftpServer(folder) as there:
        yield f"sftp://user@127.0.0.1:{there.port}", PASSWORD, there.known_hosts


@contextmanager
def ftps(folder, scheme):
    with FtpPeer({"seam.mod": OLD}, tls=True) as there:
        there.password = SECRET
        yield str(there.connect().address), SECRET, there.certificate


SERVERS = {"ftp": irc5, "rws": irc5, "rwss": irc5, "sftp": sftp, "ftps": ftps}


@pytest.fixture
def project(tmp_path, monkeypatch):
    """The working folder, with a program in it."""
    folder = tmp_path / "project"
    folder.mkdir()
    (folder / "seam.mod").write_bytes(NEW)
    monkeypatch.chdir(folder)
    return folder


SLOW = pytest.param("ftps", marks=pytest.mark.slow)  # a handshake for each file


@pytest.fixture(params=["ftp", "rws", "rwss", "sftp", SLOW])
def cell(request, project, monkeypatch):
    """A controller `cell1` with an old program; its folder and its password."""
    home = project.parent / "home"
    home.mkdir()
    (home / "seam.mod").write_bytes(OLD)
    with SERVERS[request.param](home, request.param) as (address, secret, trusted):
        lines = ["[controllers.cell1]", f'address = "{address}"', "timeout = 10"]
        if isinstance(trusted, str):
            (project / "known_hosts").write_text(trusted)
            trusted = project / "known_hosts"
        if trusted is not None:
            lines.append(f'certificate = "{trusted}"')
        (project / "assistant.toml").write_text("\n".join(lines) + "\n")
        monkeypatch.setenv("ROBOT_ASSISTANT_CELL1_PASSWORD", secret)
        yield home, secret


def run(*arguments):
    with pytest.raises(SystemExit) as ended:
        main([str(argument) for argument in arguments])
    return ended.value.code


def test_no_password_stays_anywhere(cell, project, capsys, caplog):
    """Not in the project, the history, on the controller's disk, in the answers, in any log."""
    home, secret = cell
    caplog.set_level(logging.DEBUG)
    deploy = ("deploy", "seam.mod", "--to", "cell1", "--files-only")
    assert run(*deploy) == 1, "nobody knows the old program: a conflict"
    assert run(*deploy, "--replace", "*", "--format", "json") == 0
    told = capsys.readouterr()
    assert '"installed"' in told.out and "DP222" in told.err
    names = {Path(name).name for name, _ in contents(project)}
    assert {"record.json", "programs.json", "journal.jsonl", "1-seam.mod"} <= names
    assert_nowhere(secret, [project, home], told.out, told.err, caplog.text)


def test_a_wrong_password_is_not_repeated(cell, project, monkeypatch, capsys, caplog):
    caplog.set_level(logging.DEBUG)
    home, right = cell
    wrong = SECRET + "wr0ng"
    monkeypatch.setenv("ROBOT_ASSISTANT_CELL1_PASSWORD", wrong)
    assert run("deploy", "seam.mod", "--to", "cell1", "--format", "json") == 2
    told = capsys.readouterr()
    assert "CN202" in told.out
    for secret in (wrong, right):
        assert_nowhere(secret, [project, home], told.out, told.err, caplog.text)


def test_a_server_that_repeats_what_it_was_sent(project):
    """In the text of its refusals, of login and of a transfer, in all that is made of them."""
    with FtpPeer({}, login=False) as peer:
        peer.password = SECRET
        client = peer.connect()
        cells = [Cell("cell1", client.address, lambda: deploying.plan(["seam.mod"], client))]
        rollout = deploy_to_all(cells)
        assert not rollout.ok
        said = "".join(f.message + f.cure + f.where() for f in rollout.outcomes[0].findings)
        assert "***" in said
        assert_nowhere(
            SECRET, [project], said, repr(rollout), junit_report(rollout).decode(), repr(client)
        )


def test_an_address_with_a_password_is_refused_without_it(project, capsys):
    address = f"ftp://engineer:{SECRET}@127.0.0.1:1"
    assert run("deploy", "seam.mod", "--to", address) != 0
    (project / "assistant.toml").write_text(f'[controllers]\ncell1 = "{address}"\n')
    assert run("deploy", "seam.mod", "--to", "cell1") == 2
    told = capsys.readouterr()
    (project / "assistant.toml").unlink()
    assert "CN1" in told.err
    assert_nowhere(SECRET, [project], told.out, told.err)


def test_child_processes_do_not_get_the_password(project, tmp_path, monkeypatch):
    """A `git` that stands first in the path tells what it was given, then does its work."""
    real = shutil.which("git")
    assert real is not None
    tools = tmp_path / "tools"
    tools.mkdir()
    seen = tmp_path / "seen"
    git = tools / "git"
    code = f"""#!{sys.executable}
import os, sys
with open({str(seen)!r}, "a") as file:
    file.write(repr((sys.argv, dict(os.environ))) + "\\n")
os.execv({real!r}, sys.argv)
"""
    git.write_text(code)
    git.chmod(git.stat().st_mode | stat.S_IXUSR)
    monkeypatch.setenv("PATH", f"{tools}{os.pathsep}{os.environ['PATH']}")
    for name in ("PASSWORD", "CELL1_PASSWORD"):
        monkeypatch.setenv(f"ROBOT_ASSISTANT_{name}", SECRET)
    with VirtualIrc5(tmp_path / "home", password=SECRET, rws=None, rwss=None) as there:
        planned = deploying.plan(["seam.mod"], connect(there.address))
        assert deploying.deploy(planned, files_only=True).ok
    assert "describe" in seen.read_text() and "PATH" in seen.read_text()
    assert_nowhere(SECRET, [project], seen.read_text())


def test_no_command_of_the_repository_is_run(project, tmp_path):
    """Whose commit is asked for: a repository may name programs that git would start."""
    ran = tmp_path / "ran"
    hook = tmp_path / "hook"
    hook.write_text(f"#!/bin/sh\ntouch '{ran}'\n")
    hook.chmod(0o755)
    git = shutil.which("git")
    config = ["-c", "user.name=a", "-c", "user.email=a@b.c"]
    for words in (["init", "-q"], ["add", "."], ["commit", "-qm", "one"]):
        os.spawnv(os.P_WAIT, git, ["git", *config, *words])
    os.spawnv(os.P_WAIT, git, ["git", "config", "core.fsmonitor", str(hook)])
    assert os.spawnv(os.P_WAIT, git, ["git", "update-index", "--refresh"]) == 0
    assert ran.exists(), "git does start it"
    ran.unlink()
    (project / "seam.mod").write_bytes(OLD)
    assert deploying.record.commit_of(project).endswith("-dirty") and not ran.exists()


# --------------------------------------------------------------------- whom a program is given to


def refused_before_anything(client, project):
    """A deployment to it, and to it among others: nothing is sent, and the finding says why."""
    with pytest.raises(Refused) as refused:
        deploying.plan(["seam.mod"], client, replace=[EVERY])
    assert {f.code for f in refused.value.findings} <= {"CN208", "CN211"}
    cells = [Cell("a", client.address, lambda: deploying.plan(["seam.mod"], client))]
    assert [one.deployment for one in deploy_to_all(cells).outcomes] == [None]
    assert not (project / ".robot-assistant").exists()


class Listening:
    """A server of TLS with a certificate of nobody known; `heard` is what came after greeting."""

    def __init__(self, certificate, greeting=b""):
        import ssl
        import threading

        self.context = ssl.SSLContext(ssl.PROTOCOL_TLS_SERVER)
        certificate.configure_cert(self.context)
        self.heard, self.greeting = [], greeting
        self.socket = socket.create_server(("127.0.0.1", 0))
        self.port = self.socket.getsockname()[1]
        self.thread = threading.Thread(target=self._serve)

    def __enter__(self):
        self.thread.start()
        return self

    def __exit__(self, *error):
        self.socket.shutdown(socket.SHUT_RDWR)
        self.socket.close()
        self.thread.join()

    def _serve(self):
        while True:
            try:
                connection, _ = self.socket.accept()
            except OSError:
                return
            with connection:
                connection.settimeout(5)
                try:
                    if self.greeting:
                        connection.sendall(self.greeting)
                        self.heard.append(connection.recv(1000))
                        connection.sendall(b"234 go on\r\n")
                    with self.context.wrap_socket(connection, server_side=True) as inside:
                        self.heard.append(inside.recv(1000))
                except OSError:
                    continue


@pytest.mark.parametrize("scheme", ["ftps", "rwss"])
@pytest.mark.parametrize("trusted", ["nothing", "another authority", "another name"])
def test_a_wrong_certificate_is_refused_before_anything_is_sent(
    scheme, trusted, project, tmp_path, monkeypatch
):
    authority = trustme.CA()
    known = authority if trusted == "another name" else trustme.CA()
    known.cert_pem.write_to_path(tmp_path / "known.pem")
    certificate = None if trusted == "nothing" else tmp_path / "known.pem"
    greeting = b"220 ready\r\n" if scheme == "ftps" else b""
    leaf = authority.issue_cert("robot.example" if trusted == "another name" else "127.0.0.1")
    with Listening(leaf, greeting) as server:
        client = connect(
            f"{scheme}://engineer@127.0.0.1:{server.port}",
            password=SECRET,
            certificate=certificate,
            timeout=5,
        )
        refused_before_anything(client, project)
    heard = b"".join(server.heard)
    assert heard.replace(b"AUTH TLS\r\n", b"") == b"", "neither name nor password nor program"


def test_a_wrong_host_key_is_refused_before_anything_is_sent(project, tmp_path, monkeypatch):
    monkeypatch.setenv("HOME", str(tmp_path))
    home = tmp_path / "home"
    home.mkdir()
    with SftpServer(home) as server:
        for options in ("", "?fingerprint=SHA256:" + "A" * 43):
            client = server.client(options=options)
            refused_before_anything(client, project)
        assert server.logins == 0 and list(home.iterdir()) == []


def test_no_password_goes_out_in_the_clear_where_tls_was_asked_for(project):
    """A server that says it knows no TLS, as somebody in between would have it say."""
    with FtpPeer({}) as peer:
        address = str(peer.connect().address).replace("ftp://", "ftps://")
        client = connect(address, password=peer.password, timeout=5)
        with pytest.raises(Refused) as refused:
            deploying.plan(["seam.mod"], client)
        assert peer.files == {} and peer.password not in str(refused.value)


def test_nobody_else_can_write_into_the_history(project, tmp_path):
    with VirtualIrc5(tmp_path / "home", password=SECRET, rws=None, rwss=None) as there:
        client = connect(there.address, password=SECRET)
        planned = deploying.plan(["seam.mod"], client)
        done = deploying.deploy(planned, files_only=True)
    assert done.ok and done.folder is not None
    assert stat.S_IMODE(done.folder.stat().st_mode) & 0o022 == 0, "nobody else writes there"
    assert Path(done.folder).resolve().is_relative_to(project)
