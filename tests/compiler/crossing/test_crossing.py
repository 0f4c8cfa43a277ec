"""A small case of each kind of construct in both directions, whose two sides do the same when run.

A case is a table of a file in `rapid/` or `melfa/`: what it begins with is what crosses.

program: statements of the main program. data, routines: what else there is. process: the text of
a process file; what neither states is filled in as in a neutral cell. stays: how the statements
begin that are not said; without any, both programs are run and compared. told: codes of findings.
writes, lacks: what the text of the other language has and has not. runs: how many of them suffice,
where more take no other branch.
"""

from __future__ import annotations

import tomllib
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from assistant.base.source_text import SourceText
from assistant.compiler.cell_defaults import with_neutral_cell
from assistant.compiler.loader import load_text, with_process
from assistant.compiler.motion_proof import Proving
from assistant.compiler.translation import Translation, translate

HERE = Path(__file__).parent
TEXTS = {
    "rapid": r"""MODULE Cell
CONST robtarget near:=[[400,0,400],[0,0,1,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
CONST robtarget far:=[[400,100,420],[0,0,1,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
{data}
PROC main()
{program}
ENDPROC
{routines}
ENDMODULE
""",
    "melfa": """{program}
End
{routines}
P1=(+400.00,+0.00,+400.00,+180.00,+0.00,+180.00)(7,0)
P2=(+400.00,+100.00,+420.00,+180.00,+0.00,+180.00)(7,0)
P3=(+450.00,+50.00,+420.00,+180.00,+0.00,+180.00)(7,0)
{data}
""",
}
LANGUAGES = {"rapid": ("rapid", "melfa-basic-6"), "melfa": ("melfa-basic-6", "rapid")}
MOST_RUNS = 40
FIELDS = {
    "program", "data", "routines", "process", "language", "stays", "told", "writes", "lacks",
    "runs", "slow",
}  # fmt: skip


def cases() -> Iterator[Any]:
    for kind in LANGUAGES:
        for file in sorted((HERE / kind).glob("*.toml")):
            for name, case in tomllib.loads(file.read_text("utf-8")).items():
                assert set(case) <= FIELDS, name
                marks = [pytest.mark.slow] if case.get("slow") else []
                named = f"{kind}: {file.stem}: {name}"
                yield pytest.param(kind, case, id=named, marks=marks)


def crossed(kind: str, case: dict[str, Any], folder: Path) -> Translation:
    """What becomes of a case, in a cell that states no more than it needs."""
    written, to = LANGUAGES[kind]
    parts = {part: case.get(part, "") for part in ("program", "data", "routines")}
    text = SourceText(TEXTS[kind].format(**parts))
    loaded = load_text(text, language=case.get("language", written))
    if "process" in case:
        process = folder / "cell.process.toml"
        process.write_text(case["process"], encoding="utf-8")
        loaded = with_process(loaded, process)
    proving = Proving(seconds=2, runs=case.get("runs", MOST_RUNS))
    return translate(with_neutral_cell(loaded), to=to, proving=proving)


@pytest.mark.parametrize(("kind", "case"), [*cases()])
def test_it_does_the_same(kind: str, case: dict[str, Any], tmp_path: Path) -> None:
    done = crossed(kind, case, tmp_path)
    reasons = {row.text: [f.message for f in row.reasons] for row in done.rows}
    kept = [row.text for row in done.rows if row.level == "not"]
    begins = [text[: len(part)] for text, part in zip(kept, case.get("stays", ()), strict=False)]
    assert len(kept) == len(begins), {text: reasons[text] for text in kept}
    assert begins == case.get("stays", [])
    codes = {f.code for f in done.findings} | {f.code for row in done.rows for f in row.reasons}
    assert set(case.get("told", ())) <= codes
    text = "".join(map(str, done.files.values()))
    assert [part for part in case.get("writes", ()) if part not in text] == [], text
    assert [part for part in case.get("lacks", ()) if part in text] == [], text
    if not kept:
        assert done.ok, [f.message for f in done.findings]
        assert done.motion is not None and done.motion.holds, done.motion
        assert done.motion.found is not None
