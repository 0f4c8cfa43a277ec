"""A session with Robot Web Services: operations of a dialect, and what refusals mean."""

from __future__ import annotations

import importlib.util
import re
import ssl
from collections.abc import Mapping
from functools import partial
from pathlib import Path as FilePath
from typing import Final, NoReturn
from urllib.parse import quote, urlencode, urljoin

from assistant.base.diagnostics import Diagnostic, Refused
from assistant.controllers import rules
from assistant.controllers.abb import trust
from assistant.controllers.abb.rws import codes
from assistant.controllers.abb.rws.answers import Answer, parse_answer, plain_message
from assistant.controllers.abb.rws.dialects import ANYTHING, DIALECTS, XHTML, Operation
from assistant.controllers.abb.rws.transport import BUSY, Broken, Response, Transport
from assistant.controllers.address import Address
from assistant.controllers.credentials import Credentials
from assistant.controllers.os_errors_in_words import reason_of

UNCHANGED: Final = "nothing was changed by that"
UNLESS: Final = ", unless the controller did it before the line was cut"
FAREWELL: Final = 2.0
"""Seconds that logging a lost session out may take at most."""
MOST_PAGES: Final = 1000
"""Pages of an answer after which it is taken for garbage."""
STATUS: Final = {
    404: "there is no such resource",
    405: "the controller does not do that",
    410: "the controller does not do that any more",
    BUSY: "the controller is busy, or has 70 sessions open",
}
"""What a status means that comes without a text."""


class NotThere(Refused):
    """There is no such file, module, data, signal or resource."""


class NoMastership(Refused):
    """The session has not the mastership that the operation needs."""


class NotNow(Refused):
    """The programs are in no state for the operation."""


class NoLongerThere(Refused):
    """The controller has given up this part of the services (HTTP 410)."""


class LostFor(rules.Lost):
    """Lost, with the reason by itself."""

    def __init__(self, finding: Diagnostic, reason: str) -> None:
        super().__init__(finding)
        self.reason = reason


