"""Language server: the editing service over pipes or a local TCP port.

`Server` is one conversation with an editor, `server_with_features` makes one with every feature.
Loading this module loads pygls.
"""

from __future__ import annotations

import asyncio
import logging
import threading
from collections.abc import Callable, Sequence
from pathlib import Path as FilePath
from typing import Any, Final, TypeVar
from urllib.parse import unquote, urlsplit

from lsprotocol import types as lsp
from pygls import uris
from pygls.exceptions import JsonRpcException, JsonRpcInvalidParams
from pygls.io_ import run_async
from pygls.lsp.server import LanguageServer
from pygls.protocol import LanguageServerProtocol, lsp_method

from assistant.base.budgets import freeze_loaded_objects
from assistant.base.diagnostics import Refused
from assistant.editing import lsp_types, service, symbols
from assistant.editing.checker import Checker
from assistant.editing.service import Change, Changes, Document, Location, Workspace

REST: Final = 0.4
"""Seconds without a key after which the complete program is checked."""
_SOON: Final = 0.03
"""Seconds without a key after which the changed parts are checked: a request sent with the key is
answered first.
"""
_TRANSLATION: Final = "robot-assistant.translation"
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
        """Return the internal name of a document; its file if it is one."""
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
                part = [Change(lsp_types.our_range(one.range), one.text)]
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
        await asyncio.sleep(_SOON)
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
            self._publish(uri, [lsp_types.diagnostic(one) for one in found], document.version)

    def _publish(self, uri: str, told: list[lsp.Diagnostic], version: int | None) -> None:
        self.text_document_publish_diagnostics(
            lsp.PublishDiagnosticsParams(uri, told, version=version)
        )

    @property
    def _pulls(self) -> bool:
        """True if the editor requests findings; they are then not sent as well."""
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
        return [lsp_types.diagnostic(one) for one in found]

    async def actions(self, uri: str, range: lsp.Range) -> list[lsp.CodeAction]:
        document = self.document(uri)
        if not self.documents.is_known(document):
            return []
        wanted = lsp_types.our_range(range)
        made: list[lsp.CodeAction] = []
        for found in service.findings(document):
            if found.range.end < wanted.start or wanted.end < found.range.start:
                continue
            told = lsp_types.diagnostic(found)
            fixes = await asyncio.to_thread(service.fixes, document, found)
            made += (lsp_types.action(fix, self.edits(fix.changes), told) for fix in fixes)
        return made

    def edits(self, changes: Changes) -> dict[str, list[lsp.TextEdit]]:
        return {self.uri(path): lsp_types.edits(of_file) for path, of_file in changes.items()}

    # ------------------------------------------------------------------------------- tokens

    def tokens(self, uri: str) -> lsp.SemanticTokens:
        self._count += 1
        data = lsp_types.encoded(service.tokens(self.document(uri)))
        self._tokens[uri] = str(self._count), data
        return lsp.SemanticTokens(data, result_id=str(self._count))

    def tokens_since(self, uri: str, known: str) -> lsp.SemanticTokens | lsp.SemanticTokensDelta:
        before = self._tokens.get(uri)
        now = self.tokens(uri)
        if before is None or before[0] != known:
            return now
        return lsp.SemanticTokensDelta(
            lsp_types.delta(before[1], now.data), result_id=now.result_id
        )


def refusing(work: Callable[[], T]) -> T:
    """Run `work` and report a refusal to the client that sent the request."""
    try:
        return work()
    except Refused as refused:
        said = "; ".join(
            f"{one.code} {one.message}{f' ({one.cure})' if one.cure else ''}"
            for one in refused.findings[:3]
        )
        raise JsonRpcInvalidParams(said) from None


_TRIGGERS: Final = [".", "\\"]
"""Characters behind which names of parts and options stand."""


def server_with_features(version: str) -> Server:
    """A server with all features."""
    server = Server(version)
    for offer in (
        _add_documents,
        _add_findings,
        _add_words,
        _add_names,
        _add_layout,
        _add_tokens,
        _add_commands,
    ):
        offer(server)
    return server


