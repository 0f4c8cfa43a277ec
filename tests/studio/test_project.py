"""A project in the studio: its files, what is dropped onto it, and how a drawing is worked."""

from __future__ import annotations

import contextlib
import json
import os
import time
import tomllib
from pathlib import Path
from typing import Any

import ezdxf
import pytest

from tests.cli.tables import each
from tests.cli.test_commands import SAMPLES, run
from tests.studio.browsing import clean, studio_page, until
from tests.studio.serving import Answer, Page

ARM = "irb1200-7-0.7"
PLATE = (SAMPLES / "plate.dxf").read_bytes()
SEAM = b"MODULE seam\n  PROC main()\n    WaitTime 1;\n  ENDPROC\nENDMODULE\n"
PLACED = {
    "tools": {"tool": {"tip": [0, 0, 120]}},
    "frames": {"work": {"position": [150, 0, 100], "euler_zyx": [0, 0, 0]}},
}
"""What the plate lacks to be worked by the arm of the example."""


def codes(answer: Answer) -> list[str]:
    return [finding["code"] for finding in answer.value["findings"]]


def files(page: Page) -> dict[str, str]:
    return {one["path"]: one["kind"] for one in page.get("project").value["files"]}


def settings(file: Path) -> dict[str, Any]:
    return tomllib.loads(file.read_text(encoding="utf-8"))


def dropped(page: Page) -> str:
    """The plate, in the project."""
    answer = page.send("project/drop", PLATE, name="plate.dxf")
    assert answer.status == 200
    path: str = answer.value["path"]
    return path


def layer(answer: Answer, name: str) -> dict[str, Any]:
    return next(one for one in answer.value["layers"] if one["name"] == name)


def test_a_project_begins_empty_or_with_an_example(page: Page, folder: Path) -> None:
    before = page.get("project").value
    assert (before["there"], before["files"], before["findings"]) == (False, [], [])
    assert page.post("project/create", empty=True).status == 200
    empty = page.get("project").value
    assert (empty["there"], empty["programs"]) == (True, [])
    assert [one["name"] for one in empty["controllers"]] == ["cell1"]
    own = (folder / "assistant.toml").read_bytes()
    page.post("project/create", empty=True)  # what is there is left as it is
    assert (folder / "assistant.toml").read_bytes() == own


def test_the_example_is_checked_and_built(page: Page, folder: Path) -> None:
    created = page.post("project/create").value
    assert "assistant.toml" in created["written"]
    assert page.post("project/check").value["programs"] == 1
    built = page.post("project/build").value
    assert built["ok"]
    assert all((folder / name).is_file() for one in built["programs"] for name in one["files"])


def test_tool_and_frame_of_a_process_have_the_names_of_its_file(page: Page, folder: Path) -> None:
    page.post("project/create")
    got = page.get("drawing", path="drawings/plate.dxf").value["values"]
    keys = {one["field"]: one for one in got}
    assert keys["tools.tool.tip"]["key"] == ["tools", "nozzle", "tip"]
    assert keys["tools.tool.tip"]["value"] == [0, 0, 80]
    assert keys["frames.work.position"]["value"] == [330, -50, 250]
    assert "frames.work.euler_zyx" not in keys  # the file has a quaternion
    values = {"tools": {"nozzle": {"tip": [0, 0, 90]}}}
    assert page.post("drawing/process", path="drawings/plate.dxf", values=values).status == 200
    text = (folder / "drawings" / "plate.process.toml").read_text(encoding="utf-8")
    assert "tip = [0, 0, 90]  " in text
    assert "# in the flange frame" in text


def test_a_drawing_that_is_dropped_has_its_process_and_its_place(page: Page, folder: Path) -> None:
    path = dropped(page)
    assert path == "drawings/plate.dxf"
    assert files(page) == {
        "assistant.schema.json": "settings",
        "assistant.toml": "project",
        "drawings/plate.dxf": "drawing",
        "drawings/plate.process.toml": "process",
    }
    stated = settings(folder / "assistant.toml")
    assert stated["programs"] == {"plate": {"source": path}}
    assert stated["targets"]["cell1"]["programs"] == ["plate"]
    seen = page.get("drawing", path=path)
    assert [one["name"] for one in seen.value["layers"]][:3] == ["GLUE", "CUT", "POSES"]
    assert {one["layer"] for one in seen.value["lines"]} == {"GLUE", "CUT"}
    assert codes(seen) == ["CT303", "CT303"]  # its blanks
    assert {one["path"] for one in seen.value["findings"]} == {"drawings/plate.process.toml"}


