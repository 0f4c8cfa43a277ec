"""A virtual IRC5, and clients of it in both dialects."""

import shutil

import pytest

from assistant.controllers import connect
from assistant.virtual.irc5 import VirtualIrc5
from tests.controllers.abb.rws.seam import SEAM, SIGNALS


@pytest.fixture(scope="package")
def irc5(tmp_path_factory):
    with VirtualIrc5(tmp_path_factory.mktemp("irc5") / "home", signals=SIGNALS) as controller:
        yield controller


@pytest.fixture(params=["rws", "rwss"])
def client(request, irc5):
    for path in irc5.folder.iterdir():
        shutil.rmtree(path) if path.is_dir() else path.unlink()
    address = irc5.rws_address if request.param == "rws" else irc5.rwss_address
    with connect(
        address, password=irc5.password, timeout=10, certificate=irc5.certificate
    ) as client:
        client.stop()
        client.set_output("doGripper", 0)
        yield client


@pytest.fixture
def loaded(client):
    client.write("seam.mod", SEAM)
    client.load("seam.mod")
    return client
