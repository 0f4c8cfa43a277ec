"""Random RAPID programs: the same for a seed, valid, and coming to an end."""

from __future__ import annotations

import os
import re
import subprocess
import sys
from pathlib import Path as FilePath

from assistant import languages
from assistant.base.diagnostics import has_errors
from assistant.virtual.rapid import run
from tests.virtual.random_rapid import FEATURES, program
from tests.virtual.translating import START

ROOT = FilePath(__file__).parent.parent.parent
FEW = range(6)
SAID = {
    "references": r"\b(INOUT|VAR|PERS) (num|bool|robtarget) \w+[,)]",
    "arrays": r"^VAR num \w+\{\d\}",
    "functions": r"^FUNC ",
    "here": r"CRobT\(\\Tool",
    "jumps": r"GOTO L1;",
    "loops": r"FOR \w+ FROM Abs\(.*\) MOD \d TO .* DO",
    "tests": r"^ +TEST ",
    "returns": r"RETURN",
    "waits": r"Wait(DI|Until|Time)",
    "limits": r"Wait(DI|Until) .*\\MaxTime:=",
    "groups": r"SetGO",
    "triggers": r"Trigg[JL] .*,v\d+,\w+(\\T2:=\w+)?,",
    "tables": r"tTable\{\d\}",
    "arcs": r"MoveC",
    "settings": r"ConfL|GripLoad",
    "registers": r"reg[12]\b",
    "optional": r"\\switch fast",
    "components": r"\.trans\.[xyz]:=",
    "persistent": r"^PERS num",
}


def test_a_seed_gives_one_program() -> None:
    texts = "".join(program(seed).text for seed in FEW)
    assert texts == "".join(program(seed).text for seed in FEW)
    assert len({program(seed).text for seed in FEW}) == len(FEW)


def test_programs_are_valid_and_come_to_an_end() -> None:
    rapid = languages.get("rapid")
    ends = []
    for seed in FEW:
        drawn = program(seed)
        tree = rapid.parse(drawn.text)
        assert not has_errors(rapid.check([tree])), seed
        for inputs in drawn.scenarios:
            found = run(tree, inputs=inputs, start=START, most_steps=20_000)
            out_of_time = found.ended == "error" and "ERR_WAIT_MAXTIME" in found.message
            assert out_of_time or found.ended not in ("error", "steps"), (seed, found.message)
            ends.append(found.ended)
    assert ends.count("end") > 0.8 * len(ends)


def test_everything_is_drawn_at_times() -> None:
    texts = [program(seed).text for seed in range(120)]
    unseen = [
        name
        for name, pattern in SAID.items()
        if not any(re.search(pattern, text, re.MULTILINE) for text in texts)
    ]
    assert unseen == []
    assert FEATURES.keys() >= SAID.keys()


def test_a_seed_gives_the_same_program_in_every_run() -> None:
    said = "from tests.virtual.random_rapid import program; print(program(3).text, end='')"
    own = os.environ.get("PYTHONHASHSEED", "")
    other = subprocess.run(
        [sys.executable, "-c", said],
        env={**os.environ, "PYTHONHASHSEED": "1" if own != "1" else "2"},
        cwd=ROOT,
        capture_output=True,
        text=True,
        check=True,
    )
    assert other.stdout == program(3).text
