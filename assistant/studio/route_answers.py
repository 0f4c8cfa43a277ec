"""Answers of routes: plain data in, plain data out, and findings for refusals."""

from __future__ import annotations

import json
import math
from collections.abc import Awaitable, Callable, Mapping, Sequence
from dataclasses import field
from pathlib import Path as FilePath
from typing import Any, Final

from anyio import CapacityLimiter
from anyio.to_thread import run_sync
from starlette.requests import ClientDisconnect, Request
from starlette.responses import JSONResponse, PlainTextResponse, Response
from starlette.routing import Route

from assistant.base.budgets import Reached, internal_error
from assistant.base.data_classes import dataclass
from assistant.base.diagnostics import Diagnostic, Refused
from assistant.studio import rules
from assistant.studio.studio import Studio

_WINDOW_HEADER = "x-window"
"""Header that names the window which asks; a page from elsewhere cannot send it."""
_UNPROCESSABLE = 422
_SERVER_ERROR = 500
NOT_FOUND: Final = 404
_VIEW_POLICY: Final = (
    "default-src 'none'; script-src 'nonce-{nonce}'; style-src 'nonce-{nonce}'; img-src data:; "
    "base-uri 'none'; form-action 'none'; frame-ancestors 'self'"
)
"""The content security policy of a page of `view`: only its own script runs, nothing is loaded."""
_LARGEST_NUMBER: Final = 1e300
"""Largest number in a request."""


class _PlainData(JSONResponse):
    """Plain data as ASCII: bytes of a file name that are not text are escaped."""

    def render(self, content: object) -> bytes:
        return json.dumps(content, allow_nan=False, separators=(",", ":")).encode("ascii")


@dataclass(frozen=True, slots=True)
class Question:
    """Request of a page. window: its name. data: bytes sent with it."""

    values: Mapping[str, Any]
    window: str = ""
    data: bytes = field(default=b"", repr=False)

    def text(self, key: str, other: str | None = None) -> str:
        """A text; raises Refused where it is missing, unless there is another for it."""
        value = self.values.get(key, other)
        if not isinstance(value, str):
            raise not_asked(f"`{key}` is no text")
        return value

    def number(self, key: str, other: float | None = None) -> float:
        value = self.values.get(key, other)
        if isinstance(value, str):
            try:
                value = float(value)
            except ValueError:
                value = None
        if isinstance(value, bool) or not isinstance(value, int | float):
            raise not_asked(f"`{key}` is no number")
        if not -_LARGEST_NUMBER < value < _LARGEST_NUMBER:
            raise not_asked(f"`{key}` is no number")
        return float(value)

    def truth(self, key: str) -> bool:
        return self.values.get(key) is True

    def texts(self, key: str) -> list[str]:
        value = self.values.get(key, [])
        if not isinstance(value, list) or not all(isinstance(one, str) for one in value):
            raise not_asked(f"`{key}` is no list of texts")
        return value

    def table(self, key: str) -> Mapping[str, Any]:
        value = self.values.get(key, {})
        if not isinstance(value, dict):
            raise not_asked(f"`{key}` is no table")
        return value


Answering = Callable[[Studio, Question], object]


def looks(path: str, does: Answering) -> Route:
    """Return a route that changes nothing: by GET, with the request in the address."""

    async def answer(request: Request) -> Response:
        asked = Question(dict(request.query_params), request.headers.get(_WINDOW_HEADER, ""))
        return await _answer_in_thread(does, request.app.state.studio, asked)

    return Route(path, answer, methods=["GET"])


def asks(path: str, does: Answering, *, urgent: bool = False) -> Route:
    """A route that changes nothing, but is asked with more than an address holds.

    urgent: other requests do not keep it waiting.
    """
    return Route(path, _posted_data(does, writes=False, urgent=urgent), methods=["POST"])


def changes(path: str, does: Answering, *, urgent: bool = False) -> Route:
    """A route that changes something: only for the window that writes."""
    return Route(path, _posted_data(does, writes=True, urgent=urgent), methods=["POST"])


