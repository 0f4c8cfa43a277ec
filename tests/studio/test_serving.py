"""The studio is served to whoever knows its address, and to nobody else."""

from __future__ import annotations

from collections.abc import Mapping
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from urllib.parse import urlsplit
from urllib.request import Request

import pytest

from assistant.studio.studio import Windows
from tests.cli.test_commands import run
from tests.studio.serving import Page, answered


def test_a_page_is_there_and_asks_for_nothing_from_outside(address: str) -> None:
    got = answered(Request(address))
    assert got.status == 200
    assert "<title>Studio</title>" in got.value
    assert "http:" not in got.value
    assert "https:" not in got.value


def test_who_does_not_know_the_address_is_refused(address: str) -> None:
    parts = urlsplit(address)
    origin = f"{parts.scheme}://{parts.netloc}"
    token = parts.path.strip("/")
    for wrong in ("/", "/project", f"/{token[:-1]}/project", f"/{token}x/", f"/{token}"):
        assert answered(Request(origin + wrong)).status == 403
    elsewhere = Request(address + "project", headers={"Origin": "http://elsewhere.example"})
    assert answered(elsewhere).status == 403
    named = Request(address + "project", headers={"Host": "elsewhere.example"})
    assert answered(named).status == 403
    crossing = Request(address + "project", headers={"Sec-Fetch-Site": "cross-site"})
    assert answered(crossing).status == 403
    posted = Request(address + "project/create", data=b"{}")  # says of no page that it is from
    assert answered(posted).status == 403


def test_only_the_window_that_writes_changes_something(page: Page, folder: Path) -> None:
    second = Page(page.address)
    with second.line():
        assert second.window != page.window
        refused = second.post("project/create", empty=True)
        assert refused.value["findings"][0]["code"] == "ST010"
        assert list(folder.iterdir()) == []
        assert page.post("project/create", empty=True).status == 200
    assert (folder / "assistant.toml").is_file()


def test_what_a_window_had_is_let_go_before_another_one_writes() -> None:
    windows, told = Windows(), list[Mapping[str, object]]()
    first, second = windows.opened(told.append), windows.opened(told.append)
    told.clear()
    with ThreadPoolExecutor(1) as other:
        asked = []

        def over(wrote: bool) -> None:
            asked.append(other.submit(windows.writes, second))
            with pytest.raises(TimeoutError):
                asked[0].result(0.1)
            assert wrote and told == []

        windows.closed(first, over)
        assert asked[0].result() is True
    assert told == [{"kind": "window", "name": second, "writes": True}]


def test_what_is_asked_wrongly_is_told(page: Page) -> None:
    asked = page.post("project/open")
    assert (asked.status, asked.value["findings"][0]["code"]) == (422, "ST011")
    nowhere = page.post("project/open", folder="/nowhere/at/all")
    assert nowhere.value["findings"][0]["code"] == "ST003"


def test_a_place_that_is_not_ours_is_not_served(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    before = Path.cwd()
    status, _, told = run(capsys, "studio", tmp_path, "--no-open", "--host", "203.0.113.7")
    assert Path.cwd() == before
    assert status == 2
    assert "ST002" in told
