"""Session with Robot Web Services: operations over HTTP, the meaning of refusals, write access.

`Transport` sends the requests of one session with its cookies, and turns every failure of the
connection into a `Broken`; `Session` turns it, and each status of the controller, into a finding.
`Mastership` is the write access while something is written, given back however the write ends. In
manual mode, the user confirms remote access (RMMP) on the pendant.
"""

from __future__ import annotations

import importlib.util
import re
import ssl
import time
import uuid
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from functools import partial
from pathlib import Path as FilePath
from typing import TYPE_CHECKING, Final, NoReturn
from urllib.parse import quote, urlencode, urljoin

from assistant.base.data_classes import dataclass
from assistant.base.diagnostics import Diagnostic, Refused
from assistant.controllers import connection, rules
from assistant.controllers.abb.rws import protocol
from assistant.controllers.abb.rws.protocol import (
    ANYTHING,
    DIALECTS,
    XHTML,
    Answer,
    Domain,
    Operation,
    parse_answer,
    plain_message,
)
from assistant.controllers.address import Address, Credentials
from assistant.controllers.connection import TransferDeadline, reason_of

if TYPE_CHECKING:
    import httpx


_RATE: Final = 50_000.0
"""Bytes a second that are granted for sending a long file, beside the time-out."""
_BUSY: Final = 503
"""Answered to more than 20 requests a second and to the 71st session."""
_WAITS: Final = 3
"""Time-outs until an answer has begun: for connecting, for the way to log in, for the answer."""
_AGAIN_AFTER: Final = 0.1
"""Seconds until a busy controller is asked again."""


class Broken(Exception):
    """There is no answer. untrusted: because of the certificate."""

    def __init__(self, reason: str, *, untrusted: bool = False) -> None:
        super().__init__(reason)
        self.untrusted = untrusted


@dataclass(frozen=True, slots=True)
class Response:
    """framed: whether its end was marked, so that the data are known to be complete."""

    status: int
    framed: bool
    location: str
    data: bytes


class Transport:
    """A connection that is opened when it is needed, and kept.

    root: scheme, host and port. trust: None for plain HTTP, which has Digest for the login.
    cookies: of the session, which other connections can go on with.
    """

    def __init__(
        self,
        root: str,
        credentials: Credentials,
        trust: ssl.SSLContext | None,
        timeout: float,
        cookies: Mapping[str, str],
    ) -> None:
        import httpx

        self.cookies = dict(cookies)
        self._root = root
        self._timeout = timeout
        # Without TLS a spoilt line could leave an answer behind that the next request would take
        # for its own; so each has a connection of its own, and the cookies make it one session.
        single = {} if trust else {"Connection": "close"}
        user, password = credentials.user, credentials.password
        self._client = httpx.Client(
            # Digest keeps the password off a plain line; TLS protects it by itself.
            auth=httpx.BasicAuth(user, password) if trust else httpx.DigestAuth(user, password),
            # Plain HTTP needs no authorities, which take 20 ms to load: this one has none.
            verify=trust or ssl.SSLContext(ssl.PROTOCOL_TLS_CLIENT),
            trust_env=False,  # no proxy, and no password of a .netrc
            headers={"User-Agent": "robot-assistant", "Accept-Encoding": "identity", **single},
            event_hooks={"response": [self._keep_cookies]},
        )

    def close(self) -> None:
        self._client.close()

    def send(
        self, method: str, address: str, body: bytes | None, headers: Mapping[str, str]
    ) -> Response:
        """Return the response to a request; repeat it on a busy controller until the time-out."""
        import httpx

        granted = self._timeout + len(body or b"") / _RATE
        until = time.monotonic() + granted
        while True:
            try:
                response = self._received(method, address, body, headers, granted)
            except (httpx.TimeoutException, TimeoutError) as error:
                raise Broken("no answer in time") from error
            except (httpx.HTTPError, httpx.InvalidURL, httpx.StreamError, OSError) as error:
                raise _broken(error) from error
            except (KeyError, NotImplementedError, ValueError) as error:
                # A way of logging in that httpx has not, or a header that is none.
                raise Broken(f"the answer cannot be used: {error}") from error
            # Busy: 503 comes for more than 20 requests a second, which pass.
            if response.status != _BUSY or time.monotonic() + _AGAIN_AFTER > until:
                return response
            time.sleep(_AGAIN_AFTER)

    def _received(
        self,
        method: str,
        address: str,
        body: bytes | None,
        headers: Mapping[str, str],
        granted: float,
    ) -> Response:
        self._client.cookies.clear()  # which rejects those that name the host by its number
        kept = "; ".join(f"{name}={value}" for name, value in self.cookies.items())
        said = {**headers, **({"Cookie": kept} if kept else {})}
        request = self._client.build_request(
            method, self._root + address, content=body, headers=said, timeout=granted
        )
        # Closing the client is the only way to end a request that trickles byte by byte.
        with TransferDeadline(_WAITS * granted, self._client.close):
            response = self._client.send(request, stream=True)
        pieces: list[bytes] = []
        try:
            with TransferDeadline(granted, self._client.close) as pace:
                for piece in response.iter_raw():
                    pieces.append(piece)
                    pace.moved(len(piece))
        finally:
            response.close()
        location = response.headers.get("Location", "")
        # Without a marked end, a cut line looks like the end of the data.
        ends = {"content-length", "transfer-encoding"} & set(response.headers)
        framed = bool(ends) or response.status_code == 204
        return Response(response.status_code, framed, location, b"".join(pieces))

    def _keep_cookies(self, response: httpx.Response) -> None:
        for line in response.headers.get_list("set-cookie"):
            name, _, value = line.partition(";")[0].partition("=")
            # A line end in a cookie would start another header.
            if name.strip() and "\r" not in line and "\n" not in line:
                self.cookies[name.strip()] = value.strip()


