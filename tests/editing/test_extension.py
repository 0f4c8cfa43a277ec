"""The extension for VS Code: what is in the file, and the colours that its grammars give."""

from __future__ import annotations

import io
import json
import re
import shutil
import subprocess
import xml.etree.ElementTree as ElementTree
import zipfile
from pathlib import Path

import pytest

from assistant import languages
from assistant.cli.virtual_runs import LAUNCH_KEYS
from assistant.editing.vscode.extension import FORMAT, extension, packed
from tests.editing.typing import ROOT, kept

MODULES = ROOT / ".venv" / "npm" / "node_modules"
ENGINE = """
const fs = require("fs"), path = require("path");
const [modules, given] = process.argv.slice(2);
const { Registry, parseRawGrammar, INITIAL } = require(path.join(modules, "vscode-textmate"));
const oniguruma = require(path.join(modules, "vscode-oniguruma"));
const wasm = fs.readFileSync(path.join(modules, "vscode-oniguruma/release/onig.wasm"));
(async () => {
  await oniguruma.loadWASM(wasm.buffer.slice(wasm.byteOffset, wasm.byteOffset + wasm.length));
  const asked = JSON.parse(fs.readFileSync(given, "utf8"));
  const registry = new Registry({
    onigLib: Promise.resolve({
      createOnigScanner: (sources) => new oniguruma.OnigScanner(sources),
      createOnigString: (text) => new oniguruma.OnigString(text),
    }),
    loadGrammar: async (scope) => parseRawGrammar(JSON.stringify(asked.grammars[scope]), "x.json"),
  });
  const answers = [];
  for (const { scope, text } of asked.texts) {
    const grammar = await registry.loadGrammar(scope);
    let state = INITIAL;
    answers.push(text.split(/\\r?\\n/).map((line) => {
      const done = grammar.tokenizeLine(line, state);
      state = done.ruleStack;
      return done.tokens.map((one) => [
        line.slice(one.startIndex, one.endIndex), one.scopes[one.scopes.length - 1],
      ]);
    }));
  }
  process.stdout.write(JSON.stringify(answers));
})();
"""


def held():
    with zipfile.ZipFile(io.BytesIO(packed("1.2.3"))) as archive:
        return {name: archive.read(name) for name in archive.namelist()}


def test_the_file_has_what_its_manifests_name():
    files = held()
    manifest = ElementTree.fromstring(files["extension.vsixmanifest"])
    assets = [one.get("Path") for one in manifest.iter(f"{{{FORMAT}}}Asset")]
    assert assets and set(assets) <= files.keys()
    identity = next(manifest.iter(f"{{{FORMAT}}}Identity"))
    package = json.loads(files["extension/package.json"])
    assert identity.get("Version") == package["version"] == "1.2.3"
    assert (
        identity.get("Id") == package["name"] and identity.get("Publisher") == package["publisher"]
    )
    named = [package["main"]]
    named += [one["configuration"] for one in package["contributes"]["languages"]]
    named += [one["path"] for one in package["contributes"]["grammars"]]
    assert {f"extension/{name.removeprefix('./')}" for name in named} <= files.keys()
    types = files["[Content_Types].xml"].decode()
    assert all(
        f'Extension=".{name.rpartition(".")[2]}"' in types for name in files if name[0] != "["
    )


def test_the_same_version_gives_the_same_bytes():
    assert packed("1.2.3") == packed("1.2.3") != packed("1.2.4")
    assert json.loads(held()["extension/package.json"])["version"] == "1.2.3"


def test_every_language_is_there_with_its_suffixes():
    package = json.loads(extension("1.0.0")["package.json"])
    known = package["contributes"]["languages"]
    assert [one["id"] for one in known] == [*languages.names(), "pseudo"]
    suffixes = [suffix for one in known for suffix in one["extensions"]]
    assert len(suffixes) == len(set(suffixes))
    wanted = {suffix for name in languages.names() for suffix in languages.get(name).suffixes}
    assert set(suffixes) == wanted | {".pseudo"}


def test_what_debug_takes_can_be_written_in_a_launch_configuration():
    package = json.loads(extension("1.0.0")["package.json"])
    (debugger,) = package["contributes"]["debuggers"]
    attributes = debugger["configurationAttributes"]["launch"]
    assert set(attributes["properties"]) == set(LAUNCH_KEYS)
    kinds = {"string": str, "integer": int, "boolean": bool}
    for name, said in attributes["properties"].items():
        assert kinds[said["type"]] is LAUNCH_KEYS[name]


