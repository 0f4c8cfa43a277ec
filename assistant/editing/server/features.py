"""What the language server offers, feature by feature."""

from __future__ import annotations

import asyncio
from pathlib import Path as FilePath
from typing import Any, Final

from lsprotocol import types as lsp
from pygls import uris

from assistant.editing import service
from assistant.editing.server import words
from assistant.editing.server.server import TRANSLATION, Server, refusing
from assistant.editing.service import Location

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
        found = service.completions(document, words.place_of(params.position))
        return lsp.CompletionList(True, [words.completion(one) for one in found])

    @server.feature(lsp.TEXT_DOCUMENT_HOVER)
    async def hover(ls: Server, params: lsp.HoverParams) -> lsp.Hover | None:
        document = ls.document(params.text_document.uri)
        place = words.place_of(params.position)
        found = await asyncio.to_thread(service.hover, document, place)
        if found is None:
            return None
        text = lsp.MarkupContent(lsp.MarkupKind.Markdown, found.text)
        return lsp.Hover(text, words.range_of(found.range))


def _add_names(server: Server) -> None:
    def location(ls: Server, found: Location) -> lsp.Location:
        return lsp.Location(ls.uri(found.path), words.range_of(found.range))

    @server.feature(lsp.TEXT_DOCUMENT_DEFINITION)
    def definition(ls: Server, params: lsp.DefinitionParams) -> lsp.Location | None:
        document = ls.document(params.text_document.uri)
        found = service.definition(document, words.place_of(params.position))
        return None if found is None else location(ls, found)

    @server.feature(lsp.TEXT_DOCUMENT_REFERENCES)
    def references(ls: Server, params: lsp.ReferenceParams) -> list[lsp.Location]:
        document = ls.document(params.text_document.uri)
        also = params.context.include_declaration
        found = service.references(document, words.place_of(params.position), also)
        return [location(ls, one) for one in found]

    @server.feature(lsp.TEXT_DOCUMENT_PREPARE_RENAME)
    def renameable(ls: Server, params: lsp.PrepareRenameParams) -> lsp.Range | None:
        document = ls.document(params.text_document.uri)
        found = service.renameable(document, words.place_of(params.position))
        return None if found is None else words.range_of(found)

    @server.feature(lsp.TEXT_DOCUMENT_RENAME, lsp.RenameOptions(prepare_provider=True))
    def rename(ls: Server, params: lsp.RenameParams) -> lsp.WorkspaceEdit:
        document = ls.document(params.text_document.uri)
        place, name = words.place_of(params.position), params.new_name
        changes = refusing(lambda: service.rename(document, place, name))
        return lsp.WorkspaceEdit(changes=ls.edits(changes))


def _add_layout(server: Server) -> None:
    @server.feature(lsp.TEXT_DOCUMENT_DOCUMENT_SYMBOL)
    def outline(ls: Server, params: lsp.DocumentSymbolParams) -> list[lsp.DocumentSymbol]:
        document = ls.document(params.text_document.uri)
        return [words.symbol(one) for one in service.outline(document)]

    @server.feature(lsp.TEXT_DOCUMENT_FORMATTING)
    async def formatted(ls: Server, params: lsp.DocumentFormattingParams) -> list[lsp.TextEdit]:
        document = ls.document(params.text_document.uri)
        work = asyncio.to_thread(refusing, lambda: service.formatted(document))
        return words.edits(await work)


def _add_tokens(server: Server) -> None:
    options = lsp.SemanticTokensRegistrationOptions(
        words.LEGEND, full=lsp.SemanticTokensFullDelta(delta=True), range=True
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
        return lsp.SemanticTokens(words.encoded(tokens))


def _add_commands(server: Server) -> None:
    @server.command(TRANSLATION)
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
