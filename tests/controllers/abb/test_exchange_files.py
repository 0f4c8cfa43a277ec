"""The printed RAPID module, and the files that it and the PC write."""

import numpy as np
import pytest

from assistant import languages
from assistant.base.diagnostics import Refused
from assistant.controllers.abb.exchange import Module, Tool, files
from tests.controllers.abb.exchanging import MODULE


@pytest.mark.parametrize(
    "module",
    [
        MODULE,
        Module(),
        Module(tool="tGrip2", work_object="wobjTable", speed="vSlow", zone="fine", prefix="px"),
        Module(folder="HOME:/parts/", longest=0.5e4, poll=0.5, look=1.0),
    ],
)
def test_the_module_is_rapid_without_a_finding(module):
    rapid = languages.get("rapid")
    tree = rapid.parse(module.text())
    found = [*tree.findings, *rapid.check([tree])]
    given = {"tGrip2", "wobjTable", "vSlow"} if module.tool == "tGrip2" else set()
    assert not [f for f in found if not any(f"`{name}`" in f.message for name in given)]
    assert all(len(line) < 120 for line in module.text().splitlines())


def test_the_module_moves_as_the_paper_does():
    text = Module(tool="GRIPPER", tool_data=Tool((0.0, 0.0, 118.0))).text()
    assert "MoveL Posenew,v150,z100,GRIPPER" in text
    assert "WaitUntil IsFile(stRequest)\\MaxTime:=240" in text
    assert (
        "PERS tooldata GRIPPER:=[TRUE,[[0,0,118],[1,0,0,0]],[1,[0,0,50],[1,0,0,0],0,0,0]];" in text
    )


@pytest.mark.parametrize(
    "given",
    [
        {"tool": "GRIP;Stop"}, {"speed": "v150,fine,tool0;Stop;MoveL x"}, {"zone": ""},
        {"module": "1st"}, {"work_object": "a" * 33}, {"tool": "endproc"}, {"tool": "Posenew"},
        {"module": "größe"}, {"prefix": "../x"}, {"prefix": ""}, {"prefix": "a b"},
        {"folder": "HOME:/../x"}, {"folder": 'HOME:"+x'}, {"folder": "HOME"}, {"tool": "tell\n"},
        {"longest": 0.0}, {"poll": 0.01}, {"look": float("nan")}, {"longest": float("inf")},
        {"tool_data": Tool((0.0, 0.0, float("nan")))},
        {"tool_data": Tool((0.0, 0.0, 0.0), mass=0.0)},
    ],
    ids=str,
)  # fmt: skip
def test_what_is_no_name_or_figure_never_gets_into_the_module(given):
    with pytest.raises(Refused) as refused:
        Module(**given).text()
    assert refused.value.findings[0].code in {"CN515", "CN516"}


@pytest.mark.parametrize(
    "text",
    [
        "", "5\nok\n", "x\nok\n[1,2,3]\n[1,0,0,0]\n[0,0,0,0]\n[1,1,1,1,1,1]\n0\nEND x\n",
        "5\nok\n[1,2,3]\n[1,0,0,0]\n[0,0,0,0]\n[1,1,1,1,1,1]\n0\nEND 6\n",
        "5\nok\n[1,2]\n[1,0,0,0]\n[0,0,0,0]\n[1,1,1,1,1,1]\n0\nEND 5\n",
        "5\nok\n[1,2,nan]\n[1,0,0,0]\n[0,0,0,0]\n[1,1,1,1,1,1]\n0\nEND 5\n",
        "5\nok\n[1,2,3]\n[0,0,0,0]\n[0,0,0,0]\n[1,1,1,1,1,1]\n0\nEND 5\n",
        "5\nok\n[1,2,3]\n[2,0,0,0]\n[0,0,0,0]\n[1,1,1,1,1,1]\n0\nEND 5\n",
        "5\nok\n[1,2,3]\n[1,0,0,0]\n[0,0,0,0]\n[1,1,1,1,1,1]\nsoon\nEND 5\n",
        "\xff" * 3000,
    ],
)  # fmt: skip
def test_files_that_are_no_answer(text):
    assert files.parse_answer(text.encode("latin-1")) is None


def test_an_answer_is_read_as_the_controller_writes_it():
    text = (
        "5\nok\n[524.205,-0.5,691.1]\n[0.5,0,0.866025,-5.97135E-07]\n[0,-1,0,4]\n"
        "[9E+09,12.5,9E+09,9E+09,9E+09,9E+09]\n0.068\nEND 5\n"
    )
    answer = files.parse_answer(text.encode())
    assert answer == files.parse_answer(text.replace("\n", "\r\n").encode())
    assert (answer.number, answer.word, answer.motion) == (5, "ok", 0.068)
    assert answer.pose.position == (524.205, -0.5, 691.1) and answer.configuration == (0, -1, 0, 4)
    assert np.linalg.norm(answer.pose.quaternion) == pytest.approx(1.0, abs=1e-12)
    assert answer.external[1] == 12.5 and np.isnan(answer.external[0])
    for end in range(len(text) - 1):
        assert files.parse_answer(text[:end].encode()) is None
