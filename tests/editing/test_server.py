"""The language server as editors start it, spoken to by a client that checks what it is told."""

from __future__ import annotations

import asyncio
import contextlib
import json
import socket
import subprocess
import sys
from pathlib import Path

import pytest
import pytest_lsp
from lsprotocol import types as lsp
from pygls import uris
from pygls.lsp.client import BaseLanguageClient
from pytest_lsp import ClientServerConfig, LanguageClient, client_capabilities

from assistant.base.diagnostics import Refused
from assistant.cli.services import run_lsp
from tests.editing.typing import kept, lines_to_damage, made

SAMPLES = Path(__file__).parent.parent.parent / "samples"
COMMAND = [sys.executable, "-m", "assistant", "lsp"]
MODULE = """MODULE Umlaute
    ! Grüße 🤖 für alle
    CONST robtarget pOben:=[[380,0,420],[0,0,1,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];

    PROC main()
        TPWrite "🤖🤖 ä"; MoveL pOben,v100,fine,tool0;
        MoveL pUnten,v100,fine,tool0;
    ENDPROC
ENDMODULE
"""


@pytest_lsp.fixture(scope="module", config=ClientServerConfig(server_command=COMMAND))
async def client(lsp_client: LanguageClient):
    """An editor that is told findings, and does not ask for them."""
    await lsp_client.initialize_session(
        lsp.InitializeParams(capabilities=client_capabilities("visual-studio-code@v1.65.2"))
    )
    _listen(lsp_client)
    yield
    await lsp_client.shutdown_session()


def _listen(client):
    """Keeps what it is told of findings: of two that come at once a waiting test would hear one."""
    client.told = asyncio.Queue()

    def heard(one):
        client.told.put_nowait(one)
        client.protocol.wait_for_notification(lsp.TEXT_DOCUMENT_PUBLISH_DIAGNOSTICS, heard)

    client.protocol.wait_for_notification(lsp.TEXT_DOCUMENT_PUBLISH_DIAGNOSTICS, heard)


async def opened(client, path, text, language=""):
    uri = uris.from_fs_path(str(path)) if not str(path).startswith("untitled") else str(path)
    client.text_document_did_open(
        lsp.DidOpenTextDocumentParams(lsp.TextDocumentItem(uri, language, 1, text))
    )
    await told(client, uri)
    return uri


async def told(client, uri, version=1):
    """The findings of one state of a document."""
    while True:
        one = await asyncio.wait_for(client.told.get(), 60)
        if one.uri == uri and one.version == version:
            return list(one.diagnostics)


def replace(client, uri, version, range, text):
    client.text_document_did_change(
        lsp.DidChangeTextDocumentParams(
            lsp.VersionedTextDocumentIdentifier(version, uri),
            [lsp.TextDocumentContentChangePartial(range, text)],
        )
    )


def between(line, start, end):
    return lsp.Range(lsp.Position(line, start), lsp.Position(line, end))


@pytest.mark.asyncio(loop_scope="module")
async def test_columns_are_counted_in_utf_16(client, tmp_path):
    uri = await opened(client, tmp_path / "Umlaute.mod", MODULE)
    document = lsp.TextDocumentIdentifier(uri)
    found = client.diagnostics[uri]
    assert [(one.code, one.range.start.line) for one in found] == [("RA403", 6)]
    assert found[0].range == between(6, 14, 20)

    at = lsp.Position(5, MODULE.splitlines()[5].index("pOben") + 2)  # two robots, two units more
    definition = await client.text_document_definition_async(lsp.DefinitionParams(document, at))
    assert definition.range == between(2, 20, 25)
    references = await client.text_document_references_async(
        lsp.ReferenceParams(lsp.ReferenceContext(True), document, at)
    )
    assert [one.range for one in references] == [between(2, 20, 25), between(5, 32, 37)]

    tokens = await client.text_document_semantic_tokens_full_async(
        lsp.SemanticTokensParams(document)
    )
    words = decoded(tokens.data, MODULE)
    assert ("comment", "! Grüße 🤖 für alle") in words
    assert ("string", '"🤖🤖 ä"') in words
    assert ("enumMember", "pOben") in words
    assert ("macro", "MoveL") in words

    replace(client, uri, 2, between(6, 14, 20), "pOben")
    assert not await told(client, uri, 2)


def decoded(data, text):
    """Sorts and texts of the words, cut out of the text by the units of UTF-16."""
    from assistant.editing.lsp_types import LEGEND

    lines = [line.encode("utf-16-le") for line in text.splitlines()]
    line = column = 0
    found = []
    for lines_on, columns_on, length, sort, _ in zip(*[iter(data)] * 5, strict=True):
        column = columns_on + (0 if lines_on else column)
        line += lines_on
        cut = lines[line][2 * column : 2 * (column + length)]
        found.append((LEGEND.token_types[sort], cut.decode("utf-16-le")))
    return found


