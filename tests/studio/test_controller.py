"""What the studio does with a controller of the project: deploying, looking, setting, backups."""

from __future__ import annotations

import json
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import pytest
from websockets.sync.client import ClientConnection

from assistant.virtual.cr import VirtualCr
from tests.studio.cells import BENCHES, PASSWORD, Bench
from tests.studio.serving import Answer, Page


@pytest.fixture(params=sorted(BENCHES))
def bench(request: pytest.FixtureRequest, folder: Path, tmp_path: Path) -> Iterator[Bench]:
    with BENCHES[request.param](folder, tmp_path / "home") as made:
        yield made


def codes(answer: Answer) -> list[str]:
    return [finding["code"] for finding in answer.value["findings"]]


def done(answer: Answer) -> Any:
    assert answer.status == 200, answer.value
    return answer.value


def heard(line: ClientConnection, kind: str) -> Any:
    """The next message of a kind."""
    while True:
        message = json.loads(line.recv(20.0))
        if message["kind"] == kind:
            return message


def connect(page: Page) -> Any:
    return done(page.post("controller/connect", name="cell1", password=PASSWORD))


def test_deployed_changed_there_seen_and_taken_back(bench: Bench, page: Page) -> None:
    connect(page)
    assert done(page.post("project/build"))["ok"]
    compared = done(page.post("controller/plan"))
    (plan,) = compared["targets"]
    assert [(one["name"], one["change"]) for one in plan["files"]] == [(bench.name, "create")]
    assert bench.read() == ""
    assert codes(page.post("controller/deploy")) == ["ST048"]  # nobody has looked
    (deployed,) = done(page.post("controller/deploy", plan=compared["plan"]))["targets"]
    assert [one["state"] for one in deployed["files"]] == ["installed"]
    assert "400" in bench.read()
    assert done(page.post("controller/verify"))["ok"]
    bench.change(bench.text.format(555))
    seen = done(page.post("controller/verify"))
    assert not seen["ok"] and "555" in seen["targets"][0]["programs"][0]["since"]
    refused = page.post("controller/rollback")
    assert codes(refused) and "555" in bench.read()
    back = done(page.post("controller/rollback", replace=["*"]))
    assert back["ok"] and bench.read() == ""


def test_only_what_was_shown_is_deployed(folder: Path, tmp_path: Path, page: Page) -> None:
    with BENCHES["cr"](folder, tmp_path / "home") as bench:
        connect(page)
        done(page.post("project/build"))
        shown = done(page.post("controller/plan"))["plan"]
        bench.change(bench.text.format(555))
        asked = {"plan": shown, "replace": ["*"]}
        assert codes(page.post("controller/deploy", **asked)) == ["ST048"]
        assert "555" in bench.read()
        shown = done(page.post("controller/plan"))["plan"]
        (folder / bench.file).write_text(bench.text.format(410), encoding="utf-8")
        done(page.post("project/build"))
        asked = {"plan": shown, "replace": ["*"]}
        assert codes(page.post("controller/deploy", **asked)) == ["ST048"]
        assert "555" in bench.read()
        shown = done(page.post("controller/plan"))["plan"]
        asked = {"plan": shown, "replace": ["*"]}
        assert done(page.post("controller/deploy", **asked))["ok"] and "410" in bench.read()
        assert codes(page.post("controller/deploy", **asked)) == ["ST048"]  # a second click


def test_of_two_connections_at_once_one_is_left(folder: Path, address: str) -> None:
    page = Page(address)
    (folder / "assistant.toml").write_text('[controllers]\ntrial = "virtual:cr"\n', "utf-8")
    with ThreadPoolExecutor(2) as both, page.line() as line:
        while not page.writes:
            page.hear(line)
        for answer in both.map(lambda _: page.post("controller/connect", name="trial"), "12"):
            done(answer)
        heard(line, "monitor")
        done(page.post("controller/leave"))
        with pytest.raises(TimeoutError):  # another one would go on telling
            for _ in range(20):
                line.recv(1.0)


