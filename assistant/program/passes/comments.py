"""Comments, and messages that become some, in the lines and letters that a language takes."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import ClassVar

from assistant.program import expressions as e
from assistant.program import statements as p
from assistant.program.letters import in_ascii
from assistant.program.passes.legalising import Legalisation
from assistant.program.passes.rewording import Changes, Rewording
from assistant.program.program import Program


def plain_comment(r: Rewording, node: p.Comment) -> Iterator[p.Statement]:
    """A comment in lines that the language takes."""
    yield from (replace(node, text=line) for line in comment_lines(node.text, r.job))


def as_comment(r: Rewording, node: p.Message) -> Iterator[p.Statement]:
    """A message as a comment, for a language without any."""
    shown = "".join(part.value if isinstance(part, e.Text) else "..." for part in node.parts)
    line = comment_lines("message: " + shown, r.job)[0]
    if r.job.can.comments.message is not None:
        r.job.findings.append(r.job.can.comments.message(text=line))
    yield p.Comment(line)


class _InLines(Rewording):
    changes: ClassVar[Changes] = {p.Comment: plain_comment}


def with_plain_comments(job: Legalisation) -> Program:
    """The program with comments, and the name of its robot, in lines that the language takes."""
    said, program = _InLines(job), job.program
    return replace(
        program,
        comments=tuple(line for text in program.comments for line in comment_lines(text, job)),
        robot=program.robot and " ".join(comment_lines(program.robot, job)),
        procedures=tuple(map(said.procedure, program.procedures)),
    )


def comment_lines(text: str, job: Legalisation) -> list[str]:
    """A comment in lines that fit; control characters become blanks."""
    can = job.can.comments
    plain = in_ascii(text) if can.ascii else text
    plain = "".join(c if c.isprintable() else " " for c in plain).strip()
    if plain != text.strip():
        job.changed(f"the comment `{text.strip()}`", f"`{plain}`", "use one line of ASCII")
    made: list[str] = []
    while can.most_bytes is not None and len(plain.encode("utf-8")) > can.most_bytes:
        most = can.most_bytes
        while len(plain[:most].encode("utf-8")) > can.most_bytes:
            most -= 1
        cut = plain.rfind(" ", most // 2, most)
        cut = most if cut < 0 else cut
        made.append(plain[:cut].strip())
        plain = plain[cut:].strip()
    return [*made, plain]