def _broken(error: Exception) -> Broken:
    """Return the error for the root cause of an exception of httpx."""
    cause: BaseException | None = error
    while cause is not None:
        if isinstance(cause, ssl.SSLCertVerificationError):
            return Broken(reason_of(cause), untrusted=True)
        if isinstance(cause, OSError):
            return Broken(reason_of(cause))
        cause = cause.__cause__ or cause.__context__
    return Broken(str(error) or type(error).__name__)


_UNCHANGED: Final = "nothing was changed by that"
_UNLESS: Final = ", unless the controller did it before the line was cut"
_FAREWELL: Final = 2.0
"""Seconds that logging a lost session out may take at most."""
MOST_PAGES: Final = 1000
"""Pages of an answer after which it counts as garbage."""
STATUS: Final = {
    404: "there is no such resource",
    405: "the controller does not do that",
    410: "the controller does not do that any more",
    _BUSY: "the controller is busy, or has 70 sessions open",
}
"""Meaning of a status without a text."""


class NotThere(Refused):
    """There is no such file, module, data, signal or resource."""


class NoMastership(Refused):
    """The session has not the mastership that the operation needs."""


class NotNow(Refused):
    """The programs are in no state for the operation."""


class NoLongerThere(Refused):
    """The controller has given up this part of the services (HTTP 410)."""