async def view_page(request: Request, make: Callable[[], dict[str, Any]] | None) -> Response:
    """Answer with a page of `view` of the record that `make` returns, or 404 without one."""
    if make is None:
        return PlainTextResponse("not here", NOT_FOUND)
    nonce = request.scope["state"]["nonce"]
    text = await run_sync(_fill_view, make, nonce)
    headers = {"Content-Security-Policy": _VIEW_POLICY.format(nonce=nonce)}
    return Response(text, media_type="text/html; charset=utf-8", headers=headers)


def _fill_view(make: Callable[[], dict[str, Any]], nonce: str) -> str:
    from assistant.view.page import filled_page

    return filled_page(make(), nonce=nonce)


def finding_records(found: Sequence[Diagnostic]) -> list[dict[str, Any]]:
    """Records of findings; files of the project have the names that the page calls them by."""
    from assistant.findings.formats import records_of  # the book of rules, which is large

    try:
        folder = FilePath.cwd()  # that of the project
    except OSError:  # it is gone
        folder = None
    records = records_of(found)
    for record in records:
        path = FilePath(record.get("path", ""))
        if folder is not None and path.is_absolute() and path.is_relative_to(folder):
            record["path"] = path.relative_to(folder).as_posix()
    return records


def plain_value(value: Any) -> Any:
    """Return a value in a form that JSON can hold; None for a number that is not finite."""
    match value:
        case dict():
            return {key: plain_value(one) for key, one in value.items()}
        case list():
            return [plain_value(one) for one in value]
        case bool() | int() | str() | None:
            return value
        case float():
            return value if math.isfinite(value) else None
    return str(value)


def _posted_data(
    does: Answering, *, writes: bool, urgent: bool
) -> Callable[[Request], Awaitable[Response]]:
    async def answer(request: Request) -> Response:
        studio: Studio = request.app.state.studio
        window = request.headers.get(_WINDOW_HEADER, "")
        if writes and not studio.windows.writes(window):
            return _refusal_response(Refused(rules.READ_ONLY()))
        try:
            body = await request.body()
        except ClientDisconnect:  # it is told to nobody
            return _refusal_response(not_asked("it was not asked to its end"))
        if writes and not studio.windows.writes(window):  # it has gone meanwhile
            return _refusal_response(Refused(rules.READ_ONLY()))
        if request.headers.get("content-type", "").startswith("application/octet-stream"):
            asked = Question(dict(request.query_params), window, body)
        else:
            try:
                values = json.loads(body or b"{}", parse_constant=_refuse_constant)
            except (ValueError, RecursionError):
                values = None
            if not isinstance(values, dict):
                return _refusal_response(not_asked("it is no JSON object"))
            asked = Question(values, window)
        limit = request.app.state.urgent if urgent else None
        return await _answer_in_thread(does, studio, asked, limit)

    return answer


async def _answer_in_thread(
    does: Answering, studio: Studio, asked: Question, limit: CapacityLimiter | None = None
) -> Response:
    try:
        answer = await run_sync(does, studio, asked, limiter=limit)
        return answer if isinstance(answer, Response) else _PlainData(answer)
    except Refused as refused:
        return _refusal_response(refused)
    except UnicodeEncodeError:  # a name that no file of ours can have
        return _refusal_response(not_asked("a text holds what is no character"))
    except RecursionError:
        return _refusal_response(not_asked("it is nested too deep"))
    except Reached as reached:
        return _data_response([internal_error(reached)], _SERVER_ERROR)
    except OSError as wrong:
        return _data_response([rules.SYSTEM(reason=wrong.strerror or wrong)], _SERVER_ERROR)
    except Exception as wrong:  # noqa: BLE001 (the studio goes on, and says so)
        return _data_response([internal_error(wrong)], _SERVER_ERROR)


def _refusal_response(refused: Refused) -> Response:
    return _data_response(refused.findings, _UNPROCESSABLE)


def _data_response(found: Sequence[Diagnostic], status: int) -> Response:
    return _PlainData({"findings": finding_records(found)}, status)


def _refuse_constant(name: str) -> object:
    raise ValueError(name)


def not_asked(reason: str) -> Refused:
    """For a page that asks what no page of ours asks."""
    return Refused(rules.NOT_ASKED(reason=reason), exit_status=2)