def _add_documents(server: Server) -> None:
    @server.feature(lsp.INITIALIZED)
    def initialized(ls: Server, _: lsp.InitializedParams) -> None:
        root = ls.workspace.root_uri
        path = uris.to_fs_path(root) if root else None
        ls.documents.root = FilePath(path) if path else None

    @server.feature(lsp.TEXT_DOCUMENT_DID_OPEN)
    async def opened(ls: Server, params: lsp.DidOpenTextDocumentParams) -> None:
        one = params.text_document
        ls.take(one.uri, one.text, one.version, one.language_id)

    @server.feature(lsp.TEXT_DOCUMENT_DID_CHANGE)
    async def changed(ls: Server, params: lsp.DidChangeTextDocumentParams) -> None:
        one = params.text_document
        ls.change(one.uri, params.content_changes, one.version)

    @server.feature(lsp.TEXT_DOCUMENT_DID_CLOSE)
    async def closed(ls: Server, params: lsp.DidCloseTextDocumentParams) -> None:
        ls.leave(params.text_document.uri)

    @server.feature(lsp.TEXT_DOCUMENT_DID_SAVE)
    async def saved(ls: Server, params: lsp.DidSaveTextDocumentParams) -> None:
        ls.saved(params.text_document.uri)

    @server.feature(lsp.WORKSPACE_DID_CHANGE_WATCHED_FILES)
    async def watched(ls: Server, params: lsp.DidChangeWatchedFilesParams) -> None:
        for one in params.changes:
            ls.saved(one.uri)


def _add_findings(server: Server) -> None:
    options = lsp.DiagnosticOptions(inter_file_dependencies=True, workspace_diagnostics=False)

    @server.feature(lsp.TEXT_DOCUMENT_DIAGNOSTIC, options)
    async def pulled(
        ls: Server, params: lsp.DocumentDiagnosticParams
    ) -> lsp.RelatedFullDocumentDiagnosticReport:
        return lsp.RelatedFullDocumentDiagnosticReport(await ls.pulled(params.text_document.uri))

    kinds = lsp.CodeActionOptions([lsp.CodeActionKind.QuickFix])

    @server.feature(lsp.TEXT_DOCUMENT_CODE_ACTION, kinds)
    async def actions(ls: Server, params: lsp.CodeActionParams) -> list[lsp.CodeAction]:
        return await ls.actions(params.text_document.uri, params.range)


def _add_words(server: Server) -> None:
    options = lsp.CompletionOptions(trigger_characters=_TRIGGERS)

    @server.feature(lsp.TEXT_DOCUMENT_COMPLETION, options)
    def completions(ls: Server, params: lsp.CompletionParams) -> lsp.CompletionList:
        document = ls.document(params.text_document.uri)
        found = service.completions(document, lsp_types.place_of(params.position))
        return lsp.CompletionList(True, [lsp_types.completion(one) for one in found])

    @server.feature(lsp.TEXT_DOCUMENT_HOVER)
    async def hover(ls: Server, params: lsp.HoverParams) -> lsp.Hover | None:
        document = ls.document(params.text_document.uri)
        place = lsp_types.place_of(params.position)
        found = await asyncio.to_thread(service.hover, document, place)
        if found is None:
            return None
        text = lsp.MarkupContent(lsp.MarkupKind.Markdown, found.text)
        return lsp.Hover(text, lsp_types.range_of(found.range))


def _add_names(server: Server) -> None:
    def location(ls: Server, found: Location) -> lsp.Location:
        return lsp.Location(ls.uri(found.path), lsp_types.range_of(found.range))

    @server.feature(lsp.TEXT_DOCUMENT_DEFINITION)
    def definition(ls: Server, params: lsp.DefinitionParams) -> lsp.Location | None:
        document = ls.document(params.text_document.uri)
        found = service.definition(document, lsp_types.place_of(params.position))
        return None if found is None else location(ls, found)

    @server.feature(lsp.TEXT_DOCUMENT_REFERENCES)
    def references(ls: Server, params: lsp.ReferenceParams) -> list[lsp.Location]:
        document = ls.document(params.text_document.uri)
        also = params.context.include_declaration
        found = service.references(document, lsp_types.place_of(params.position), also)
        return [location(ls, one) for one in found]

    @server.feature(lsp.TEXT_DOCUMENT_PREPARE_RENAME)
    def renameable(ls: Server, params: lsp.PrepareRenameParams) -> lsp.Range | None:
        document = ls.document(params.text_document.uri)
        found = service.renameable(document, lsp_types.place_of(params.position))
        return None if found is None else lsp_types.range_of(found)

    @server.feature(lsp.TEXT_DOCUMENT_RENAME, lsp.RenameOptions(prepare_provider=True))
    def rename(ls: Server, params: lsp.RenameParams) -> lsp.WorkspaceEdit:
        document = ls.document(params.text_document.uri)
        place, name = lsp_types.place_of(params.position), params.new_name
        changes = refusing(lambda: service.rename(document, place, name))
        return lsp.WorkspaceEdit(changes=ls.edits(changes))


