"""Programs run in the studio as `run` runs them: held, stepped, switched by hand, compared."""

from __future__ import annotations

import shutil
import time
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, Final

import numpy as np
import pytest

from assistant.studio.route_answers import Question
from assistant.studio.run_routes import RUN_NAME, run_log, start_run
from assistant.studio.studio import Studio
from tests.cli.test_commands import SAMPLES, run
from tests.studio.browsing import clean, studio_page, until
from tests.studio.serving import Page

ARM: Final = "irb1200-7-0.7"
PLACE: Final = "[0,0,1,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]"
LINES: Final = """MODULE lines
  CONST robtarget p1:=[[400,0,400],{place}];
  CONST robtarget p2:=[[400,{y},400],{place}];
  VAR num n:=0;
  PROC main()
    MoveJ p1,v1000,fine,tool0;
    n:=n+1;
    WaitDI diGo,1;
    MoveL p2,v200,fine,tool0;
    Turn;
    SetDO doDone,1;
  ENDPROC
  PROC Turn()
    n:=n+10;
    MoveL RelTool(p2,0,0,0\\Rz:=30),v200,fine,tool0;
  ENDPROC
ENDMODULE
"""
PSEUDO: Final = """program waiting

signal part digital input 9

target high [400, 0, 400] [0, 0, 1, 0]

procedure main
  move joint high speed 200 mm/s blend fine
  wait for part = 1
end
"""


def written(folder: Path, name: str = "lines.mod", y: float = 100.0) -> str:
    (folder / name).write_text(LINES.format(place=PLACE, y=y), encoding="utf-8")
    return name


def module(folder: Path, *body: str) -> str:
    lines = "\n".join(body)
    (folder / "own.mod").write_text(
        f"MODULE own\nPROC main()\n{lines}\nENDPROC\nENDMODULE\n", encoding="utf-8"
    )
    return "own.mod"


def stands(page: Page, fits: Callable[[Any], bool]) -> Any:
    """How the run stands, once it does as is said."""
    now = page.get("run").value
    for _ in range(600):
        if fits(now):
            return now
        time.sleep(0.02)
        now = page.get("run").value
    raise AssertionError(now)


def ended(page: Page) -> Any:
    return stands(page, lambda now: now["state"] == "ended")


def variables(now: Any) -> dict[str, str]:
    return {row["name"]: row["value"] for group in now["data"] for row in group["rows"]}


def test_it_is_held_at_a_break_point_and_goes_on_by_steps(page: Page, folder: Path) -> None:
    path = written(folder)
    asked = page.post("run/start", path=path, robot=ARM, points={path: [8]})
    assert asked.status == 200
    now = stands(page, lambda now: now["state"] == "held")
    assert (now["path"], now["line"], now["reason"]) == (path, 8, "breakpoint")
    assert variables(now)["n"] == "1"
    assert page.post("run/signal", name="diGo", value=1).value["state"] == "held"
    assert page.post("run/go", how="step").value["line"] == 9
    assert page.post("run/go", how="step").value["line"] == 10
    inside = page.post("run/go", how="step").value
    assert (inside["line"], [one["name"] for one in inside["stack"]]) == (14, ["Turn", "main"])
    out = page.post("run/go", how="out").value
    assert (out["line"], variables(out)["n"]) == (11, "11")
    assert page.post("run/go", how="over").value["state"] == "ended"
    done = ended(page)
    assert (done["ended"], done["findings"]) == ("end", [])
    assert {"name": "dodone", "value": 1.0} in done["outputs"]
    rows = page.get("run/log").value["rows"]
    assert [row["line"] for row in rows] == [6, None, 9, 15, 11]
    assert page.post("run/go").value["findings"][0]["code"] == "ST061"


def test_an_input_that_is_switched_by_hand_lets_it_go_on(page: Page, folder: Path) -> None:
    path = written(folder)
    page.post("run/start", path=path, robot=ARM)
    now = stands(page, lambda now: now["state"] == "waits")
    assert (now["line"], now["inputs"]) == (8, [{"name": "digo", "value": 0.0}])
    page.post("run/signal", name="other", value=1)
    assert page.get("run").value["state"] == "waits"
    page.post("run/signal", name="digo", value=1)
    assert ended(page)["ended"] == "end"

    shutil.copy(SAMPLES / "melfa" / "PALLET.prg", folder)
    page.post("run/start", path="PALLET.prg", robot="rv-2fr")
    first = stands(page, lambda now: now["state"] == "waits")
    assert first["inputs"] == [{"name": "8", "value": 0.0}]
    page.post("run/signal", name="8", value=1)
    done = ended(page)
    assert (done["ended"], done["logged"] > first["logged"]) == ("end", True)

    (folder / "wait.pseudo").write_text(PSEUDO, encoding="utf-8")
    asked = page.post("run/start", path="wait.pseudo", robot=ARM)
    assert asked.status == 200, asked.value
    assert stands(page, lambda now: now["state"] == "waits")["line"] == 9
    page.post("run/signal", name="part", value=1)
    assert ended(page)["ended"] == "end"


