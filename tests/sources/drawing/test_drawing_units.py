"""Units: every code of $INSUNITS, and none."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import ezdxf
import pytest
from ezdxf.document import Drawing

from assistant.program.diagnostics import Refused, Severity
from assistant.sources.curves import Arc
from assistant.sources.drawing import read, read_contents
from assistant.sources.process import NO_PROCESS

Save = Callable[..., Path]

EXACT = {
    1: "25.4", 2: "304.8", 3: "1609344", 4: "1", 5: "10", 6: "1000", 7: "1e6", 8: "2.54e-5",
    9: "0.0254", 10: "914.4", 11: "1e-7", 12: "1e-6", 13: "1e-3", 14: "100", 15: "1e4", 16: "1e5",
    17: "1e12", 18: "1.495978707e14", 19: "9.4607304725808e18", 20: "3.0856775814913673e19",
    21: "304.8006096012192", 22: "25.4000508001016", 23: "914.4018288036576",
    24: "1609347.2186944373",
}  # fmt: skip


@pytest.mark.parametrize("code", EXACT)
def test_every_code(save: Save, code: int) -> None:
    document = ezdxf.new("R2010", units=code)
    size = 100.0 / float(EXACT[code])  # 100 mm, which no unit makes too large or small
    document.modelspace().add_circle((2 * size, 0), size)
    (circle,) = read_contents(save(document), NO_PROCESS).curves
    assert isinstance(circle, Arc)
    assert circle.radius == pytest.approx(100.0, rel=1e-12)
    assert circle.centre == pytest.approx((200.0, 0.0, 0.0), rel=1e-12)


@pytest.mark.parametrize("missing", [True, False])
def test_without_unit(save: Save, drawing: Drawing, missing: bool) -> None:
    drawing.modelspace().add_circle((0, 0), 5)
    if missing:
        del drawing.header["$INSUNITS"]
    else:
        drawing.header["$INSUNITS"] = 0
    contents = read_contents(save(drawing), NO_PROCESS)
    (finding,) = [f for f in contents.findings if f.code == "DX101"]
    assert finding.severity is Severity.WARNING
    assert ("missing" in finding.message) is missing
    (circle,) = contents.curves
    assert isinstance(circle, Arc)
    assert circle.radius == 5.0


@pytest.mark.parametrize("code", [25, -1, 99])
def test_unknown_code(save: Save, drawing: Drawing, code: int) -> None:
    drawing.modelspace().add_circle((0, 0), 5)
    drawing.header["$INSUNITS"] = code
    with pytest.raises(Refused) as caught:
        read(save(drawing), NO_PROCESS)
    assert [f.code for f in caught.value.findings] == ["DX102"]
    assert caught.value.exit_status == 1


def test_current_ucs_is_mentioned(save: Save, drawing: Drawing) -> None:
    drawing.modelspace().add_line((0, 0), (1, 1))
    drawing.header["$UCSORG"] = (10, 0, 0)
    contents = read_contents(save(drawing), NO_PROCESS)
    assert "DX103" in [f.code for f in contents.findings]
    assert contents.curves[0].start == (0.0, 0.0, 0.0)