def _add_layout(server: Server) -> None:
    @server.feature(lsp.TEXT_DOCUMENT_DOCUMENT_SYMBOL)
    def outline(ls: Server, params: lsp.DocumentSymbolParams) -> list[lsp.DocumentSymbol]:
        document = ls.document(params.text_document.uri)
        return [lsp_types.symbol(one) for one in service.outline(document)]

    @server.feature(lsp.TEXT_DOCUMENT_FORMATTING)
    async def formatted(ls: Server, params: lsp.DocumentFormattingParams) -> list[lsp.TextEdit]:
        document = ls.document(params.text_document.uri)
        work = asyncio.to_thread(refusing, lambda: service.formatted(document))
        return lsp_types.edits(await work)


def _add_tokens(server: Server) -> None:
    options = lsp.SemanticTokensRegistrationOptions(
        lsp_types.LEGEND, full=lsp.SemanticTokensFullDelta(delta=True), range=True
    )

    @server.feature(lsp.TEXT_DOCUMENT_SEMANTIC_TOKENS_FULL, options)
    def full(ls: Server, params: lsp.SemanticTokensParams) -> lsp.SemanticTokens:
        return ls.tokens(params.text_document.uri)

    @server.feature(lsp.TEXT_DOCUMENT_SEMANTIC_TOKENS_FULL_DELTA, options)
    def delta(
        ls: Server, params: lsp.SemanticTokensDeltaParams
    ) -> lsp.SemanticTokens | lsp.SemanticTokensDelta:
        return ls.tokens_since(params.text_document.uri, params.previous_result_id)

    @server.feature(lsp.TEXT_DOCUMENT_SEMANTIC_TOKENS_RANGE, options)
    def part(ls: Server, params: lsp.SemanticTokensRangeParams) -> lsp.SemanticTokens:
        first, last = params.range.start.line, params.range.end.line
        tokens = service.tokens(ls.document(params.text_document.uri), first, last)
        return lsp.SemanticTokens(lsp_types.encoded(tokens))


def _add_commands(server: Server) -> None:
    @server.command(_TRANSLATION)
    async def translation(ls: Server, uri: str, language: str) -> dict[str, Any]:
        document = ls.document(uri)
        work = asyncio.to_thread(refusing, lambda: service.translation(document, language))
        done = await work
        return {
            "files": dict(done.files),
            "draft": done.draft,
            "pairs": [
                {"source": list(one.source), "written": list(one.written), "what": one.what}
                for one in done.pairs
            ],
            "findings": [str(one.diagnostic) for one in done.findings],
        }


_LOOPBACK: Final = "127.0.0.1"
_BEGIN: Final = b"Content-"
"""First bytes of every message of the protocol; a browser's request begins otherwise."""


def serve_pipes(version: str) -> None:
    """Until the editor says exit or closes the pipes."""
    server_with_features(version).start_io()


def serve_line(version: str, port: int, listening: Callable[[int], None]) -> None:
    """Serve one editor that connects to a port of this computer; port 0 takes a free one.

    listening: called with the port. Raises Refused if the server cannot listen on it.
    """
    asyncio.run(_serve_line(version, port, listening))


async def _serve_line(version: str, port: int, listening: Callable[[int], None]) -> None:
    server, left = server_with_features(version), asyncio.Event()
    stop = threading.Event()
    taken = False

    async def connected(reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        nonlocal taken
        if taken:
            writer.close()
            return
        try:
            first = await reader.readexactly(len(_BEGIN))
        except (asyncio.IncompleteReadError, OSError):
            writer.close()
            return
        if first != _BEGIN or taken:
            writer.close()
            return
        taken = True
        server.protocol.set_writer(writer)
        try:
            await run_async(
                stop_event=stop,
                reader=_Begun(first, reader),
                protocol=server.protocol,
                logger=logging.getLogger(__name__),
                error_handler=server.report_server_error,
            )
        finally:
            left.set()

    try:
        listener = await asyncio.start_server(connected, _LOOPBACK, port)
    except (OSError, OverflowError) as error:
        reason = getattr(error, "strerror", None) or str(error)
        raise Refused(symbols.NOT_BOUND(port=port, reason=reason), exit_status=2) from None
    async with listener:
        listening(listener.sockets[0].getsockname()[1])
        await left.wait()


class _Begun:
    """A stream of which the first bytes were read."""

    def __init__(self, first: bytes, rest: asyncio.StreamReader) -> None:
        self._first, self._rest = first, rest

    async def readline(self) -> bytes:
        first, self._first = self._first, b""
        return first + await self._rest.readline()

    async def readexactly(self, n: int) -> bytes:
        return await self._rest.readexactly(n)
