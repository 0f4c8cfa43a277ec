"""A file whose name is no UTF-8, in a folder of programs, stops no command.

Real servers that are not installed are skipped; the simple one of the tests is always there.
"""

import contextlib
import json
import os
import socket
import threading
from pathlib import Path

import pytest

from assistant.base.diagnostics import Refused
from assistant.cli import main
from assistant.controllers import connect
from tests.controllers.abb.bad_ftp import FtpPeer
from tests.controllers.abb.ftp_servers import PASSWORD, proftpd, vsftpd

MODULE = "MODULE SEAM\r\n  PROC seam_main()\r\n    WaitTime {};\r\n  ENDPROC\r\nENDMODULE\r\n"
OTHER = b"M\xe4rz.mod"


@contextlib.contextmanager
def peer(root):
    with FtpPeer({os.fsdecode(OTHER): b"other"}) as there:
        there.password = PASSWORD
        yield str(there.connect().address)


def real(server):
    @contextlib.contextmanager
    def started(root):
        with server(root) as there:
            Path(os.fsdecode(os.fsencode(there.home) + b"/" + OTHER)).write_bytes(b"other")
            yield f"ftp://{there.user}@127.0.0.1:{there.port}/HOME:"

    return started


SERVERS = {"simple": peer, "vsftpd": real(vsftpd), "proftpd": real(proftpd)}
SLOW = pytest.mark.slow  # a dozen commands each


@pytest.mark.parametrize(
    "server", ["simple", *(pytest.param(name, marks=SLOW) for name in ("vsftpd", "proftpd"))]
)
def test_no_command_minds_the_name_of_another_file(server, tmp_path, monkeypatch, capsys):
    root, here = tmp_path / "root", tmp_path / "here"
    root.mkdir()
    here.mkdir()
    monkeypatch.chdir(here)
    monkeypatch.setenv("ROBOT_ASSISTANT_PASSWORD", PASSWORD)
    module = here / "seam.mod"
    module.write_text(MODULE.format(1), newline="")

    def done(*arguments):
        with pytest.raises(SystemExit) as ended:
            main(list(arguments))
        out, err = capsys.readouterr()
        assert ended.value.code == 0, err + out
        return json.loads(out)

    with SERVERS[server](root) as address:
        to, answer = ("--to", address), ("--format", "json")
        done("plan", "seam.mod", *to, *answer)
        done("deploy", "seam.mod", *to, *answer)
        assert "März.mod" in done("ls", address, *answer)["programs"]
        module.write_text(MODULE.format(2), newline="")
        foreign = done("deploy", "seam.mod", *to, "--files-only", *answer)["foreign"]
        assert foreign == ["März.mod"]
        done("verify", *to, *answer)
        done("get", address, "seam.mod", "-o", "copy.mod", *answer)
        assert (here / "copy.mod").read_bytes() == module.read_bytes()
        done("put", address, "copy.mod", *answer)
        done("deployments", *to, *answer)
        done("rollback", *to, *answer)
        done("get", address, "seam.mod", "-o", "copy.mod", "--replace", *answer)
        assert (here / "copy.mod").read_bytes() == MODULE.format(1).encode()


@contextlib.contextmanager
def answering(*replies):
    """A server that has these bytes for an answer each, whatever is asked."""
    with socket.create_server(("127.0.0.1", 0)) as listener:

        def talk():
            connection, _ = listener.accept()
            with connection, contextlib.suppress(OSError):
                for reply in replies:
                    connection.sendall(reply + b"\r\n")
                    connection.recv(1000)

        thread = threading.Thread(target=talk)
        thread.start()
        yield listener.getsockname()[1]
        thread.join()


@pytest.mark.parametrize("spelled", ["latin-1", "utf-8"])
def test_a_login_that_is_refused_in_another_language_is_told_as_it_is(spelled):
    refusal = "530 Kennwort ungültig".encode(spelled)
    with (
        answering("220 Grüße".encode(spelled), b"331 go on", refusal) as port,
        pytest.raises(Refused) as refused,
        connect(f"ftp://anna@127.0.0.1:{port}", password="x", timeout=5),
    ):
        pass
    (finding,) = refused.value.findings
    assert finding.code == "CN202" and "Kennwort ungültig" in finding.message
