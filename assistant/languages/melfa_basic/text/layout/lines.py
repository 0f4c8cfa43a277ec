"""One layout for every MELFA-BASIC text: blanks, indentation, comments, position lines.

    1 Function Main
    2     If M_In(8)=1 Then      ' comments behind lines that stood aligned
    3         Mov P1,-50         ' stay aligned
    4     EndIf
    5 FEnd
    P1=(+400.00,-200.00,+438.33,+180.00,+0.00,+88.09)(7,0)

Step numbers, names, numbers and strings stay as they are written, keywords become as the
makers' tools spell them. Programs of MELFA-BASIC IV are not indented.
"""

from __future__ import annotations

from assistant.languages.melfa_basic.text.lines import Lines
from assistant.languages.melfa_basic.tree import syntax as s
from assistant.languages.texts import line_text


def lay_out(file: s.File) -> str:
    """The text of a file that was read and has no syntax error in the one layout; idempotent.

    Line ends become the ones that most lines have.
    """
    assert file.source is not None
    return line_text.lay_out(file.source, Lines(file))