class LostFor(rules.Lost):
    """Lost, with the reason as a separate field."""

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
        """Cookie header that tells the controller that a connection belongs to this session."""
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
        # A lost session still counts among the 70 of the
        # controller: log it out over a new connection.
        if self._transport is None and self._cookies:
            self._transport = self._connection(min(self.timeout, _FAREWELL))
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
        state: str = _UNCHANGED,
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
        # Pages that refer to each other would never end.
        seen: set[str] = set()
        while found[-1].next and sum(len(page.rows) for page in found) < enough:
            # A relative address counts from the page that names it.
            following = found[-1].next  # written beside the one that names it
            address = following if following.startswith("/") else urljoin(address, following)
            if not re.match("/(?!/)", address):  # the password goes to no other host
                raise self.garbled(doing, f"the next page is `{following}`")
            if address in seen:
                break
            if len(seen) >= MOST_PAGES:
                raise self.garbled(doing, f"more than {MOST_PAGES} pages")
            seen.add(address)
            found.append(self._asked(operation, address, None, doing, _UNCHANGED))
        return found

    def refusal(self, what: str, reason: str, cure: str) -> Refused:
        """That the controller cannot do something, with why."""
        return Refused(
            rules.NOT_HERE(
                place=str(self.address), address=self.address, what=what, reason=reason, cure=cure
            )
        )

    def garbled(self, doing: str, answer: str, state: str = _UNCHANGED) -> Refused:
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
        """Check that required packages are installed and user and password are unambiguous."""
        missing = importlib.util.find_spec("httpx") is None
        if missing or importlib.util.find_spec("websockets") is None:
            raise Refused(rules.NEEDS_RWS(place=str(self.address)), exit_status=2)
        user, password = self._credentials.user, self._credentials.password
        # Digest quotes the user: a quotation mark would end it, a control character the header.
        if re.search(r'[\x00-\x1f\x7f"\\]', user) or re.search(r"[\x00-\x1f\x7f]", password):
            self._not_let_in("a control character or quotation mark in the user or the password")

    def _connection(self, timeout: float) -> Transport:
        root = f"{'https' if self.dialect.secure else 'http'}://{self.authority}"
        return Transport(root, self._credentials, self.trust, timeout, self._cookies)

    def _trusted(self) -> ssl.SSLContext:
        host, port = self.address.host, self.address.port
        try:
            shown = partial(connection.certificate_at, host, port, self.timeout)
            return connection.tls_context(self._certificate, shown)
        except connection.BadCertificateFile as error:
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
            # 406: not in this form; the next one is tried.
            if response.status != 406:
                break
        return self._judged(operation, response, doing, state)

    def _accepted(self, operation: Operation) -> tuple[str, ...]:
        own = self.dialect.accept if operation.method == "GET" else self.dialect.accept_written
        if not self.dialect.secure:
            return (ANYTHING if operation.accept == ANYTHING else own,)
        # XHTML and then anything, for resources that lack a JSON form.
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
            self.lost("waiting", "there is no session", _UNCHANGED)
        try:
            return self._transport.send(method, address, body, headers)
        except Broken as error:
            if error.untrusted:
                self._untrusted(str(error))
            acted = method in ("POST", "DELETE") and state != _UNCHANGED
            self.lost(doing, str(error), f"{state}{_UNLESS}" if acted else state)
        finally:
            # Cookies outlive the connection: a new one goes on with the session.
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
        # Files and written resources answer with data, not with rows.
        if good and (operation.accept == ANYTHING or operation.method in ("PUT", "DELETE")):
            return answer
        try:
            rows, following, number, text = parse_answer(response.data)
        except ValueError as error:
            # A good status without rows that can be read is garbage; a refusal needs none.
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
        if status == 404 or number in protocol.ABSENT:
            kind = NotThere
        if status == 410:
            kind = NoLongerThere
        if number == protocol.NO_MASTERSHIP:
            kind = NoMastership
        if number == protocol.NOT_NOW:
            kind = NotNow
        if number is None:
            reply = f"HTTP {status}, {said or STATUS.get(status, 'without a text')}"
            return kind(rules.REFUSED(place=place, doing=doing, reply=reply, state=state))
        return kind(
            rules.ALARM(
                place=place,
                number=number,
                text=said or protocol.ERROR_TEXTS.get(number, f"HTTP {status}"),
                doing=doing,
                state=state,
                cure=protocol.ERROR_CURES.get(number, protocol.OTHER_CURE),
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


_STATION: Final = "robot-assistant"
_PIN: Final = "1234"
"""PIN with which a remote control station of RobotWare 8 registers; any four digits."""


class Mastership:
    """Write permission of a session. RobotWare 8 has one write access instead of domains.

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
        # After a cut the mastership may still be held by the session: give it back over a new line.
        except rules.Lost as error:
            self._held.remove(name)
            raise self._after_cut(name, error) from None
        except BaseException:
            self._held.remove(name)
            # The error of the operation tells more than one of giving back.
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
        """Send a writing operation with the mastership of its table entry; return the answer.

        Systems differ in what needs it: where one demands a mastership that others do not need, it
        takes it.
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
                # 410: RobotWare 8 has no domains; it asks for
                # a registered station and one write access.
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
            "control-station-name": _STATION,
            "control-station-id": f"{{{str(uuid.uuid4()).upper()}}}",
            "pincode": _PIN,
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
        """Give back over one new connection of the session; else a finding reports it held."""
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


_REMOTE_POLL: Final = 0.5
GRANTED: Final = frozenset({"modify", "exec", "exclusive"})


def ask_remote_access(session: Session, wait: float) -> None:
    """Returns when the leave to write has been given; raises Refused if it was not in time."""
    doing = "asking for remote access in manual mode"
    # Granted before: no second question on the pendant.
    if _granted(session):
        return
    session.ask("ask privilege", doing=doing, form={"privilege": "modify"})
    until = time.monotonic() + wait
    while not _granted(session):
        if time.monotonic() + _REMOTE_POLL > until:
            raise Refused(
                rules.NOT_DONE(
                    place=str(session.address),
                    doing=doing,
                    seconds=wait,
                    state="nobody confirmed it on the pendant",
                )
            )
        time.sleep(_REMOTE_POLL)
        session.ask("poll privilege", doing=doing)


def _granted(session: Session) -> bool:
    """True if this session may write in manual mode."""
    rows = session.ask("privilege", doing="asking for the remote access").rows
    mine = [row for row in rows if row.get("rmmpheldbyme").lower() == "true"]
    return any(row.get("privilege").lower() in GRANTED for row in mine)
