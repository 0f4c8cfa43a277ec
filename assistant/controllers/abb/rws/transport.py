"""Requests of one session over HTTP, with its cookies; what goes wrong becomes a `Broken`."""

from __future__ import annotations

import ssl
import time
from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

from assistant.controllers.credentials import Credentials
from assistant.controllers.os_errors_in_words import reason_of
from assistant.controllers.pace import TransferDeadline

if TYPE_CHECKING:
    import httpx

RATE: Final = 50_000.0
"""Bytes a second that are granted for sending a long file, beside the time-out."""
BUSY: Final = 503
"""Answered to more than 20 requests a second and to the 71st session."""
WAITS: Final = 3
"""Time-outs until an answer has begun: for connecting, for the way to log in, for the answer."""
AGAIN_AFTER: Final = 0.1
"""Seconds until a busy controller is asked again."""


class Broken(Exception):
    """There is no answer. untrusted: because of the certificate."""

    def __init__(self, reason: str, *, untrusted: bool = False) -> None:
        super().__init__(reason)
        self.untrusted = untrusted


@dataclass(frozen=True, slots=True)
class Response:
    """framed: whether its end was told, so that what came is known to be whole."""

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
            auth=httpx.BasicAuth(user, password) if trust else httpx.DigestAuth(user, password),
            verify=trust if trust is not None else True,
            trust_env=False,  # no proxy, and no password of a .netrc
            headers={"User-Agent": "robot-assistant", "Accept-Encoding": "identity", **single},
            event_hooks={"response": [self._keep_cookies]},
        )

    def close(self) -> None:
        self._client.close()

    def send(
        self, method: str, address: str, body: bytes | None, headers: Mapping[str, str]
    ) -> Response:
        """What comes back; a busy controller is asked again until the time is up."""
        import httpx

        granted = self._timeout + len(body or b"") / RATE
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
            if response.status != BUSY or time.monotonic() + AGAIN_AFTER > until:
                return response
            time.sleep(AGAIN_AFTER)

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
        with TransferDeadline(WAITS * granted, self._client.close):
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
        ends = {"content-length", "transfer-encoding"} & set(response.headers)
        framed = bool(ends) or response.status_code == 204
        return Response(response.status_code, framed, location, b"".join(pieces))

    def _keep_cookies(self, response: httpx.Response) -> None:
        for line in response.headers.get_list("set-cookie"):
            name, _, value = line.partition(";")[0].partition("=")
            if name.strip() and "\r" not in line and "\n" not in line:
                self.cookies[name.strip()] = value.strip()


def _broken(error: Exception) -> Broken:
    """What lies at the bottom of an exception of httpx."""
    cause: BaseException | None = error
    while cause is not None:
        if isinstance(cause, ssl.SSLCertVerificationError):
            return Broken(reason_of(cause), untrusted=True)
        if isinstance(cause, OSError):
            return Broken(reason_of(cause))
        cause = cause.__cause__ or cause.__context__
    return Broken(str(error) or type(error).__name__)