@pytest.mark.asyncio(loop_scope="module")
async def test_a_finding_is_cured_by_its_quick_fix(client, tmp_path):
    uri = await opened(client, tmp_path / "Umlaute.mod", MODULE)
    found = client.diagnostics[uri]
    actions = await client.text_document_code_action_async(
        lsp.CodeActionParams(
            lsp.TextDocumentIdentifier(uri), found[0].range, lsp.CodeActionContext(found)
        )
    )
    titles = [one.title for one in actions]
    assert any(title.startswith("Declare `CONST robtarget pUnten") for title in titles)
    assert titles[-1] == "Ignore RA403 here"
    first = next(one for one in actions if one.is_preferred)
    (edit,) = first.edit.changes[uri]
    replace(client, uri, 2, edit.range, edit.new_text)
    assert not await told(client, uri, 2)


@pytest.mark.asyncio(loop_scope="module")
async def test_words_names_outline_and_layout_are_there(client, tmp_path):
    text = (SAMPLES / "rapid" / "palletising.mod").read_text("utf-8")
    uri = await opened(client, tmp_path / "palletising.mod", text)
    document = lsp.TextDocumentIdentifier(uri)
    symbols = await client.text_document_document_symbol_async(lsp.DocumentSymbolParams(document))
    assert [one.name for one in symbols] == ["Palletising"]
    assert [one.name for one in symbols[0].children if one.kind == lsp.SymbolKind.Method] == [
        *("main", "PickBox", "PlaceBox"),
    ]
    call = place_of(text, "PickBox;")
    hover = await client.text_document_hover_async(lsp.HoverParams(document, call))
    assert "PROC PickBox()" in hover.contents.value
    hover = await client.text_document_hover_async(
        lsp.HoverParams(document, place_of(text, "pFirst:="))
    )
    assert "30.00 mm, 30.00 mm, 0.00 mm" in hover.contents.value
    listed = await client.text_document_completion_async(
        lsp.CompletionParams(document, lsp.Position(call.line, call.character + 4))
    )
    assert listed.items[0].label == "PickBox"
    edit = await client.text_document_rename_async(lsp.RenameParams(document, call, "FetchBox"))
    assert len(edit.changes[uri]) == 2
    with pytest.raises(Exception, match="ED002"):
        await client.text_document_rename_async(lsp.RenameParams(document, call, "main"))
    with pytest.raises(Exception, match="ED001"):
        await client.text_document_rename_async(lsp.RenameParams(document, call, "MoveL"))
    replace(client, uri, 2, between(call.line, 0, 4), "")
    edits = await client.text_document_formatting_async(
        lsp.DocumentFormattingParams(document, lsp.FormattingOptions(4, True))
    )
    assert [one.new_text.strip() for one in edits] == ["PickBox;"]


def place_of(text, word):
    at = text.index(word)
    before = text[:at]
    return lsp.Position(before.count("\n"), at - before.rfind("\n") - 1 + 1)


@pytest.mark.asyncio(loop_scope="module")
async def test_findings_and_tokens_can_be_asked_for(client, tmp_path):
    uri = await opened(client, tmp_path / "Umlaute.mod", MODULE)
    document = lsp.TextDocumentIdentifier(uri)
    report = await client.text_document_diagnostic_async(lsp.DocumentDiagnosticParams(document))
    assert report.items == client.diagnostics[uri]
    full = await client.text_document_semantic_tokens_full_async(lsp.SemanticTokensParams(document))
    replace(client, uri, 2, between(6, 14, 20), "pOben")
    parts = await client.text_document_semantic_tokens_full_delta_async(
        lsp.SemanticTokensDeltaParams(document, full.result_id)
    )
    data = list(full.data)
    for edit in parts.edits:
        data[edit.start : edit.start + edit.delete_count] = edit.data or []
    again = await client.text_document_semantic_tokens_full_async(
        lsp.SemanticTokensParams(document)
    )
    assert data == list(again.data) != list(full.data)
    some = await client.text_document_semantic_tokens_range_async(
        lsp.SemanticTokensRangeParams(document, between(2, 0, 5))
    )
    assert 0 < len(some.data) < len(full.data)


@pytest.mark.asyncio(loop_scope="module")
async def test_a_text_without_a_file_is_told_by_its_language(client):
    uri = await opened(
        client, "untitled:Untitled-1", "program p\n\nprocedure main\n  wait 1\nend\n", "pseudo"
    )
    (found,) = client.diagnostics[uri]
    assert found.code.startswith("PS") and found.range.start.line == 3
    done = await client.workspace_execute_command_async(
        lsp.ExecuteCommandParams("robot-assistant.translation", arguments=[uri, "rapid"])
    )
    assert done["files"] == {} and done["findings"]


