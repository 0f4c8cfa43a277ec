"""The page in a real browser: it draws the arm and the path, and poses the arm as Python does."""

from __future__ import annotations

import io
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from assistant import robots
from assistant.base.arrays import Floats
from assistant.cell.collision.model import Carriers
from assistant.cell.link_bodies import place_robot
from assistant.cli import main
from assistant.program.geometry import Pose
from assistant.view.live_page import LivePage
from assistant.view.page import filled_page
from docs.browsing import chromium, installed
from tests.cell.test_holding import CELL, PICK
from tests.cli.test_commands import SAMPLES, run
from tests.view.boxes import wrong_boxes
from tests.view.cases import data_of, numbers, written


@pytest.fixture(scope="module")
def browser() -> Iterator[Any]:
    pytest.importorskip("playwright.sync_api")
    if installed() is None:
        pytest.skip("there is no Chromium here: apt-get install chromium")
    with chromium() as opened:
        yield opened


@contextmanager
def looking(browser: Any, address: str, asks: tuple[str, ...] = ()) -> Iterator[Any]:
    """A page on which nothing goes wrong, and that asks for nothing but this."""
    page = browser.new_page(viewport={"width": 800, "height": 500})
    wrong: list[str] = []
    asked: list[str] = []
    page.on("console", lambda message: wrong.append(message.text))
    page.on("pageerror", lambda fault: wrong.append(str(fault)))
    page.on("request", lambda request: asked.append(request.url))
    page.goto(address)
    until(page, "view.drawn() > 0")
    yield page
    page.close()
    assert wrong == []
    assert asked == [address, *asks]


