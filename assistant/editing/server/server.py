"""The features of the language server: each asks the service and says the answer in its words."""

from __future__ import annotations

import asyncio
from collections.abc import Callable, Sequence
from pathlib import Path as FilePath
from typing import Any, Final, TypeVar
from urllib.parse import unquote, urlsplit

from lsprotocol import types as lsp
from pygls import uris
from pygls.exceptions import JsonRpcException, JsonRpcInvalidParams
from pygls.lsp.server import LanguageServer
from pygls.protocol import LanguageServerProtocol, lsp_method

from assistant.base.budgets import freeze_loaded_objects
from assistant.base.diagnostics import Refused
from assistant.editing import service
from assistant.editing.checker import Checker
from assistant.editing.server import words
from assistant.editing.service import Change, Changes, Document, Workspace

REST: Final = 0.4
"""Seconds without a key after which the whole program is looked at."""
SOON: Final = 0.03
"""Seconds without a key after which what changed is looked at: a request that comes with the key is
answered first."""
LANGUAGES: Final = "assistant"
TRANSLATION: Final = "robot-assistant.translation"
"""Command of the server: an address and a language; gives files and lines."""
T = TypeVar("T")


class _Protocol(LanguageServerProtocol):
    @lsp_method(lsp.INITIALIZE)
    def lsp_initialize(self, params: lsp.InitializeParams) -> Any:
        """Columns are counted in UTF-16, which every client has to offer."""
        general = params.capabilities.general
        if general is not None:
            general.position_encodings = [lsp.PositionEncodingKind.Utf16]
        return (yield from super().lsp_initialize(params))

    @lsp_method(lsp.SHUTDOWN)
    def lsp_shutdown(self, params: None) -> Any:
        """Ends the process that looks at whole programs, so that nobody waits for it."""
        server: Any = self._server
        server.checker.close()
        return (yield from super().lsp_shutdown(params))

    def structure_message(self, data: dict[str, Any]) -> Any:
        """Answer a request whose parameters are broken by an error: its editor waits for it."""
        try:
            return super().structure_message(data)
        except JsonRpcException:
            if isinstance(data.get("method"), str) and isinstance(data.get("id"), int | str):
                error = JsonRpcInvalidParams(f"the parameters of `{data['method']}` are broken")
                self._send_response(data["id"], None, error.to_response_error())
            raise


