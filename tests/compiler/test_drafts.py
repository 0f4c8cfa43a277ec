"""Drafts: what cannot be said is left out, with what follows from it."""

from __future__ import annotations

from pathlib import Path

import pytest

import assistant
from assistant.program.passes.legalisation import pass_trace

RECORD = """MODULE parts
  RECORD part
    num weight;
  ENDRECORD
  VAR menudata held;
  VAR num first:=StrLen(ArgName(held));
  VAR num total:=0;

  PROC main()
    total:=total+held.weight;
    WaitTime 0.5;
    IF held.weight>3 THEN
      total:=held.weight;
    ENDIF
    total:=total+1;
  ENDPROC
ENDMODULE
"""
"""Nobody knows the parts of `held`: what reads it cannot be said either."""


@pytest.fixture
def module(tmp_path: Path) -> Path:
    file = tmp_path / "parts.mod"
    file.write_text(RECORD)
    return file


def test_what_a_declaration_is_wanting_for_is_left_out_with_it(module: Path) -> None:
    done = assistant.translate(module, to="melfa-basic-5", draft=True)
    assert done.draft
    wanting = [r.place.line for r in done.rows if [d.code for d in r.reasons] == ["CO007"]]
    assert wanting == [6, 10, 12, 13]  # the last stands in the one before
    (text,) = (data.decode("ascii") for data in done.files.values())
    assert "Dly 0.5" in text
    assert "' | IF held.weight>3 THEN" in text


def test_a_draft_is_said_once_whatever_follows_from_what(module: Path) -> None:
    said: list[str] = []
    with pass_trace(lambda name, _: said.append(name)):
        done = assistant.translate(module, to="melfa-basic-5", draft=True)
    assert done.draft
    assert said.count("sayable") == 2  # the program, and the draft