def test_no_folder_says_which_command_is_run():
    package = json.loads(extension("1.0.0")["package.json"])
    (setting,) = package["contributes"]["configuration"]["properties"].items()
    assert setting[0] == "robotAssistant.command" and setting[1]["scope"] == "machine"
    text = extension("1.0.0")["client.js"]
    assert "robot-assistant.translation" in text
    entry = ROOT / "assistant" / "editing" / "vscode" / "client" / "entry.js"
    commands = set(re.findall(r'"(robotAssistant\.\w+)"', entry.read_text("utf-8")))
    assert commands == {one["command"] for one in package["contributes"]["commands"]}


def coloured(tmp_path, texts):
    """Words and scopes of each line, by the engine that VS Code has for them."""
    node = shutil.which("node")
    if node is None or not (MODULES / "vscode-textmate").is_dir():
        pytest.skip("needs node, and `make vscode` for the engine: grammars of 5 languages untried")
    files = extension("1.0.0")
    grammars = {
        f"source.{id}": json.loads(files[f"syntaxes/{id}.json"])
        for id in (*languages.names(), "pseudo")
    }
    given = tmp_path / "given.json"
    given.write_text(
        json.dumps({"grammars": grammars, "texts": [{"scope": s, "text": t} for s, t in texts]})
    )
    script = tmp_path / "engine.js"
    script.write_text(ENGINE)
    done = subprocess.run(
        [node, str(script), str(MODULES), str(given)], capture_output=True, text=True, check=True
    )
    return json.loads(done.stdout)


LINES = [
    ("rapid", "  MoveL p1,v100,fine,tool0; ! to it", "MoveL", "support.function.instruction"),
    ("rapid", "  MoveL p1,v100,fine,tool0; ! to it", "! to it", "comment.line"),
    ("rapid", "  CONST robtarget p1:=[1.5];", "robtarget", "storage.type"),
    ("rapid", "  CONST robtarget p1:=[1.5];", "CONST", "keyword.control"),
    ("rapid", "  CONST robtarget p1:=[1.5];", "1.5", "constant.numeric"),
    ("rapid", '  TPWrite "! no comment";', '"! no comment"', "string.quoted.double"),
    ("rapid", "  n:=Offs(p1,0,0,1).trans.x;", "Offs", "support.function"),
    ("melfa-basic-5", "10 Mov P1,-50 ' there", "Mov", "support.function.instruction"),
    ("melfa-basic-5", "10 Mov P1,-50 ' there", "' there", "comment.line"),
    ("melfa-basic-5", "10 GoSub *PICK", "*PICK", "entity.name.label"),
    ("melfa-basic-5", "20 M_Out(1)=1", "M_Out", "variable.language"),
    ("melfa-basic-4", "20 DEF INTE M1", "DEF", "keyword.control"),
    ("pseudo", "  wait 0.5 s # rest", "wait", "support.function.instruction"),
    ("pseudo", "  wait 0.5 s # rest", "# rest", "comment.line"),
    ("pseudo", "  wait 0.5 s # rest", "0.5", "constant.numeric"),
]


@pytest.mark.slow
def test_words_have_the_colours_that_are_meant(tmp_path):
    answers = coloured(tmp_path, [(f"source.{id}", line) for id, line, _, _ in LINES])
    for (id, line, word, scope), (words,) in zip(LINES, answers, strict=True):
        assert [word, f"{scope}.{id}"] in words, (line, words)


@pytest.mark.slow
def test_colours_agree_with_what_the_service_says(tmp_path, tell):
    """Comments and texts of all samples are the same words for the grammar and for our scanner."""
    from assistant.editing import service

    texts = {name: text for name, text in kept().items() if "%%%" not in text}
    documents = [service.Workspace().open(f"/nowhere/{name}", text) for name, text in texts.items()]
    answers = coloured(tmp_path, [(f"source.{one.language}", one.text) for one in documents])
    compared = 0
    for document, lines in zip(documents, answers, strict=True):
        for number, words in enumerate(lines):
            theirs = {
                (word.strip(), scope.split(".")[0])
                for word, scope in words
                if scope.startswith(("comment", "string"))
            }
            ours = {
                (word.text.strip(), word.kind)
                for word in document.facts[number].words
                if word.kind in ("comment", "string")
            }
            assert theirs == ours, (document.path, number, document.lines.line(number))
            compared += len(ours)
    tell(
        f"{compared} comments and texts of {len(texts)} files: VS Code's engine sees them as we do"
    )


def test_the_command_writes_the_file(tmp_path):
    from assistant import __version__
    from assistant.cli.services import run_extension

    assert run_extension(tmp_path / "here.vsix") == 0
    assert Path(tmp_path / "here.vsix").read_bytes() == packed(__version__)