class Session:
    """See `Rws`, whose requests it sends."""

    def __init__(
        self,
        address: Address,
        credentials: Credentials,
        *,
        timeout: float,
        certificate: str | FilePath | None,
    ) -> None:
        self.address = address
        self.timeout = timeout
        self.dialect = DIALECTS[address.scheme]
        self.trust: ssl.SSLContext | None = None
        self._credentials = credentials
        self._certificate = certificate
        self._transport: Transport | None = None
        self._cookies: dict[str, str] = {}

    @property
    def connected(self) -> bool:
        return self._transport is not None

    @property
    def cookie(self) -> str:
        """What tells the controller that a connection belongs to this session."""
        return "; ".join(f"{name}={value}" for name, value in self._cookies.items())

    @property
    def authority(self) -> str:
        host = f"[{self.address.host}]" if ":" in self.address.host else self.address.host
        return f"{host}:{self.address.port}"

    def open(self) -> Answer:
        """Connects and logs in; what the controller says of its system."""
        self._check_parts()
        if self.dialect.secure:
            self.trust = self._trusted()
        self._transport = self._connection(self.timeout)
        try:
            return self.ask("system", doing="logging in")
        except LostFor as error:
            raise self._unreachable(error.reason) from None
        except BaseException:
            self.close()
            raise

    def open_again(self) -> None:
        """A new connection of the same session, after the line was cut."""
        self.hang_up()
        self._transport = self._connection(self.timeout)

    def close(self) -> None:
        """Logs out: a controller has 70 sessions at most. A lost session gets one more try."""
        if self._transport is None and self._cookies:
            self._transport = self._connection(min(self.timeout, FAREWELL))
        if self._transport is not None and self._cookies:
            try:
                self.ask("logout", doing="logging out")
            except Refused:
                self._cookies = {}  # the session ends by itself after five idle minutes
        self.hang_up()
        self._cookies = {}

    def hang_up(self) -> None:
        if self._transport is not None:
            self._transport.close()
            self._transport = None

    def ask(
        self,
        name: str,
        *,
        doing: str,
        state: str = UNCHANGED,
        form: Mapping[str, str] | None = None,
        query: Mapping[str, str] | None = None,
        body: bytes | None = None,
        at: Mapping[str, str] | None = None,
    ) -> Answer:
        """The answer to an operation of the dialect; raises Refused, or rules.Lost.

        form, query: beside those of the operation. body: instead of a form, of a file. at: the
        fields of the path. state: what of the controller holds if it fails.
        """
        operation = self.dialect.operations[name]
        action = {"action": operation.action} if operation.action else {}
        asked = _form({**action, **operation.query, **(query or {})}).decode()
        path = _path(operation, at)
        if body is None and operation.method != "GET":
            body = _form({**operation.form, **(form or {})})
        address = f"{path}?{asked}" if asked else path
        return self._asked(operation, address, body, doing, state)

    def pages(
        self,
        name: str,
        *,
        doing: str,
        at: Mapping[str, str] | None = None,
        enough: int = 1_000_000,
    ) -> list[Answer]:
        """The answers to a reading operation, page by page, until there are enough rows."""
        operation = self.dialect.operations[name]
        found = [self.ask(name, doing=doing, at=at)]
        address = _path(operation, at)
        seen: set[str] = set()
        while found[-1].next and sum(len(page.rows) for page in found) < enough:
            following = found[-1].next  # written beside the one that names it
            address = following if following.startswith("/") else urljoin(address, following)
            if not re.match("/(?!/)", address):  # the password goes to no other host
                raise self.garbled(doing, f"the next page is `{following}`")
            if address in seen:
                break
            if len(seen) >= MOST_PAGES:
                raise self.garbled(doing, f"more than {MOST_PAGES} pages")
            seen.add(address)
            found.append(self._asked(operation, address, None, doing, UNCHANGED))
        return found

    def refusal(self, what: str, reason: str, cure: str) -> Refused:
        """That the controller cannot do something, with why."""
        return Refused(
            rules.NOT_HERE(
                place=str(self.address), address=self.address, what=what, reason=reason, cure=cure
            )
        )

    def garbled(self, doing: str, answer: str, state: str = UNCHANGED) -> Refused:
        """That an answer makes no sense."""
        said = self._credentials.hidden(answer)[:200]
        return Refused(
            rules.GARBLED_WEB(place=str(self.address), doing=doing, answer=said, state=state)
        )

    def lost(self, doing: str, reason: str, state: str) -> NoReturn:
        """Hangs up and raises that there is no connection any more."""
        self.hang_up()
        said = self._credentials.hidden(reason)
        finding = rules.LOST(place=str(self.address), doing=doing, reason=said, state=state)
        raise LostFor(finding, said) from None

    def _check_parts(self) -> None:
        """What the client needs, and that user and password cannot become something else."""
        missing = importlib.util.find_spec("httpx") is None
        if missing or importlib.util.find_spec("websockets") is None:
            raise Refused(rules.NEEDS_RWS(place=str(self.address)), exit_status=2)
        user, password = self._credentials.user, self._credentials.password
        if re.search(r'[\x00-\x1f\x7f"\\]', user) or re.search(r"[\x00-\x1f\x7f]", password):
            self._not_let_in("a control character or quotation mark in the user or the password")

    def _connection(self, timeout: float) -> Transport:
        root = f"{'https' if self.dialect.secure else 'http'}://{self.authority}"
        return Transport(root, self._credentials, self.trust, timeout, self._cookies)

    def _trusted(self) -> ssl.SSLContext:
        host, port = self.address.host, self.address.port
        try:
            shown = partial(trust.certificate_at, host, port, self.timeout)
            return trust.tls_context(self._certificate, shown)
        except trust.BadCertificateFile as error:
            self._untrusted(f"`{self._certificate}`: {error}")
        except (OSError, ValueError) as error:
            raise self._unreachable(reason_of(error)) from None

    def _unreachable(self, reason: str) -> rules.Lost:
        return rules.Lost(
            rules.UNREACHABLE(place=str(self.address), address=self.address, reason=reason)
        )

    def _untrusted(self, reason: str) -> NoReturn:
        self.hang_up()
        raise Refused(
            rules.CERTIFICATE(place=str(self.address), address=self.address, reason=reason),
            exit_status=2,
        ) from None

    def _asked(
        self, operation: Operation, address: str, body: bytes | None, doing: str, state: str
    ) -> Answer:
        """The answer, in the first of the forms that the controller has for it."""
        kind = self.dialect.upload if operation.method == "PUT" else self.dialect.form
        content = {"Content-Type": kind} if body is not None else {}
        for accept in self._accepted(operation):
            headers = {"Accept": accept, **content}
            response = self._sent(operation.method, address, body, headers, doing, state)
            if response.status != 406:
                break
        return self._judged(operation, response, doing, state)

    def _accepted(self, operation: Operation) -> tuple[str, ...]:
        own = self.dialect.accept if operation.method == "GET" else self.dialect.accept_written
        if not self.dialect.secure:
            return (ANYTHING if operation.accept == ANYTHING else own,)
        first = operation.accept or own
        return (
            tuple(dict.fromkeys((first, XHTML, ANYTHING)))
            if operation.method == "GET"
            else (first,)
        )

    def _sent(
        self,
        method: str,
        address: str,
        body: bytes | None,
        headers: Mapping[str, str],
        doing: str,
        state: str,
    ) -> Response:
        if self._transport is None:
            self.lost("waiting", "there is no session", UNCHANGED)
        try:
            return self._transport.send(method, address, body, headers)
        except Broken as error:
            if error.untrusted:
                self._untrusted(str(error))
            acted = method in ("POST", "DELETE") and state != UNCHANGED
            self.lost(doing, str(error), f"{state}{UNLESS}" if acted else state)
        finally:
            if self._transport is not None:
                self._cookies = self._transport.cookies

    def _judged(self, operation: Operation, response: Response, doing: str, state: str) -> Answer:
        """The answer with its rows, if it is no refusal."""
        if response.status == 401:
            self._not_let_in("HTTP 401, the user or the password is wrong")
        good = 200 <= response.status < 300
        answer = Answer(
            response.status, location=response.location, data=response.data, framed=response.framed
        )
        if good and (operation.accept == ANYTHING or operation.method in ("PUT", "DELETE")):
            return answer
        try:
            rows, following, number, text = parse_answer(response.data)
        except ValueError as error:
            if good:
                raise self.garbled(doing, str(error), state) from None
            rows, following, number, text = (), "", None, ""
        if good:
            return Answer(
                response.status, rows, following, number, text, response.location, response.data
            )
        raise self._refused(response.status, number, plain_message(text), doing, state)

    def _refused(
        self, status: int, number: int | None, text: str, doing: str, state: str
    ) -> Refused:
        place = str(self.address)
        said = self._credentials.hidden(text)
        kind: type[Refused] = Refused
        if status == 404 or number in codes.ABSENT:
            kind = NotThere
        if status == 410:
            kind = NoLongerThere
        if number == codes.NO_MASTERSHIP:
            kind = NoMastership
        if number == codes.NOT_NOW:
            kind = NotNow
        if number is None:
            reply = f"HTTP {status}, {said or STATUS.get(status, 'without a text')}"
            return kind(rules.REFUSED(place=place, doing=doing, reply=reply, state=state))
        return kind(
            rules.ALARM(
                place=place,
                number=number,
                text=said or codes.ERROR_TEXTS.get(number, f"HTTP {status}"),
                doing=doing,
                state=state,
                cure=codes.ERROR_CURES.get(number, codes.OTHER_CURE),
            )
        )

    def _not_let_in(self, reply: str) -> NoReturn:
        self.hang_up()
        self._cookies = {}
        user = self._credentials.user
        finding = rules.LOGIN(place=str(self.address), address=self.address, user=user, reply=reply)
        raise Refused(finding, exit_status=2)


def _path(operation: Operation, at: Mapping[str, str] | None) -> str:
    """The path with its fields. A volume's `$` and the `:` of a unit stay as they are."""
    return operation.path.format_map({k: quote(v, safe="$:/~") for k, v in (at or {}).items()})


def _form(values: Mapping[str, str]) -> bytes:
    """Form data; what the references write as it is stays readable: `$HOME/x.mod`, `[[1,2]]`."""
    return urlencode(values, quote_via=quote, safe="$/:;[],").encode()
