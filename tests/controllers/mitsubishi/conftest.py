"""A CR controller and its client."""

import pytest

from assistant.controllers import parse
from assistant.controllers.mitsubishi.cr import Cr
from assistant.virtual.cr import VirtualCr


@pytest.fixture
def controller():
    """It runs four times as fast as a real one."""
    with VirtualCr("rv-2aj", servo_time=0.02, pace=4.0) as controller:
        yield controller


@pytest.fixture(scope="module")
def standing():
    """A client for tests that leave the controller as it was."""
    with (
        VirtualCr("rv-2aj", servo_time=0.02) as controller,
        Cr(parse(controller.address), timeout=5, pace=0.01) as client,
    ):
        yield client


@pytest.fixture
def client(controller):
    with Cr(parse(controller.address), timeout=5, pace=0.01) as client:
        yield client


@pytest.fixture(autouse=True)
def quick_commands(monkeypatch):
    """A virtual controller needs no pause between commands while a program runs."""
    monkeypatch.setitem(Cr.__init__.__kwdefaults__, "pace", 0.01)