def test_a_process_is_written_as_by_hand(page: Page, folder: Path) -> None:
    path = dropped(page)
    file = folder / "drawings" / "plate.process.toml"
    before = file.read_text(encoding="utf-8").splitlines()
    wanted = {**PLACED, "layers": {"GLUE": {"speed": 80, "process": "gluing"}}}
    done = page.post("drawing/process", path=path, values=wanted)
    assert (done.status, codes(done)) == (200, [])
    assert layer(done, "GLUE")["values"]["speed"] == 80
    after = file.read_text(encoding="utf-8").splitlines()
    changed = [line for line, old in zip(after, before, strict=True) if line != old]
    assert [(one.partition("#")[0].rstrip(), one.index("#")) for one in changed] == [
        ("tip = [0, 0, 120]", 30),  # each in its place, with what is said of it there
        ("position = [150, 0, 100]", 30),
        ("speed = 80", 30),
        ('process = "gluing"', 30),
    ]
    assert page.post("project/build").value["ok"]


def test_layers_are_left_out_and_taken_back(page: Page, folder: Path) -> None:
    path = dropped(page)
    file = folder / "drawings" / "plate.process.toml"
    page.post("drawing/process", path=path, values=PLACED)
    out = page.post("drawing/process", path=path, values={"layers": {"CUT": {"used": False}}})
    assert not layer(out, "CUT")["used"]
    assert settings(file)["leave_out"] == ["NOTES", "CUT"]
    assert list(settings(file)["layers"]) == ["GLUE"]
    back = page.post("drawing/process", path=path, values={"layers": {"CUT": {"used": True}}})
    assert layer(back, "CUT")["used"]
    assert settings(file)["layers"]["CUT"] == {"speed": 50}


def test_single_contours_are_left_out_and_taken_back(page: Page, folder: Path) -> None:
    path = dropped(page)
    file = folder / "drawings" / "plate.process.toml"
    blank = page.get("drawing", path=path).value["contours"]
    assert blank and not any(one["numbers"] for one in blank)  # there is no program yet
    before = page.post("drawing/process", path=path, values=PLACED).value
    own = [one for one in before["lines"] if "contour" in one]
    assert [one["contour"] for one in own] == list(range(len(before["contours"])))
    assert [one["layer"] for one in own] == [one["layer"] for one in before["contours"]]
    numbers = sorted(n for one in before["contours"] for n in one["numbers"])
    assert numbers == list(range(1, len(numbers) + 1))

    def switched(one: dict[str, Any], used: bool) -> Answer:
        chosen = {"layer": one["layer"], "at": one["at"], "used": used}
        return page.post("drawing/process", path=path, values={"contours": [chosen]})

    first = next(one for one in before["contours"] if one["layer"] == "CUT")
    out = switched(first, False)
    now = {tuple(one["at"]): one for one in out.value["contours"]}
    assert (now[tuple(first["at"])]["left"], now[tuple(first["at"])]["numbers"]) == (True, [])
    assert sum(one["left"] for one in now.values()) == 1
    entry = {"layer": "CUT", "at": first["at"]}
    assert settings(file)["leave_out"] == ["NOTES", entry]
    assert switched(first, True).value["contours"] == before["contours"]
    assert settings(file)["leave_out"] == ["NOTES"]
    text = file.read_text("utf-8")
    assert switched({"layer": "CUT", "at": [1, 2]}, False).status == 422
    assert switched({"layer": "CUT", "at": "x"}, False).status == 422
    assert file.read_text("utf-8") == text