def test_one_editor_may_connect_to_a_port_of_this_computer_and_no_browser():
    server = subprocess.Popen([*COMMAND, "--tcp", "0"], stdout=subprocess.PIPE)
    try:
        assert server.stdout is not None
        port = int(server.stdout.readline().decode().rpartition(":")[2])
        with socket.create_connection(("127.0.0.1", port)) as browser:
            browser.sendall(b"POST / HTTP/1.1\r\nContent-Length: 2\r\n\r\n{}")
            with contextlib.suppress(ConnectionError):
                assert browser.recv(100) == b""
        asyncio.run(_said_over(port))
        assert server.wait(20) == 0
    finally:
        server.kill()
        server.wait()
        server.stdout.close()


BROKEN = [
    {"textDocument": {"uri": 5}},
    {"position": {"line": "x"}},
    [],
    7,
    None,
    {"textDocument": None},
]


def test_a_request_with_broken_parameters_is_answered_by_an_error():
    """And so is the next one of the same server, which shuts down in the end as others do."""

    def message(**content):
        data = json.dumps({"jsonrpc": "2.0", **content}).encode()
        return b"Content-Length: %d\r\n\r\n%b" % (len(data), data)

    wrong = range(2, 2 + len(BROKEN))
    process = subprocess.Popen(COMMAND, stdin=subprocess.PIPE, stdout=subprocess.PIPE)
    try:
        process.stdin.write(message(id=1, method="initialize", params={"capabilities": {}}))
        for number, params in zip(wrong, BROKEN, strict=True):
            process.stdin.write(message(id=number, method="textDocument/completion", params=params))
        process.stdin.write(message(id=wrong.stop, method="shutdown", params=None))
        process.stdin.flush()
        answers = {}
        while len(answers) < 2 + len(BROKEN):
            length = int(process.stdout.readline().partition(b":")[2])
            while process.stdout.readline().strip():
                pass
            answer = json.loads(process.stdout.read(length))
            if "id" in answer and "method" not in answer:
                answers[answer["id"]] = answer
    finally:
        process.kill()
        process.communicate()
    assert "result" in answers[1] and "error" not in answers[wrong.stop]
    for number, params in zip(wrong, BROKEN, strict=True):
        assert answers[number]["error"]["code"] in (-32602, -32603), params


async def _said_over(port):
    client = BaseLanguageClient("test", "1")
    await client.start_tcp("127.0.0.1", port)
    utf_8 = lsp.GeneralClientCapabilities(position_encodings=["utf-8", "utf-16"])
    done = await client.initialize_async(
        lsp.InitializeParams(lsp.ClientCapabilities(general=utf_8))
    )
    assert done.server_info.name == "robot-assistant"
    assert done.capabilities.position_encoding == "utf-16"
    await client.shutdown_async(None)
    client.exit(None)
    await client.stop()


def test_a_port_in_use_is_a_finding():
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        taken.listen()
        port = taken.getsockname()[1]
        with pytest.raises(Refused, match="ED011"):
            run_lsp(port)


@pytest.mark.slow
@pytest.mark.asyncio(loop_scope="module")
async def test_twenty_files_are_open_and_damaged_and_no_finding_flickers(client, tmp_path, tell):
    texts = {**kept(), **made()}
    chosen = dict(sorted(texts.items(), key=lambda one: -len(one[1]))[:20])
    open_ones = {}
    for name, text in chosen.items():
        folder = tmp_path / name.replace(".", "-")
        folder.mkdir()
        open_ones[name] = await opened(client, folder / name, text)
    damaged = 0
    for name, text in chosen.items():
        uri, lines = open_ones[name], text.splitlines()
        number = lines_to_damage(text, "!" if name.endswith(".mod") else "'")[1]
        before = others_than(client.diagnostics[uri], number)
        version, there = 1, lines[number]
        for state in (there[: len(there) * 2 // 3] + " (", there + ' "', there[:-1] + "§", there):
            version += 1
            length = len(lines[number].encode("utf-16-le")) // 2
            replace(client, uri, version, between(number, 0, length), state)
            lines[number] = state
            found = await told(client, uri, version)
            if state != there:
                assert [one for one in found if one.range.start.line == number], (name, state)
                damaged += 1
            assert others_than(found, number) == before, (name, state)
    lines = sum(len(text.splitlines()) for text in chosen.values())
    tell(f"20 files open, {lines:,} lines: {damaged} damaged states told, no finding flickered")


def others_than(found, line):
    return sorted(
        (one.code, one.range.start.line, one.range.start.character, one.message)
        for one in found
        if one.range.start.line != line
    )
