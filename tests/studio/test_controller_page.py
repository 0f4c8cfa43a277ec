"""The controller in a real browser: deployed, changed there, taken back; moved and taught."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from assistant.virtual.cr import VirtualCr
from tests.studio.browsing import clean, studio_page, until
from tests.studio.cells import BENCHES
from tests.virtual.cr.waiting import wait_for


@pytest.mark.slow
def test_a_visitor_deploys_takes_back_moves_and_teaches(
    browser: Any, address: str, folder: Path, tmp_path: Path
) -> None:
    with BENCHES["cr"](folder, tmp_path / "home") as bench:
        assert isinstance(bench.cell, VirtualCr)
        with studio_page(browser, address) as page, clean(page):
            page.click("#tab-controller")
            page.click("#connect-form button")
            page.wait_for_selector("#monitor table")
            _deployed_and_taken_back(page, bench)
            _moved(page, bench.cell)
            page.fill("#teach-name", "p1")
            page.click("#teach-form button")
            page.wait_for_selector("#taught >> text=p1")
        wait_for(lambda: not bench.cell.state.servo)  # the window has gone
    assert "p1" in (folder / "taught.toml").read_text("utf-8")


def _deployed_and_taken_back(page: Any, bench: Any) -> None:
    page.click("#build")
    page.wait_for_selector("#files >> text=build/cell1")
    page.click("#plan")
    page.wait_for_selector("#programs >> text=create")
    page.click("#deploy")
    page.wait_for_selector("#programs >> text=installed")
    bench.change(bench.text.format(555))
    page.click("#verify")
    page.wait_for_selector("#drift.changed")
    assert "+555.00" in page.inner_text("#programs")
    page.click("#plan")
    page.wait_for_selector("#deploy:not(:disabled)")
    page.click("#verify")
    page.wait_for_selector("#drift.changed")
    assert page.is_disabled("#deploy")  # its plan is not in sight
    held: list[Any] = []
    page.route("**/controller/verify", lambda route: held.append(route))
    page.click("#roll-back")
    page.wait_for_selector("#findings >> text=replace what was changed there")
    _wait(page, lambda: held)
    # The list is about to be drawn anew: what is ticked in the old one would be lost.
    assert page.evaluate("document.getElementById('programs').inert")
    held[0].continue_()
    page.unroute("**/controller/verify")
    page.check("#programs input")
    page.click("#roll-back")
    page.wait_for_selector("#programs >> text=put back")
    assert bench.read() == ""


def _moved(page: Any, cell: VirtualCr) -> None:
    page.fill("#control-name", "cell1")
    page.click("#take-control")
    page.wait_for_selector("#control:not([hidden])")
    page.click("#motors-on")
    until(page, "document.querySelector('#monitor p').textContent.includes('Motors on')")
    for elsewhere in ("document.activeElement.blur()", "document.getElementById('drop').focus()"):
        page.evaluate(elsewhere)  # where the space bar scrolls, or opens a file
        page.keyboard.down(" ")
        assert page.get_attribute("#dead-man", "aria-pressed") == "false"
        page.keyboard.up(" ")
    page.focus("#dead-man")
    page.keyboard.down(" ")
    page.wait_for_selector("#dead-man.held")
    page.keyboard.press("Alt+3")  # what is held is not seen any more
    page.keyboard.up(" ")
    assert page.get_attribute("#dead-man", "aria-pressed") == "false"
    page.click("#tab-controller")
    page.focus("#dead-man")
    page.keyboard.down(" ")
    page.wait_for_selector("#dead-man.held")
    _wait(page, lambda: cell.state.joints[0] > 1.0)
    page.keyboard.up(" ")
    page.wait_for_selector("#dead-man:not(.held)")
    page.select_option("#jog-by", "−")
    page.fill("#jog-speed", "500")
    page.hover("#dead-man")
    page.mouse.down()
    page.wait_for_selector("#dead-man.held")
    page.mouse.move(5, 5)  # away from the key
    page.wait_for_selector("#dead-man:not(.held)")
    page.mouse.up()
    page.hover("#dead-man")
    page.mouse.down()
    page.wait_for_selector("#dead-man.held")
    page.evaluate("dispatchEvent(new Event('blur'))")  # another window in front
    page.wait_for_selector("#dead-man:not(.held)")
    page.mouse.up()
    assert float(page.input_value("#jog-speed")) <= 10
    page.route("**/control/stop", lambda route: route.fulfill(status=500, body=""))
    page.click("#tab-run")
    page.click("#stop-all")
    page.wait_for_selector("#controller-state:visible >> text=not known")
    page.unroute("**/control/stop")
    page.wrong = [said for said in page.wrong if "500" not in said]
    page.click("#stop-all")
    page.wait_for_selector("#controller-state >> text=stands")


def _wait(page: Any, so: Any) -> None:
    for _ in range(500):
        if so():
            return
        page.wait_for_timeout(20)
    pytest.fail("it never came to be")
