"""User and password of a controller: from arguments, environment, keyring, or a question."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Final

from assistant.base.diagnostics import Refused
from assistant.controllers import rules
from assistant.controllers.address import Address

USER_VARIABLE: Final = "ROBOT_ASSISTANT_USER"
PASSWORD_VARIABLE: Final = "ROBOT_ASSISTANT_PASSWORD"  # noqa: S105 - the name of a variable
VARIABLE_PREFIX: Final = "ROBOT_ASSISTANT_"
KEYRING_SERVICE: Final = "robot-assistant"
"""Service name in the keyring; the entry is `user@host`."""

Question = Callable[[str], str | None]
"""Asks the user for a secret with this prompt; None or "" if there is no answer."""


@dataclass(frozen=True, slots=True)
class Credentials:
    user: str
    password: str = field(repr=False)

    def __str__(self) -> str:
        return self.user

    def hidden(self, text: str) -> str:
        """The text without the password, for replies that repeat what was sent."""
        return text.replace(self.password, "***") if self.password else text


def password_variable(controller: str, what: str) -> str:
    """The environment variable of one controller: `ROBOT_ASSISTANT_CELL1_PASSWORD`.

    what: USER or PASSWORD.
    """
    return f"{VARIABLE_PREFIX}{controller.upper().replace('-', '_')}_{what}"


def without_passwords(environment: Mapping[str, str] = os.environ) -> dict[str, str]:
    """The environment for another process, which has no business with controllers."""
    return {
        name: value
        for name, value in environment.items()
        if not (name.upper().startswith(VARIABLE_PREFIX) and name.upper().endswith("PASSWORD"))
    }


def find_credentials(
    address: Address,
    *,
    controller: str = "",
    user: str | None = None,
    password: str | None = None,
    ask: Question | None = None,
    environment: Mapping[str, str] = os.environ,
) -> Credentials:
    """The first user and password that are stated: arguments, address, environment, keyring, ask.

    controller: its name in the project; a variable of its own comes before the one of all.
    Raises Refused if there is none.
    """

    def stated(what: str, of_all: str) -> str | None:
        own = environment.get(password_variable(controller, what)) if controller else None
        return environment.get(of_all) if own is None else own

    name = user or address.user or stated("USER", USER_VARIABLE)
    if not name:
        raise Refused(rules.NO_USER(place=str(address), address=address), exit_status=2)
    if ":" in name:
        raise Refused(rules.USER_AND_PASSWORD(place=str(address), address=address), exit_status=2)
    sources: tuple[Callable[[], str | None], ...] = (
        lambda: password,
        lambda: stated("PASSWORD", PASSWORD_VARIABLE),
        lambda: _from_keyring(f"{name}@{address.host}"),
        lambda: ask(f"Password of {name} on {address.host}: ") if ask else None,
    )
    secret = next((found for source in sources if (found := source()) is not None), None)
    if secret is None:
        missing = rules.NO_PASSWORD(place=str(address), address=address, user=name)
        raise Refused(missing, exit_status=2)
    return Credentials(name, secret)


def _from_keyring(entry: str) -> str | None:
    """The password that the system's keyring holds, None if there is none or no keyring."""
    try:
        import keyring
        import keyring.errors
    except ImportError:
        return None
    try:
        found: str | None = keyring.get_password(KEYRING_SERVICE, entry)
    except keyring.errors.KeyringError:
        return None  # locked or without a backend: the next source is asked
    return found