def test_plots_have_the_columns_of_a_trace(
    page: Page, folder: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    for name in ("pick_and_place.mod", "pick_and_place.signals.toml"):
        shutil.copy(SAMPLES / "rapid" / name, folder)
    script = "pick_and_place.signals.toml"
    choices = page.get("run/choices", path="pick_and_place.mod").value
    assert ARM in choices["robots"]
    assert choices["scripts"] == [script]
    page.post("run/start", path="pick_and_place.mod", robot=ARM, script=script)
    assert ended(page)["ended"] == "end"
    shown = page.get("run/motion", points="300").value
    monkeypatch.chdir(folder)
    traced = folder / "trace.npz"
    run(capsys, "run", "pick_and_place.mod", "-r", ARM, "--signals", script, "--trace", traced)
    with np.load(traced) as columns:
        assert shown["samples"] == len(columns["t"])
        some = np.flatnonzero(np.isin(columns["t"], shown["t"]))
        assert len(some) == 300
        for name in ("t", "position", "quaternion", "joints", "speed", "inputs", "outputs"):
            np.testing.assert_array_equal(columns[name][some], shown[name])
    turned = np.diff(shown["orientation"], axis=0)
    assert np.abs(turned).max() < 90.0


def test_two_programs_are_compared_by_their_motion(page: Page, folder: Path) -> None:
    first, second = written(folder), written(folder, "moved.mod", 103.0)

    (folder / "go.signals.toml").write_text('[[set]]\ninput = "diGo"\n', encoding="utf-8")
    chosen = {"robot": ARM, "script": "go.signals.toml"}
    same = page.post("run/compare", first=first, second=first, **chosen).value
    assert (same["answer"], same["deviation"]["distance"]) == ("equal", 0.0)
    assert not [one for one in same["findings"] if one["severity"] == "error"]
    done = page.post("run/compare", first=first, second=second, **chosen).value
    far = done["deviation"]
    assert far["distance"] == pytest.approx(3.0, abs=1e-6)
    assert far["angle"] < 1.0  # as much as the arm turns between two samples
    told = [one for one in done["findings"] if one["severity"] == "error"]
    assert done["answer"] == "different"
    assert {one["code"] for one in told} == {"CO118"}
    assert (second, 9) in [(one["path"], one["line"]) for one in told]
    assert ": different" in done["line"]
    beside = page.get("run/compared")
    assert beside.status == 200 and f"{first} and {second}: different" in beside.value
    assert done["seconds"][1] > done["seconds"][0]


def test_what_goes_wrong_is_told_and_can_be_ended(page: Page, folder: Path) -> None:
    endless = module(folder, "WHILE TRUE DO", "ENDWHILE")
    page.post("run/start", path=endless)
    assert page.post("run/pause").status == 200
    assert stands(page, lambda now: now["state"] == "held")["reason"] == "pause"
    assert page.post("run/end").value["ended"] == "until"

    page.post("run/start", path=module(folder, "VAR num a;", "a:=1/a;"))
    found = ended(page)["findings"]
    assert [one["code"] for one in found] == ["VC211", "ST064"]
    assert (found[0]["path"], found[0]["line"]) == ("own.mod", 4)

    page.post("run/start", path=module(folder, "VAR num a;", 'TPReadNum a,"how many?";', "Stop;"))
    assert stands(page, lambda now: now["state"] == "asks")["question"] == "how many?"
    assert page.post("run/go").value["findings"][0]["code"] == "ST061"
    page.post("run/answer", text="3")
    assert stands(page, lambda now: now["state"] != "asks")["ended"] == "end"
    assert page.post("run/answer", text="3").value["findings"][0]["code"] == "ST062"

    wrong = page.post("run/start", path=module(folder, "MoveJ"))
    assert wrong.status == 422
    assert wrong.value["findings"][0]["line"] == 3
    assert page.get("run/log").value["findings"][0]["code"] == "ST060"
    assert page.post("run/start", path="gone.mod").value["findings"][0]["code"] == "ST026"
    assert page.post("run/start", path="../x.mod").value["findings"][0]["code"] == "ST023"


def test_a_run_keeps_step_with_real_time_and_is_held_on_its_way(page: Page, folder: Path) -> None:
    path = module(folder, "WaitTime 0.1;", "WaitDI diGo,1\\MaxTime:=60;")
    begun = time.monotonic()
    page.post("run/start", path=path, robot=ARM, real_time=True)
    stands(page, lambda now: now["state"] == "waits")
    page.post("run/pause")
    held = stands(page, lambda now: now["state"] == "held")
    page.post("run/go")
    page.post("run/signal", name="digo", value=1)
    done = ended(page)
    assert done["ended"] == "end"
    assert held["time"] <= done["time"] < time.monotonic() - begun + 0.1


def test_a_run_ends_with_its_window_and_no_other_window_starts_one(
    address: str, folder: Path
) -> None:
    path = written(folder)
    first, second = Page(address), Page(address)
    with first.line() as line:
        while not first.writes:
            first.hear(line)
        with second.line() as other:
            refused = second.post("run/start", path=path)
            assert refused.value["findings"][0]["code"] == "ST010"
            first.post("run/start", path=path, robot=ARM)
            assert stands(second, lambda now: now["state"] == "waits")["line"] == 8
            line.close()
            while not second.writes:
                second.hear(other)
            stands(second, lambda now: now["state"] == "")


@pytest.mark.slow
def test_in_a_browser(browser: Any, address: str, folder: Path) -> None:
    path = written(folder)
    with studio_page(browser, address) as page, clean(page):
        page.get_by_role("treeitem", name=path).click()
        page.wait_for_selector(".cm-line")
        page.click("#tab-run")
        until(page, "document.getElementById('run-robot').options.length > 5")
        page.select_option("#run-robot", ARM)
        page.locator(".cm-line").nth(8).click()
        page.keyboard.press("F9")
        page.keyboard.press("F8")
        page.wait_for_selector("[data-input=digo]:not(:disabled)")
        page.click("[data-input=digo]")
        page.wait_for_selector(".arm-here:has-text('MoveL p2')")
        page.click("#run-data-part summary")
        assert "n" in page.inner_text("#run-data")
        page.click("#run-over")
        page.wait_for_selector(".arm-here:has-text('Turn;')")
        end = "Number(document.getElementById('run-time').max)"
        held = page.evaluate(end)
        page.click("#run-go:not(:disabled)")
        until(page, "document.getElementById('run-state').textContent.startsWith('ended')")
        until(page, f"{end} > {held}")  # the motion to its end has come
        page.wait_for_selector("#plot-joints path.curve-5")
        frame = "document.querySelector('#scene iframe')?.contentDocument"
        until(page, f"{frame}?.querySelector('body.led #clock')?.textContent === '–'")
        assert page.locator("#run-plots figure").count() == 5
        page.focus("#run-time")
        page.keyboard.press("Home")
        page.wait_for_selector(".arm-here:has-text('MoveJ p1')")
        assert page.inner_text("#run-at") == "0.00 s"
        page.select_option("#compare-with", path)
        page.click("#compare-form button")
        page.wait_for_selector("#compare-result strong:has-text('Equal')")
        with page.context.expect_page() as opened:
            page.click("#compare-page")
        opened.value.wait_for_selector("text=lines.mod and lines.mod: equal")


def test_a_visit_that_nothing_names_is_told(page: Page, folder: Path) -> None:
    visit = '[[set]]\ninput = "diGo"\nwhen = "visit 1 of {}"\n'
    (folder / "go.signals.toml").write_text(visit.format("p9"), encoding="utf-8")
    page.post("run/start", path=written(folder), script="go.signals.toml")
    waits = stands(page, lambda now: now["state"] == "waits")
    assert "CO126" in [one["code"] for one in waits["findings"]]
    (folder / "go.signals.toml").write_text(visit.format("p1"), encoding="utf-8")
    page.post("run/start", path=written(folder), script="go.signals.toml")
    assert "CO126" not in [one["code"] for one in ended(page)["findings"]]


def test_what_a_run_did_is_there_when_its_end_is_told(
    folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(folder)
    studio = Studio(folder)
    told: list[tuple[str, int]] = []

    def window(message: Mapping[str, object]) -> None:
        if message["kind"] == "run":
            rows = run_log(studio, Question({}))["rows"] if RUN_NAME in studio.live else []
            told.append((str(message["state"]), len(rows)))

    name = studio.windows.opened(window)
    path = module(folder, 'TPWrite "one";', 'TPWrite "two";')
    start_run(
        studio, Question({"path": path, "robot": "", "script": "", "points": {}}, window=name)
    )
    until_told(told)
    assert told[-1] == ("ended", 2)
    studio.drop(RUN_NAME)


def until_told(told: list[tuple[str, int]]) -> None:
    for _ in range(600):
        if told and told[-1][0] == "ended":
            return
        time.sleep(0.02)