class Server(LanguageServer):
    """One conversation with an editor."""

    def __init__(self, version: str) -> None:
        super().__init__("robot-assistant", version, protocol_cls=_Protocol)
        self.documents = Workspace()
        self.checker = Checker()
        self.documents.apart = self.checker.look
        self._addresses: dict[str, str] = {}
        self._pending: dict[str, asyncio.Task[None]] = {}
        self._resting: dict[str, asyncio.Task[None]] = {}
        self._tokens: dict[str, tuple[str, list[int]]] = {}
        self._kept: set[str] = set()
        self._count = 0

    # ---------------------------------------------------------------------------- documents

    def path(self, uri: str) -> str:
        """What a document is called here; its file if it is one."""
        path = uris.to_fs_path(uri) if urlsplit(uri).scheme == "file" else None
        name = path or unquote(uri)
        self._addresses[name] = uri
        return name

    def uri(self, path: str) -> str:
        known = self._addresses.get(path)
        return known or uris.from_fs_path(str(FilePath(path).absolute())) or path

    def document(self, uri: str) -> Document:
        """The open document; raises JsonRpcInvalidParams for one that is not open."""
        found = self.documents.documents.get(self.path(uri))
        if found is None:
            raise JsonRpcInvalidParams("the document is not open")
        return found

    def take(self, uri: str, text: str, version: int, language: str) -> None:
        self.documents.open(self.path(uri), text, version, language)
        self._begin(uri, rest=0.0)

    def change(self, uri: str, changes: Sequence[Any], version: int) -> None:
        path = self.path(uri)
        if path not in self.documents.documents:
            return
        for one in changes:
            part: Sequence[Change] | str = one.text
            if getattr(one, "range", None) is not None:
                part = [Change(words.our_range(one.range), one.text)]
            self.documents.change(path, part, version)
        self._begin(uri, rest=REST)

    def leave(self, uri: str) -> None:
        for tasks in (self._pending, self._resting):
            if (task := tasks.pop(uri, None)) is not None:
                task.cancel()
        self.documents.close(self.path(uri))
        self._tokens.pop(uri, None)
        self._publish(uri, [], None)

    def saved(self, uri: str) -> None:
        self.documents.saved(self.path(uri))
        for path in list(self.documents.documents):
            self._begin(self.uri(path), rest=REST)

    # ----------------------------------------------------------------------------- findings

    def _begin(self, uri: str, rest: float) -> None:
        """Findings of what changed soon, of the whole program when there is time."""
        for tasks, made in (
            (self._pending, self._soon(uri)),
            (self._resting, self._rest(uri, rest)),
        ):
            if (before := tasks.get(uri)) is not None:
                before.cancel()
            tasks[uri] = asyncio.get_running_loop().create_task(made)

    async def _soon(self, uri: str) -> None:
        await asyncio.sleep(SOON)
        document = self.documents.documents.get(self.path(uri))
        if document is not None and self.documents.is_known(document):
            self._tell(uri, document, service.findings(document))

    async def _rest(self, uri: str, rest: float) -> None:
        await asyncio.sleep(rest)
        document = self.documents.documents.get(self.path(uri))
        if document is None:
            return
        found = await asyncio.to_thread(service.settled, document)
        if document.language not in self._kept:
            self._kept.add(document.language)
            freeze_loaded_objects()
        now = self.documents.documents.get(document.path)
        if now is document:
            self._tell(uri, document, found)
            if self._pulls:
                self._refresh()
        elif now is not None and self.documents.is_known(now):
            self._tell(uri, now, service.findings(now))

    def _tell(self, uri: str, document: Document, found: Sequence[service.Found]) -> None:
        if not self._pulls:
            self._publish(uri, [words.diagnostic(one) for one in found], document.version)

    def _publish(self, uri: str, told: list[lsp.Diagnostic], version: int | None) -> None:
        self.text_document_publish_diagnostics(
            lsp.PublishDiagnosticsParams(uri, told, version=version)
        )

    @property
    def _pulls(self) -> bool:
        """Whether the editor asks for findings by itself: then they are not sent as well."""
        asks = self.client_capabilities.text_document
        return asks is not None and asks.diagnostic is not None

    def _refresh(self) -> None:
        asks = self.client_capabilities.workspace
        if asks is not None and asks.diagnostics is not None and asks.diagnostics.refresh_support:
            self.workspace_diagnostic_refresh(None)

    async def pulled(self, uri: str) -> list[lsp.Diagnostic]:
        document = self.document(uri)
        if self.documents.is_known(document):
            found = service.findings(document)
        else:
            found = await asyncio.to_thread(service.settled, document)
        return [words.diagnostic(one) for one in found]

    async def actions(self, uri: str, range: lsp.Range) -> list[lsp.CodeAction]:
        document = self.document(uri)
        if not self.documents.is_known(document):
            return []
        wanted = words.our_range(range)
        made: list[lsp.CodeAction] = []
        for found in service.findings(document):
            if found.range.end < wanted.start or wanted.end < found.range.start:
                continue
            told = words.diagnostic(found)
            fixes = await asyncio.to_thread(service.fixes, document, found)
            made += (words.action(fix, self.edits(fix.changes), told) for fix in fixes)
        return made

    def edits(self, changes: Changes) -> dict[str, list[lsp.TextEdit]]:
        return {self.uri(path): words.edits(of_file) for path, of_file in changes.items()}

    # ------------------------------------------------------------------------------- tokens

    def tokens(self, uri: str) -> lsp.SemanticTokens:
        self._count += 1
        data = words.encoded(service.tokens(self.document(uri)))
        self._tokens[uri] = str(self._count), data
        return lsp.SemanticTokens(data, result_id=str(self._count))

    def tokens_since(self, uri: str, known: str) -> lsp.SemanticTokens | lsp.SemanticTokensDelta:
        before = self._tokens.get(uri)
        now = self.tokens(uri)
        if before is None or before[0] != known:
            return now
        return lsp.SemanticTokensDelta(words.delta(before[1], now.data), result_id=now.result_id)


def refusing(work: Callable[[], T]) -> T:
    """What is refused is told to the one who asked."""
    try:
        return work()
    except Refused as refused:
        said = "; ".join(
            f"{one.code} {one.message}{f' ({one.cure})' if one.cure else ''}"
            for one in refused.findings[:3]
        )
        raise JsonRpcInvalidParams(said) from None