@pytest.fixture(scope="module")
def seam(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The page of a program that touches a post."""
    pytest.importorskip("coal")
    folder = tmp_path_factory.mktemp("seam")
    program, cell = written(folder)
    out = folder / "seam.html"
    with pytest.raises(SystemExit):
        main(["view", str(program), "--cell", str(cell), "--html", str(out)])
    return out


@pytest.fixture
def opened(browser: Any, seam: Path) -> Iterator[tuple[Any, str]]:
    """This page, and its text."""
    with looking(browser, seam.as_uri()) as page:
        yield page, seam.read_text(encoding="utf-8")


UNREACHED = """() => [...document.querySelectorAll("body *")]
  .filter((one) => ["auto", "scroll"].includes(getComputedStyle(one).overflowY))
  .filter((one) => one.offsetParent && one.tabIndex < 0 && !one.querySelector("button:enabled"))
  .filter((one) => one.id && one.tagName !== "ASIDE").map((one) => one.id)"""
"""Elements that scroll and cannot take the focus, nor contain one that can."""


def test_the_slider_is_usable_and_lists_take_focus_at_200_percent(
    opened: tuple[Any, str],
) -> None:
    page, _ = opened
    page.set_viewport_size({"width": 640, "height": 400})  # 1280 x 800, twice as large
    width = "document.getElementById('time').getBoundingClientRect().width"
    until(page, f"{width} > 0 && innerWidth === 640")
    assert page.evaluate(width) >= 150.0
    page.evaluate("document.getElementById('finding-list').focus()")
    assert page.evaluate("document.activeElement.id") == "finding-list"
    assert page.evaluate(UNREACHED) == []
    heads = "[...document.querySelectorAll('th')].filter((one) => !one.textContent.trim()).length"
    assert page.evaluate(heads) == 0
    page.evaluate("document.getElementById('time').focus()")
    before = page.evaluate("Number(document.getElementById('time').value)")
    page.keyboard.press("End")
    assert page.evaluate("Number(document.getElementById('time').value)") > before


def until(page: Any, what: str) -> None:
    """Waits for what scripts of the page tell; playwright's own way is not allowed on it."""
    for _ in range(200):
        if page.evaluate(what):
            return
        page.wait_for_timeout(50)
    pytest.fail(f"not within 10 s: {what}")


def picture(page: Any) -> Floats:
    """The scene as (height, width, 3), 0 to 1."""
    from matplotlib.image import imread

    page.wait_for_timeout(200)
    return np.asarray(imread(io.BytesIO(page.locator("canvas").screenshot())))[:, :, :3]


def test_arm_path_and_bodies_are_in_the_picture(opened: tuple[Any, str]) -> None:
    page, _ = opened
    seen = picture(page)
    red, green, blue = np.moveaxis(seen, 2, 0)
    assert ((red > 1.3 * green) & (green > 1.3 * blue)).sum() > 5000  # orange links
    assert ((blue > 2.0 * red) & (blue > 2.0 * green)).sum() > 500  # the blue post
    box = page.get_by_label("path of the tool")
    box.uncheck()
    without = picture(page)
    changed = np.abs(seen - without).max(axis=2) > 0.05
    assert 50 < changed.sum() < 0.05 * changed.size  # a line, and nothing else
    assert np.ptp(np.flatnonzero(changed.any(axis=1))) > 50


@pytest.mark.slow
def test_the_arm_moves_with_the_time_line(opened: tuple[Any, str]) -> None:
    page, _ = opened
    before = picture(page)
    page.get_by_role("slider").fill("1.5")
    assert page.evaluate("view.time()") == pytest.approx(1.5, abs=0.01)
    assert (np.abs(picture(page) - before).max(axis=2) > 0.05).mean() > 0.01
    page.locator("#play").click()
    until(page, "view.time() > 1.6")
    page.locator("#after").click()
    assert page.locator("#moves button.now").count() == 1


@pytest.mark.slow
def test_the_page_poses_links_where_they_are(opened: tuple[Any, str]) -> None:
    page, text = opened
    robot = robots.get("irb1200-7-0.7")
    carriers = Carriers((place_robot("arm", robot, Pose((50.0, 0.0, 20.0))),))
    motion = data_of(text)["motion"]
    times = numbers(motion["times"])
    joints = np.degrees(numbers(motion["joints"]).reshape(len(times), 6)) - robot.zero
    for row in (0, len(times) // 3, len(times) - 1):
        page.evaluate(f"view.setTime({times[row]})")
        seen = np.array(page.evaluate("view.carriers()")).reshape(-1, 4, 4)  # column by column
        origins, turns = carriers.at(joints[row : row + 1])
        assert np.abs(seen[:, 3, :3] - origins[0]).max() < 0.01
        assert np.abs(seen[:, :3, :3].transpose(0, 2, 1) - turns[0]).max() < 1e-5


@pytest.mark.slow
def test_a_finding_leads_into_the_scene_and_a_move_to_its_time(opened: tuple[Any, str]) -> None:
    page, text = opened
    data = data_of(text)
    at = next(i for i, one in enumerate(data["findings"]) if (one["mark"] or {}).get("time"))
    page.locator("#findings button").nth(at).click()
    assert page.evaluate("view.time()") == pytest.approx(data["findings"][at]["mark"]["time"])
    page.locator("#moves button").nth(2).click()
    assert page.evaluate("view.time()") == pytest.approx(data["moves"][2]["time"])
    assert "16" in page.locator("#moves button.now").inner_text()


@pytest.mark.slow
def test_a_line_leads_to_its_time_and_a_time_to_its_line(opened: tuple[Any, str]) -> None:
    page, _ = opened
    page.locator("#listing button", has_text="move linear b").click()
    assert page.evaluate("view.time()") == pytest.approx(data_of(opened[1])["moves"][1]["time"])
    assert page.evaluate("view.line()") == 14
    page.locator("#after").click()
    assert page.evaluate("view.line()") == 16
    assert page.locator("#listing button.now").inner_text().startswith("16")


@pytest.mark.slow
def test_the_path_is_coloured_by_what_is_chosen(opened: tuple[Any, str]) -> None:
    page, text = opened
    before = picture(page)
    page.locator("#by").select_option("room")
    changed = np.abs(picture(page) - before).max(axis=2) > 0.05
    assert 20 < changed.sum() < 0.05 * changed.size
    assert page.locator("#most").inner_text() == "at a limit"
    assert numbers(data_of(text)["motion"]["room"]).min() > 0.0


@pytest.mark.slow
def test_a_program_is_seen_from_above_and_from_the_side(
    browser: Any, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    program, _ = written(tmp_path)
    run(capsys, "simulate", program, "--report", tmp_path / "seam.html")
    with looking(browser, (tmp_path / "seam.html").as_uri()) as page:
        assert page.evaluate("view.flat()")
        seen = picture(page)
        red, green, blue = np.moveaxis(seen, 2, 0)
        arm = (red > 1.3 * green) & (green > 1.3 * blue)
        along = 0 if seen.shape[0] > seen.shape[1] else 1  # one above the other, or side by side
        above, side = np.split(arm, [seen.shape[along] // 2], axis=along)
        assert above.sum() > 500 < side.sum()
        tall = [np.ptp(np.flatnonzero(one.any(axis=1))) for one in (above, side)]
        assert tall[1] > 1.5 * tall[0]  # it stands upright
        page.locator("#space").click()
        until(page, "!view.flat()")
        assert (np.abs(picture(page) - seen).max(axis=2) > 0.05).mean() > 0.05


@pytest.mark.slow
def test_another_program_of_a_page_is_chosen_and_stays_hostile_to_nobody(
    browser: Any, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    program, _ = written(tmp_path)
    hostile = tmp_path / "evil.mod"
    text = "</script><script>document.title=1</script>"
    hostile.write_text(f'MODULE m\nPROC main()\nTPWrite "{text}";\nENDPROC\nENDMODULE\n')
    both = tmp_path / "both.html"
    run(capsys, "check", program, hostile, "--report", both)
    with looking(browser, both.as_uri(), (both.as_uri(),)) as page:
        assert page.locator("h1").inner_text() == "seam.pseudo"
        assert page.title() == "seam.pseudo and 1 more"
        page.locator("#program").select_option("1")
        page.locator("h1", has_text="evil.mod").wait_for()
        assert text in page.locator("#listing").inner_text()
        assert page.title() == "seam.pseudo and 1 more"


@pytest.mark.slow
def test_lines_of_a_translation_stand_beside_each_other(
    browser: Any, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    samples = SAMPLES / "rapid"
    given = ("--to", "melfa-basic-5", "--from-robot", "irb1200-7-0.7", "--robot", "rv-4frl")
    to = ("-p", samples / "cell.process.toml", "-o", tmp_path, "--report", tmp_path / "t.html")
    run(capsys, "translate", samples / "gluing.mod", *given, *to)
    with looking(browser, (tmp_path / "t.html").as_uri()) as page:
        page.locator("#findings button:not(:disabled)", has_text="MB204").first.click()
        line = page.locator("#listing button", has_text="AccSet 60,100")
        assert "Accel 60,60" in line.inner_text()
        assert "MoveJ pHome" in page.locator("#listing button.now").first.inner_text()
        page.evaluate("view.setTime(view.seconds - 0.01)")
        assert "Mov PHOME" in page.locator("#listing button.now").last.inner_text()


@pytest.mark.slow
def test_nothing_of_a_page_is_cut_off(
    browser: Any, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Both reports and a scene: texts wrap in their columns, and names stay in their pane."""
    out, samples = ("-o", tmp_path), SAMPLES / "rapid"
    arms = ("--from-robot", "irb1200-7-0.7", "--robot", "rv-4frl")
    cell = (*arms, "-p", samples / "cell.process.toml", *out)
    pages = (
        ("translate", samples / "gluing.mod", "--to", "melfa-basic-5", *cell, "--report"),
        ("translate", samples / "pick_and_place.mod", "--to", "melfa-basic-5", *out, "--report"),
        ("compile", SAMPLES / "plate.dxf", "-l", "rapid", "-r", "irb1200-7-0.7", *out, "--report"),
        ("view", SAMPLES / "plate.dxf", "-r", "irb1200-7-0.7", "--html"),
    )
    for number, command in enumerate(pages):
        file = tmp_path / f"{number}.html"
        run(capsys, *command, file)
        with looking(browser, file.as_uri()) as page:
            assert wrong_boxes(page) == {}, command


@pytest.mark.slow
def test_the_work_is_framed(opened: tuple[Any, str]) -> None:
    """The path is in the middle of the picture; a button shows the arm and all."""
    page, text = opened
    middle = [450.0, 0.0, 420.0]
    assert data_of(text)["targets"][0]["pose"][:3] == [450.0, -100.0, 420.0]
    x, y = page.evaluate(f"view.seen({middle})")
    wide, high = page.evaluate("[stage.clientWidth, stage.clientHeight]")
    assert abs(x - wide / 2) < wide / 4 and abs(y - high / 2) < high / 4
    far = "Math.hypot(...view.camera()[0].map((at, i) => at - view.camera()[1][i]))"
    near = page.evaluate(far)
    page.click("#all")
    assert page.evaluate(far) > 1.2 * near


@pytest.mark.slow
def test_what_is_taken_moves_with_the_arm_on_the_page(
    browser: Any, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    pytest.importorskip("coal")
    files = tmp_path / "pick.pseudo", tmp_path / "cell.toml", tmp_path / "pick.html"
    other = '[robots.other]\nrobot = "rv-2aj"\nposition = [2000, 0, 0]\n'
    files[0].write_text(PICK, encoding="utf-8")
    files[1].write_text(CELL + other, encoding="utf-8")
    run(capsys, "view", files[0], "--cell", files[1], "-r", "arm", "--html", files[2])
    data = data_of(files[2].read_text(encoding="utf-8"))
    assert [robot["moves"] for robot in data["robots"]] == [True, False]
    (part,) = (one for one in data["bodies"] if one["name"] == "part")
    _, taken, left = part["rides"]
    motion = data["motion"]
    times, places = numbers(motion["times"]), numbers(motion["places"]).reshape(-1, 3)
    with looking(browser, files[2].as_uri()) as page:

        def place(time: float) -> Floats:
            page.evaluate(f"view.setTime({time})")
            return np.array(page.evaluate("view.body('part')"))[12:15]

        assert place(taken["time"] - 0.05) == pytest.approx([400.0, -150.0, 288.0])
        between = 0.5 * (taken["time"] + left["time"])
        flange = [np.interp(between, times, column) for column in places.T]
        assert place(between) == pytest.approx(flange - np.array([0.0, 0.0, 112.0]), abs=0.5)
        assert place(times[-1]) == pytest.approx([400.0, 150.0, 288.0], abs=1e-2)
        assert place(0.0) == pytest.approx([400.0, -150.0, 288.0])
        seen = np.moveaxis(picture(page), 2, 0)
        assert seen.std() > 0.05


@pytest.mark.slow
def test_a_page_that_follows_stands_as_it_is_told(opened: tuple[Any, str], browser: Any) -> None:
    data = data_of(opened[1]) | {"live": "cell <b>one</b>"}
    robot = robots.get("irb1200-7-0.7")
    carriers = Carriers((place_robot("arm", robot, Pose((50.0, 0.0, 20.0))),))
    with LivePage(filled_page(data)) as served:
        events = f"{served.address}events"
        with looking(browser, served.address, (events,)) as page:
            assert page.locator("#state").inner_text() == "cell <b>one</b>: waiting for it"
            for turn in (10.0, 40.0):
                joints = np.array([[turn, 20.0, 10.0, 5.0, 60.0, 7.0]])
                told = {"joints": robot.chained(joints)[0].tolist(), "state": "on", "interval": 0.1}
                count = page.evaluate("view.told()")
                served.tell("sample", told)
                until(page, f"view.told() > {count}")
                page.wait_for_timeout(500)
                seen = np.array(page.evaluate("view.carriers()")).reshape(-1, 4, 4)
                assert np.abs(seen[:, 3, :3] - carriers.at(joints)[0][0]).max() < 0.01
            page.locator("#play").click()
            assert not page.evaluate("view.following()")
            until(page, "view.time() > 0.1")
            page.locator("#live").click()
            assert page.evaluate("view.following()")
            served.tell("lost", {"text": "the line <i>broke"})
            until(page, "!document.getElementById('notice').hidden")
            assert page.locator("#notice").inner_text() == "the line <i>broke"


@pytest.mark.slow
def test_ten_thousand_targets_play(
    browser: Any, tmp_path: Path, capsys: pytest.CaptureFixture[str], tell: Any
) -> None:
    count = 10_000
    turn = np.linspace(0.0, 200.0, count)
    rows = np.column_stack([500 + 80 * np.cos(turn), 80 * np.sin(turn), 350 + 0.01 * turn])
    target = "[[{:.3f},{:.3f},{:.3f}],[0,0,1,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]]"
    lines = [f"MoveL {target.format(*row)},v200,z1,tool0;" for row in rows]
    file, out = tmp_path / "many.mod", tmp_path / "many.html"
    text = "\n".join(["MODULE many", "PROC main()", *lines, "ENDPROC", "ENDMODULE"]) + "\n"
    file.write_text(text, encoding="utf-8")
    run(capsys, "view", file, "-r", "irb1200-7-0.7", "--html", out)
    tell(f"10,000 targets: {len(text) / 1e6:.2f} MB of program, {out.stat().st_size / 1e6:.2f} MB")
    assert out.stat().st_size < 4e6
    with looking(browser, out.as_uri()) as page:
        half = page.evaluate("view.seconds") / 2.0
        page.evaluate(f"view.setTime({half})")
        line = page.evaluate("view.line()")
        assert line == pytest.approx(2 + count / 2, abs=count / 20)
        page.locator("#rate").select_option("16")
        page.locator("#play").click()
        until(page, f"view.time() > {half} + 3")
        assert page.evaluate("view.line()") > line
        assert page.locator("#listing button").count() < 100
        assert page.locator("#listing button.now").count() == 1