def test_one_contour_of_a_group_is_taken_back(page: Page, folder: Path) -> None:
    path = dropped(page)
    file = folder / "drawings" / "plate.process.toml"
    page.post("drawing/process", path=path, values=PLACED)
    text = file.read_text("utf-8").replace('leave_out = ["NOTES"]', "leave_out = [{group = 1}]")
    file.write_text(text, "utf-8")
    left = [one for one in page.get("drawing", path=path).value["contours"] if one["left"]]
    chosen = {"layer": left[0]["layer"], "at": left[0]["at"], "used": True}
    page.post("drawing/process", path=path, values={"contours": [chosen]})
    others = [{"layer": one["layer"], "at": one["at"]} for one in left[1:]]
    assert settings(file)["leave_out"] == others


def test_other_views_of_a_part_are_listed_by_their_size(page: Page, folder: Path) -> None:
    document = ezdxf.new(units=4)
    for low, high in ((0, 100), (150, 155)):
        corners = [(0, low), (200, low), (200, high), (0, high)]
        document.modelspace().add_lwpolyline(corners, close=True)
    document.modelspace().add_circle((50, 50), 5)
    document.saveas(folder / "part.dxf")
    views = page.get("drawing", path="part.dxf").value["views"]
    assert [(one["size"], len(one["contours"])) for one in views] == [
        ([200, 100], 2),
        ([200, 5], 1),
    ]


def test_outputs_and_leads_are_written(page: Page, folder: Path) -> None:
    path = dropped(page)
    file = folder / "drawings" / "plate.process.toml"
    layer_values = {"on": {"laser": 1}, "off": {"laser": 0}, "lead_in": {"arc": 2, "angle": 60}}
    laser = {"kind": "digital", "direction": "output", "number": 3}
    values = {**PLACED, "layers": {"CUT": layer_values}, "signals": {"laser": laser}}
    done = page.post("drawing/process", path=path, values=values)
    assert done.status == 200, done.value
    assert layer(done, "CUT")["values"].items() >= layer_values.items()
    assert done.value["signals"] == [{"name": "laser", "number": 3}]
    assert settings(file)["signals"] == {"laser": laser}


def test_a_place_in_reach_is_proposed_while_there_is_none(page: Page) -> None:
    path = dropped(page)

    def place() -> dict[str, Any]:
        values = page.get("drawing", path=path).value["values"]
        return next(one for one in values if one["field"] == "frames.work.position")

    proposed = place()["proposed"]["frames.work.position"]
    assert len(proposed) == 3 and place()["robot"]
    placed = {**PLACED, "frames": {"work": {"position": proposed}}}
    page.post("drawing/process", path=path, values=placed)
    assert "proposed" not in place()
    shown = page.post("scene/show", path=path).value
    assert shown["moves"] and not {one["severity"] for one in shown["findings"]} & {"error"}


@pytest.mark.parametrize(
    ("size", "robot"), (((700, 200), ARM), ((700, 200), None), ((2000, 1000), None))
)
def test_the_proposal_is_that_of_a_new_project(
    page: Page,
    folder: Path,
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
    size: tuple[int, int],
    robot: str | None,
) -> None:
    document = ezdxf.new(units=4)
    x, y = size
    document.modelspace().add_lwpolyline([(0, 0), (x, 0), (x, y), (0, y)], close=True)
    document.saveas(tmp_path / "part.dxf")
    begun = tmp_path / "begun"
    named = ("--robot", robot) if robot else ()
    run(capsys, "init", begun, tmp_path / "part.dxf", "--yes", *named)
    frame = settings(begun / "drawings" / "part.process.toml")["frames"]["work"]
    arm = settings(begun / "assistant.toml")["controllers"]["cell1"]["robot"]

    cell = f'[controllers.cell1]\naddress = "virtual:irc5"\nrobot = "{robot}"\n'
    (folder / "assistant.toml").write_text(cell if robot else "", "utf-8")
    dropped = page.send("project/drop", (tmp_path / "part.dxf").read_bytes(), name="part.dxf")
    fields = page.get("drawing", path=dropped.value["path"]).value["values"]
    proposed = next(one["proposed"] for one in fields if one["field"] == "frames.work.position")
    assert proposed["frames.work.position"] == frame["position"]
    assert proposed.get("frames.work.euler_zyx", [0, 0, 0]) == frame["euler_zyx"]
    assert proposed.get("robot", robot) == arm
    assert (arm == ARM) == (frame["euler_zyx"] == [90, 0, 0])