def test_a_password_is_asked_for_and_kept_nowhere(folder: Path, tmp_path: Path, page: Page) -> None:
    with BENCHES["irc5"](folder, tmp_path / "home"):
        assert codes(page.post("controller/connect", name="cell1")) == ["CN112"]
        refused = page.post("controller/connect", name="cell1", password="another one")
        assert refused.status == 422 and "another one" not in json.dumps(refused.value)
        assert not done(page.get("controller"))["connected"]
        assert PASSWORD not in json.dumps(connect(page))
        assert PASSWORD not in json.dumps(done(page.get("controller")))
    for file in folder.rglob("*"):
        assert file.is_dir() or PASSWORD.encode() not in file.read_bytes()


def test_what_is_seen_there_is_told_to_every_window(bench: Bench, address: str) -> None:
    page, other = Page(address), Page(address)
    with page.line() as line, other.line() as looking:
        page.hear(line)
        connect(page)
        for one in (line, looking):
            sample = heard(one, "monitor")
            assert sample["state"]["running"] is False
            assert len(sample["position"]["joints"]) == 6
        assert page.post("controller/watch", signals=["no such signal"]).status == 422
        assert codes(other.post("controller/watch", signals=[])) == ["ST010"]


def test_parameters_are_set_by_who_types_the_name(folder: Path, tmp_path: Path, page: Page) -> None:
    with BENCHES["cr"](folder, tmp_path / "home"):
        connect(page)
        asked = {"name": "HANDINIT", "value": "1,0,1,0,1,0,1,1"}
        before = done(page.post("controller/parameters", names=["HANDINIT"]))["parameters"]
        assert codes(page.post("controller/parameter", **asked)) == ["ST041"]
        assert codes(page.post("controller/parameter", **asked, word="cell2")) == ["ST042"]
        assert done(page.post("controller/parameters", names=["HANDINIT"]))["parameters"] == before
        changed = done(page.post("controller/parameter", **asked, word="cell1"))
        assert changed["parameters"] != before


def test_a_backup_is_brought_back_by_who_types_the_name(
    folder: Path, tmp_path: Path, page: Page
) -> None:
    with BENCHES["cr"](folder, tmp_path / "home") as bench:
        connect(page)
        bench.change(bench.text.format(410))
        kept = done(page.post("controller/backup", folder="backups/first"))
        assert kept["files"] > 0 and (folder / "backups/first").is_dir()
        assert codes(page.post("controller/backup", folder="backups/first")) == ["ST045"]
        assert done(page.get("controller/backups"))["folders"] == ["backups/first"]
        bench.change(bench.text.format(420))
        asked = {"folder": "backups/first"}
        assert any(
            "420" in one
            for one in done(page.post("controller/restore", **asked))["changes"].values()
        )
        assert codes(page.post("controller/restore", **asked, apply=True)) == ["ST041"]
        assert "420" in bench.read()
        assert done(page.post("controller/restore", **asked, apply=True, word="cell1"))["restored"]
        assert "410" in bench.read()


def test_errors_have_their_text_and_are_acknowledged(
    folder: Path, tmp_path: Path, page: Page
) -> None:
    with BENCHES["cr"](folder, tmp_path / "home") as bench:
        assert isinstance(bench.cell, VirtualCr)
        bench.cell.alarm(2000)
        connect(page)
        first = done(page.get("controller/log"))["log"][0]
        assert first["number"] == 2000 and first["text"] and first["cure"]
        done(page.post("controller/acknowledge"))


def test_whoever_is_not_connected_is_told(page: Page, folder: Path) -> None:
    assert codes(page.get("controller/log")) == ["ST040"]
    assert codes(page.post("control/stop")) == ["ST040"]
    assert codes(page.post("controller/connect", name="melfa://127.0.0.1:1")) == ["CN104"]


def test_virtual_controllers_of_the_project_run_while_they_are_connected_to(
    folder: Path, page: Page
) -> None:
    table = '[controllers]\ntrial = "virtual:cr"\nother = "virtual:irc5"\n'
    (folder / "assistant.toml").write_text(table, encoding="utf-8")
    for name in ("trial", "other", "trial"):
        found = done(page.post("controller/connect", name=name))
        assert (found["name"], found["virtual"], found["operates"]) == (name, True, True)
        assert done(page.post("control/stop"))["stands"]
        done(page.post("control/take", word=name))
        done(page.post("control/motors", on=True))
    done(page.post("controller/leave"))
    assert codes(page.post("controller/plan")) == ["ST040"]
