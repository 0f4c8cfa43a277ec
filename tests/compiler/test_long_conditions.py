"""Conditions that no step of MELFA-BASIC holds: run on both sides, and with another outcome."""

from __future__ import annotations

from pathlib import Path

import pytest

from assistant import translate
from assistant.compiler.motion_proof import Proving

MODULE = """MODULE sort
VAR num n;
PROC main()
n:=0;
IF diOne=1 n:=n+3;
IF diTwo=1 n:=n+5;
IF {condition} THEN
SetDO doYes,1;
ELSE
SetDO doNo,1;
ENDIF
ENDPROC
ENDMODULE
"""
CHAINS = {
    "or": " OR ".join(f"n>{k}00000 OR n={k}" for k in (8, 9, *range(11, 30))),
    "and": " AND ".join(f"n<{k}00000 AND n<>{k}" for k in (5, 8, *range(11, 30))),
    "and in or": " OR ".join(f"n>{k} AND n<{k}.5 OR n={k}" for k in (3, *range(11, 30))),
}


@pytest.mark.parametrize("condition", CHAINS.values(), ids=CHAINS.keys())
def test_a_condition_is_asked_in_several_steps(condition: str, tmp_path: Path) -> None:
    source = tmp_path / "sort.mod"
    source.write_text(MODULE.format(condition=condition), encoding="utf-8")
    process = tmp_path / "cell.toml"
    process.write_text(
        "[signals]\n"
        'diOne = { number = 1, direction = "input" }\n'
        'diTwo = { number = 2, direction = "input" }\n'
        "doYes = { number = 3 }\ndoNo = { number = 4 }\n",
        encoding="utf-8",
    )
    found = translate(source, to="melfa-basic-6", proving=Proving(), process=process)
    assert found.ok, found.findings
    assert found.motion is not None
    assert found.motion.holds and found.motion.found is not None
    assert found.motion.found.never == ((), ())
    lines = b"".join(found.files.values()).splitlines()
    assert max(map(len, lines)) <= 240