def test_nothing_is_proposed_for_work_that_the_user_has_turned(page: Page) -> None:
    path = dropped(page)
    turned = {"frames": {"work": {"euler_zyx": [0, 30, 0]}}}
    done = page.post("drawing/process", path=path, values=turned)
    assert done.status == 200, done.value
    assert not [one for one in done.value["values"] if "proposed" in one]


def test_a_drawing_is_placed_in_its_frame(page: Page, folder: Path) -> None:
    path = dropped(page)
    turned = {"placement": {"position": [10, 0, 0], "euler_zyx": [90, 0, 0]}}
    done = page.post("drawing/process", path=path, values={**PLACED, **turned})
    assert (done.status, codes(done)) == (200, [])
    assert settings(folder / "drawings" / "plate.process.toml")["placement"] == turned["placement"]
    wanted = {"placement": {"position": [10, 0]}}
    assert codes(page.post("drawing/process", path=path, values=wanted)) == ["CT303"]
    assert settings(folder / "drawings" / "plate.process.toml")["placement"] == turned["placement"]


NO_PROCESS: tuple[dict[str, Any], ...] = (
    {"layers": 3},
    {"layers": {"GLUE": 3}},
    {"layers": {"GLUE": {"speed": -1}}},
    {"layers": {"GLUE": {"speed": [None]}}},
    {"layers": {"GLUE": {"speed": 1e300}}},
    {"layers": {"GLUE": {"no_key": 1}}},
    {"layers": {"\ud800": {"speed": 1}}},
    {"tools": {"tool": {"tip": "abc"}}},
    {"tools": {"tool": "abc"}},
    {"tools": {"tool.tip": [1, 2, 3]}},
    {"unit": "miles\n[layers.A]"},
    {"motion": {"speed": {"a": {"b": []}}}},
)


def test_what_a_process_cannot_be_is_refused_and_not_written(page: Page, folder: Path) -> None:
    path = dropped(page)
    file = folder / "drawings" / "plate.process.toml"
    before = file.read_bytes()

    def check(values: dict[str, Any]) -> None:
        refused = page.post("drawing/process", path=path, values=values)
        assert refused.status == 422
        assert codes(refused)
        assert file.read_bytes() == before

    each(NO_PROCESS, check)


def test_a_process_file_that_is_wrong_has_its_finding_and_stays(page: Page, folder: Path) -> None:
    path = dropped(page)
    file = folder / "drawings" / "plate.process.toml"
    for wrong in (b"unit = ", b"\xff\xfe\x00", b"layers = 3\n", b'[layers.GLUE]\nspeed = "x"\n'):
        file.write_bytes(wrong)
        seen = page.get("drawing", path=path)
        assert codes(seen), wrong
        refused = page.post("drawing/process", path=path, values={"motion": {"speed": "x"}})
        assert refused.status == 422, wrong
        assert file.read_bytes() == wrong


def test_programs_and_tables_are_dropped(page: Page, folder: Path) -> None:
    assert page.send("project/drop", SEAM, name="seam.mod").value["opens"] == "programs/seam.mod"
    table = (SAMPLES / "positioning.csv").read_bytes()
    assert page.send("project/drop", table, name="points.csv").value["kind"] == "table"
    sources = {one["name"]: one["source"] for one in page.get("project").value["programs"]}
    assert sources == {"seam": "programs/seam.mod", "points": "tables/points.csv"}
    again = page.send("project/drop", SEAM, name="seam.mod")
    assert again.status == 200  # the same once more changes nothing
    other = page.send("project/drop", SEAM + b"! more\n", name="seam.mod")
    assert codes(other) == ["ST022"]
    assert (folder / "programs" / "seam.mod").read_bytes() == SEAM


