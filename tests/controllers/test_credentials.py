"""Where user and password come from, and that the password is nowhere to be read."""

import sys
import types

import pytest

from assistant.base.diagnostics import Refused
from assistant.controllers import Credentials, connect, parse
from assistant.controllers.address import PASSWORD_VARIABLE, USER_VARIABLE, find_credentials

ADDRESS = parse("ftp://irc5")


@pytest.fixture
def keyring(monkeypatch):
    """A stand-in for the system's keyring, which a test must not touch."""
    module = types.ModuleType("keyring")
    errors = types.ModuleType("keyring.errors")
    errors.KeyringError = type("KeyringError", (Exception,), {})
    module.errors = errors
    module.held = {("robot-assistant", "anna@irc5"): "from-keyring"}
    module.get_password = lambda service, entry: module.held.get((service, entry))
    monkeypatch.setitem(sys.modules, "keyring", module)
    monkeypatch.setitem(sys.modules, "keyring.errors", errors)
    return module


def test_the_order_of_sources(keyring):
    environment = {USER_VARIABLE: "anna", PASSWORD_VARIABLE: "from-environment"}
    given = find_credentials(
        ADDRESS, user="bert", password="from-argument", environment=environment
    )
    assert (given.user, given.password) == ("bert", "from-argument")
    assert find_credentials(ADDRESS, environment=environment).password == "from-environment"
    stored = find_credentials(ADDRESS, user="anna", environment={}, ask=lambda _: "asked")
    assert stored.password == "from-keyring"
    prompts = []
    asked = find_credentials(
        ADDRESS, user="carl", environment={}, ask=lambda p: prompts.append(p) or "asked"
    )
    assert asked.password == "asked" and "carl" in prompts[0] and "irc5" in prompts[0]
    named = find_credentials(parse("ftp://dora@irc5"), password="x", environment=environment)
    assert named.user == "dora"


def test_a_locked_keyring_is_passed_over(keyring):
    def locked(service, entry):
        raise keyring.errors.KeyringError("locked")

    keyring.get_password = locked
    assert (
        find_credentials(ADDRESS, user="a", environment={}, ask=lambda _: "asked").password
        == "asked"
    )


@pytest.mark.parametrize(
    ("user", "ask", "code"),
    [(None, None, "CN111"), ("anna", None, "CN112"), ("anna", lambda _: None, "CN112")],
)
def test_nothing_known_is_a_finding(monkeypatch, user, ask, code):
    monkeypatch.setitem(sys.modules, "keyring", None)
    with pytest.raises(Refused) as refused:
        find_credentials(ADDRESS, user=user, environment={}, ask=ask)
    assert [f.code for f in refused.value.findings] == [code]


def test_a_password_is_in_no_representation():
    credentials = Credentials("anna", "geheim")
    client = connect("ftp://anna@irc5", credentials=credentials)
    for text in (repr(credentials), str(credentials), f"{credentials}", repr(client)):
        assert "geheim" not in text
    assert credentials.hidden("530 PASS geheim is wrong") == "530 PASS *** is wrong"
