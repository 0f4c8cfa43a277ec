"""Mastership (write access) while something is written, given back on every way out."""

from __future__ import annotations

import uuid
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from typing import Final

from assistant.base.diagnostics import Refused
from assistant.controllers import rules
from assistant.controllers.abb.rws.answers import Answer
from assistant.controllers.abb.rws.dialects import Domain
from assistant.controllers.abb.rws.session import NoLongerThere, NoMastership, Session

STATION: Final = "robot-assistant"
PIN: Final = "1234"
"""What a remote control station of RobotWare 8 registers with; any four digits."""


class Mastership:
    """What a session may write. RobotWare 8 has one write access instead of domains.

    Source of RobotWare 8: `src/rws2/core.ts` of ichbinmeraj/abb-rws-client, tried on 8.1.1.
    """

    def __init__(self, session: Session) -> None:
        self._session = session
        self._held: list[str] = []
        self._by_station = False

    @property
    def held(self) -> bool:
        return bool(self._held)

    @contextmanager
    def of(self, domain: Domain, doing: str) -> Iterator[None]:
        """Takes the mastership for something, unless this session has it, and gives it back."""
        name = self._session.dialect.domains[domain] if domain else ""
        if not name or name in self._held:
            yield
            return
        self._take(name, doing)
        self._held.append(name)
        try:
            yield
        except rules.Lost as error:
            self._held.remove(name)
            raise self._after_cut(name, error) from None
        except BaseException:
            self._held.remove(name)
            self._quietly_back(name)
            raise
        else:
            self._held.remove(name)
            self._give_back(name)

    def ask(
        self,
        name: str,
        *,
        doing: str,
        state: str,
        form: Mapping[str, str] | None = None,
        at: Mapping[str, str] | None = None,
    ) -> Answer:
        """The answer to a writing operation, with the mastership that it is said to need.

        Systems differ in what needs it: where one asks for it that others do without, it gets it.
        """
        domain = self._session.dialect.operations[name].domain
        try:
            with self.of(domain, doing):
                return self._session.ask(name, doing=doing, state=state, form=form, at=at)
        except NoMastership:
            if domain or self.held:
                raise
        with self.of("rapid", doing):
            return self._session.ask(name, doing=doing, state=state, form=form, at=at)

    def _take(self, name: str, doing: str) -> None:
        said = f"{doing}: taking the mastership `{name}`"
        try:
            if not self._by_station:
                try:
                    self._session.ask("take", doing=said, at={"domain": name})
                except NoLongerThere:
                    self._by_station = "register" in self._session.dialect.operations
                    if not self._by_station:
                        raise
                    self._register(said)
                else:
                    return
            self._session.ask("take access", doing=said)
        except rules.Lost as error:  # it may have been given, with the answer on its way
            raise self._after_cut(name, error) from None

    def _register(self, doing: str) -> None:
        form = {
            "control-station-name": STATION,
            "control-station-id": f"{{{str(uuid.uuid4()).upper()}}}",
            "pincode": PIN,
        }
        self._session.ask("register", doing=doing, form=form)

    def _give_back(self, name: str) -> None:
        doing = f"giving the mastership `{name}` back"
        operation = "give access back" if self._by_station else "give back"
        try:
            self._session.ask(operation, doing=doing, at={"domain": name})
        except rules.Lost as error:
            raise self._after_cut(name, error) from None
        except Refused:
            if not self._by_station:  # RobotWare 8 has taken it back by itself after a write
                raise

    def _quietly_back(self, name: str) -> None:
        """Gives it back beside another error, which tells more."""
        if not self._session.connected:
            return
        try:
            self._give_back(name)
        except Refused as error:
            if isinstance(error, rules.Lost):
                raise
            self._session.close()  # a session that has ended holds nothing

    def _after_cut(self, name: str, error: rules.Lost) -> rules.Lost:
        """One new connection of the same session gives back; else the finding tells of it."""
        operation = "give access back" if self._by_station else "give back"
        try:
            self._session.open_again()
            self._session.ask(operation, doing="giving the mastership back", at={"domain": name})
        except NoMastership:
            return error
        except Refused as refused:
            if self._by_station and not isinstance(refused, rules.Lost):
                return error  # RobotWare 8 has taken it back by itself after a write
            place = self._session.address
            held = rules.MAY_BE_HELD(place=str(place), address=place, right=f"mastership `{name}`")
            return rules.Lost(*error.findings, held)
        finally:
            self._session.hang_up()
        return error
