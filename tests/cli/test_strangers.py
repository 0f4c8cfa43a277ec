"""Programs and folders of strangers reach nothing by being looked at."""

from __future__ import annotations

import socket

import pytest

from tests.cli.test_commands import run

CALLER = """\
MODULE caller
  VAR socketdev line;
  PROC main()
    SocketCreate line;
    SocketConnect line, "127.0.0.1", {port}\\Time:=1;
    SocketSend line\\Str:="hello";
    SocketClose line;
  ENDPROC
ENDMODULE
"""


def test_a_proof_reaches_no_server_of_this_computer(capsys, here):
    with socket.create_server(("127.0.0.1", 0)) as server:
        server.setblocking(False)
        (here / "caller.mod").write_text(CALLER.format(port=server.getsockname()[1]))
        status, out, said = run(
            capsys, "compile", "caller.mod", "--language", "rapid", "--prove", "-o", "out"
        )
        with pytest.raises(BlockingIOError):
            server.accept()
    assert status == 0, out + said