@pytest.mark.slow
@pytest.mark.parametrize("name", ["broken.dxf", "broken.csv", "broken.mod"])
def test_a_file_that_says_nothing_is_dropped_with_its_findings(page: Page, name: str) -> None:
    answer = page.send("project/drop", bytes(range(256)) * 40, name=name)
    assert answer.status in (200, 422)
    checked = page.post("project/check")
    assert codes(answer) + codes(checked)
    assert page.get("project").status == 200


NOT_PLAIN = (
    *("", ".", "..", "../x.dxf", "a/b.dxf", "a\\b.dxf", "/etc/x.dxf", "C:\\x.dxf", ".x.dxf"),
    *("a\0.dxf", "a\n.dxf", "a\u202efxd.dxf", "a\ud800.dxf", "x" * 300 + ".dxf", "a.dxf "),
    *("con.dxf", "NUL.dxf", "com1.mod", "lpt9.csv", "a.exe", "assistant.toml", "<img>.dxf"),
    *("a:b.dxf", "a.dxf.", "a..dxf", "a|b.dxf", "a\u200bb.dxf", "-a.dxf"),
)


def test_names_of_what_is_dropped_are_plain(page: Page, folder: Path) -> None:
    def check(name: str) -> None:
        refused = page.post("project/drop", name=name)
        assert (refused.status, codes(refused)[0][:3]) == (422, "ST0")
        assert list(folder.iterdir()) == []

    each(NOT_PLAIN, check)


def test_what_leads_out_of_the_project_is_not_listed(page: Page, folder: Path) -> None:
    outside = folder.parent / "outside"
    outside.mkdir()
    (outside / "secret.dxf").write_bytes(PLATE)
    (folder / "linked").symlink_to(outside)
    (folder / "linked.dxf").symlink_to(outside / "secret.dxf")
    (folder / "drawings").symlink_to(outside)
    assert files(page) == {}
    for path in ("linked/secret.dxf", "linked.dxf", "../outside/secret.dxf", "drawings/secret.dxf"):
        assert codes(page.get("drawing", path=path)) == ["ST023"]
    assert codes(page.send("project/drop", PLATE, name="plate.dxf")) == ["ST023"]
    assert [one.name for one in outside.iterdir()] == ["secret.dxf"]


def test_files_that_cannot_be_read_are_told_in_place(page: Page, folder: Path) -> None:
    (folder / "assistant.toml").write_text("[programs\n", encoding="utf-8")
    told = page.get("project").value
    assert told["there"]
    assert [finding["path"] for finding in told["findings"]] == ["assistant.toml"]
    assert codes(page.get("drawing", path="none.dxf")) == ["ST026"]
    (folder / "torn.dxf").write_bytes(PLATE[:5000])
    assert page.get("drawing", path="torn.dxf").status == 422
    os.mkfifo(folder / "pipe.dxf")
    assert page.get("drawing", path="pipe.dxf").status == 422  # nobody writes into it


@pytest.mark.slow
def test_many_files_are_listed_as_far_as_a_page_has_room(page: Page, folder: Path) -> None:
    for i in range(50_000):
        (folder / f"p{i:05}.csv").touch()
    told = page.get("project").value
    assert len(told["files"]) == 5_000
    assert told["more"]


def test_names_that_no_text_has_are_listed(page: Page, folder: Path) -> None:
    (folder / os.fsdecode(b"torn\xff.csv")).write_bytes(b"x\n")
    (folder / "a\u202efxd.csv").touch()
    assert set(files(page)) == {"torn\udcff.csv", "a\u202efxd.csv"}


def test_what_changes_on_the_disk_is_told(page: Page, folder: Path) -> None:
    second = Page(page.address)
    with second.line() as line:
        for i in range(5):  # it looks for the first time a moment after the line is open
            (folder / "new.csv").write_text("a\n" * i, encoding="utf-8")
            with contextlib.suppress(TimeoutError):
                told = json.loads(line.recv(2.0))
                break
    assert told == {"kind": "disk", "files": ["new.csv"]}


