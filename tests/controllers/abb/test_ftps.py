"""FTP over TLS with real servers, which demand that transfers go on with the session of the login.

Servers that are not installed are skipped, and counted so.
"""

import pytest

from assistant.base.diagnostics import Refused
from assistant.controllers import connect
from tests.controllers.abb.ftp_servers import PASSWORD, own_certificate, proftpd, pyftpdlib, vsftpd

SERVERS = {"vsftpd": vsftpd, "proftpd": proftpd}
BIG = bytes(range(256)) * 1000


@pytest.fixture(params=SERVERS)
def server(request, tmp_path):
    root = tmp_path / "root"
    root.mkdir()
    with SERVERS[request.param](root, own_certificate(tmp_path)) as server:
        yield server


def codes(refused):
    return [finding.code for finding in refused.value.findings]


@pytest.mark.parametrize("options", ["", "?mode=active"])
def test_files_go_there_and_come_back(server, options):
    with server.client(options) as client:
        for data in (BIG, b"shorter", b""):
            client.write("a.bin", data)
            assert client.read("a.bin") == client.look("a.bin") == data
        assert client.names() == ("a.bin",)
        assert [entry.path for entry in client.tree()] == ["a.bin"]


def test_a_certificate_that_nobody_named_is_not_trusted(server, tmp_path):
    other = tmp_path / "other"
    other.mkdir()
    for certificate in (None, own_certificate(other)):
        address = f"ftps://{server.user}@127.0.0.1:{server.port}/HOME:"
        client = connect(address, password=PASSWORD, timeout=5, certificate=certificate)
        with pytest.raises(Refused) as refused, client:
            pass
        assert codes(refused) == ["CN208"]
        assert "assistant.toml" in refused.value.findings[0].cure


def test_a_server_without_tls_is_told_as_such(tmp_path):
    root = tmp_path / "root"
    root.mkdir()
    with pyftpdlib(root) as server:
        address = f"ftps://user@127.0.0.1:{server.port}/HOME:"
        for certificate in (None, own_certificate(tmp_path)):
            client = connect(address, password=PASSWORD, timeout=5, certificate=certificate)
            with pytest.raises(Refused) as refused, client:
                pass
            assert codes(refused) == ["CN214"] and refused.value.exit_status == 2