@pytest.mark.slow
def test_a_drawing_is_dropped_and_worked_in_a_browser(
    browser: Any, address: str, folder: Path
) -> None:
    with studio_page(browser, address) as page, clean(page):
        page.set_input_files("#drop-file", str(SAMPLES / "plate.dxf"))
        page.wait_for_selector("#panel-drawing polyline", state="attached")
        assert page.get_attribute("#tab-drawing", "aria-selected") == "true"
        assert "CT303" in page.inner_text("#findings")
        page.get_by_label("tip of the tool, mm").fill("0, 0, 120")
        page.get_by_label("place of the work, mm").fill("150 0 100")
        page.get_by_label("GLUE: speed, mm/s").fill("80")
        page.get_by_label("CUT: worked").uncheck()
        _switched_by_clicks(page)
        page.get_by_role("button", name="Write the process file").click()
        until(page, "!document.querySelector('#findings').innerText.includes('CT303')")
        file = folder / "drawings" / "plate.process.toml"
        stated = settings(file)
        assert stated["tools"]["tool"]["tip"] == [0, 0, 120]
        assert stated["layers"]["GLUE"]["speed"] == 80
        assert stated["leave_out"][-2] == "CUT"
        assert stated["leave_out"][-1]["layer"] == "GLUE"
        assert stated["layers"]["GLUE"]["on"] == {"valve": 1}
        assert stated["layers"]["GLUE"]["lead_out"] == {"line": 4}
        assert stated["signals"]["valve"]["number"] == 7
        _changed_elsewhere(page, file)


def _switched_by_clicks(page: Any) -> None:
    """A contour of the chosen layer is left out by a click; one of another layer chooses that."""
    for layer in ("CUT", "GLUE"):
        line = page.locator(f".picture [data-of={layer}] + .reach").first
        line.dispatch_event("click")
        assert page.get_attribute(f"tr[data-layer={layer}]", "aria-current") == "true"
    assert page.locator(".picture polyline.left").count() == 0
    line.dispatch_event("click")
    assert page.locator(".picture polyline.left").count() == 1
    assert "left out" in page.inner_text(".picture p")
    page.fill("#new-output", "valve")
    page.fill("#new-output-number", "7")
    page.press("#new-output-number", "Tab")
    page.get_by_label("GLUE: output that is on along it").select_option("valve")
    page.get_by_label("GLUE: lead out", exact=True).select_option("line")
    page.get_by_label("GLUE: lead out, mm").fill("4")


def _changed_elsewhere(page: Any, file: Path) -> None:
    """Taken in where nothing is typed; else asked."""
    speed = page.get_by_label("GLUE: speed, mm/s")
    time.sleep(0.02)
    file.write_text(file.read_text("utf-8").replace("speed = 80", "speed = 90"), "utf-8")
    until(page, "document.querySelector('[data-layer=GLUE] [data-key=speed]').value === '90'")
    speed.fill("70")
    file.write_text(file.read_text("utf-8").replace("speed = 90", "speed = 95"), "utf-8")
    page.get_by_role("button", name="Keep what stands here").click()
    assert speed.input_value() == "70"
    file.write_text(file.read_text("utf-8").replace("speed = 95", "speed = 96"), "utf-8")
    page.get_by_role("button", name="Take what is on the disk").click()
    assert speed.input_value() == "96"


@pytest.mark.slow
def test_files_are_walked_by_keys(browser: Any, address: str, folder: Path) -> None:
    for name in ("a.csv", "b.csv", "c.csv"):
        (folder / name).write_text("1\n", encoding="utf-8")
    with studio_page(browser, address) as page, clean(page):
        page.locator("#files button").first.focus()
        for key, name in (("ArrowDown", "b"), ("End", "c"), ("ArrowUp", "b"), ("Home", "a")):
            page.keyboard.press(key)
            assert page.evaluate("document.activeElement.dataset.path") == f"{name}.csv"
        (folder / "0.csv").touch()
        page.wait_for_selector("#files [data-path='0.csv']")
        assert page.evaluate("document.activeElement.dataset.path") == "a.csv"
        (folder / "backups").mkdir()
        (folder / "backups" / "d.csv").touch()
        page.wait_for_selector("#files details:not([open])")  # what controllers had is folded
        page.keyboard.press("End")
        assert page.evaluate("document.activeElement.dataset.path") == "c.csv"
