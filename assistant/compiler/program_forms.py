"""Forms of programs made from drawings and tables: constants, offsets and arrays.

    [style]                       # in the process file or assistant.toml
    points = "offsets"            # or "targets", "arrays"
    constants = true

A program gets its form last, because its arm is solved with plain targets. Heights, speeds and
blends that are used often get names; the targets of a contour become offsets of its start, or the
targets of a path an array. `unfolded` reverses the form independently: it follows the program as a
controller does, so that the written program is compared with the plain one.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import replace
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from assistant.base.data_classes import dataclass
from assistant.base.diagnostics import Diagnostic, Severity, error, warning
from assistant.compiler.constant_forms import FOLLOWING, NamedConstants
from assistant.compiler.point_forms import ArrayForm, OffsetForm
from assistant.compiler.unfolding import NotUnfolded, unfolded
from assistant.program import expressions as e
from assistant.program import statements as p
from assistant.program.analysis.uses import declared
from assistant.program.comparison import Tolerance, compare
from assistant.program.motion import Kind, Path
from assistant.program.program import Procedure, Program, TakenNames, identifier, walk
from assistant.sources.contours.contour_shapes import number_text
from assistant.sources.process import ProgramStyle

if TYPE_CHECKING:
    from assistant.languages import Language

FORM_REFUSED: Final = warning(
    "CO622",
    "the form that [style] states is left out: {language} cannot express it ({reason})",
    'write points = "targets" in [style], or constants = false if the points are targets',
)
FORM_DIFFERS: Final = error(
    "CO623",
    "the program in the form of [style] differs from the one with plain targets: {message}",
    'write points = "targets" and constants = false in [style]; report this with the input',
)


@dataclass(frozen=True, slots=True)
class Formed:
    """A program in the form of a style, the given one if nothing changed, and findings."""

    program: Program
    findings: tuple[Diagnostic, ...] = ()


def with_structure(program: Program, style: ProgramStyle) -> Program:
    """Return a program with procedures for paths of tables, and comments for these and locations.

    Its moves stay as they are.
    """
    program = _with_path_procedures(program, style)
    return _with_location_notes(program) if style.commented else program


def with_form(program: Program, style: ProgramStyle, language: Language[Any]) -> Formed:
    """Return a program with the points and constants of a style."""
    findings: tuple[Diagnostic, ...] = ()
    if style.points == "offsets":
        program, findings = OffsetForm(program).program()
    elif style.points == "arrays":
        program, findings = ArrayForm(program).program()
    if style.constants is not False:
        program = NamedConstants(program, language, commented=style.commented).program()
    return Formed(program, findings)


def form_refused(found: Iterable[Diagnostic], language: Language[Any]) -> Diagnostic:
    """Return the finding that a language cannot express a form. found: findings with its errors."""
    reason = next(one.message for one in found if one.severity is Severity.ERROR)
    return FORM_REFUSED(language=language.title, reason=reason)


def form_differences(
    plain: Program, written: Program, language: Language[Any]
) -> Iterator[Diagnostic]:
    """Yield the differences, move by move, between a plain program and the text in its form."""
    precision = language.precision
    # A sum of two rounded positions has twice the rounding error.
    tolerance = Tolerance(2.0 * precision.position, precision.angle, precision.number)
    try:
        comparison = compare(unfolded(plain), unfolded(written), tolerance)
    except NotUnfolded as unknown:
        yield FORM_DIFFERS(message=str(unknown))
        return
    for one in comparison.mismatches:
        yield FORM_DIFFERS(message=one.message, about=one.about)


# ------------------------------------------------------------------- procedures of tables


def _with_path_procedures(program: Program, style: ProgramStyle) -> Program:
    """Return a program of paths alone, as of a table, with a procedure and a comment for each."""
    if len(program.procedures) != 1 or style.procedures == "none":
        return program
    (main,) = program.procedures
    paths = [node.path for node in main.body if isinstance(node, p.Follow)]
    if not paths or any(not isinstance(node, p.Follow | p.Move) for node in main.body):
        return program
    taken = TakenNames((program.name, main.name, *declared(program)))
    made: list[Procedure] = []
    body: list[p.Statement] = []
    for node in main.body:
        if not isinstance(node, p.Follow):
            body.append(node)
            continue
        # The path keeps its name, which its rows have; a single path often has the program's.
        own = node.path.name.lower() not in {one.lower() for one in taken}
        name = node.path.name if own else identifier(f"{FOLLOWING}{node.path.name}", taken)
        taken.add(name)
        notes = (p.Comment(p.OwnText(_path_text(node.path))),) if style.commented else ()
        made.append(Procedure(name, (*notes, node)))
        body.append(p.Call(name, span=node.span))
    return replace(program, procedures=(replace(main, body=tuple(body)), *made))


def _with_location_notes(program: Program) -> Program:
    """Return a program with the number of locations in a comment of each of their procedures."""
    entry = program.procedure(program.entry or "")
    called = {
        x.procedure.lower() for x in walk(entry.body if entry else ()) if isinstance(x, p.Call)
    }

    def noted(procedure: Procedure) -> Procedure:
        body = procedure.body
        moves = [node for node in body if isinstance(node, p.Move)]
        if procedure.name.lower() not in called or len(moves) < len(body):
            return procedure
        names = list(dict.fromkeys(x.target.name for x in moves if isinstance(x.target, e.Name)))
        if not names:
            return procedure
        text = f"{len(names)} location{'s' * (len(names) != 1)}: {names[0]}"
        text += f" to {names[-1]}" if len(names) > 1 else ""
        return replace(procedure, body=(p.Comment(p.OwnText(text)), *body))

    procedures = tuple(map(noted, program.procedures))
    changed = any(a is not b for a, b in zip(procedures, program.procedures, strict=True))
    return replace(program, procedures=procedures) if changed else program


def _path_text(path: Path) -> str:
    """Describe a path for people: `seam: 35 points, 412 mm`."""
    text = f"{path.name}: {len(path)} point{'s' * (len(path) != 1)}"
    rows = np.flatnonzero(path.kinds[1:] == Kind.LINEAR) + 1
    # Arcs and joint moves are not as long as their chords.
    if len(rows) and not ((path.kinds == Kind.VIA) | (path.kinds == Kind.END)).any():
        steps = np.linalg.norm(path.positions[rows] - path.positions[rows - 1], axis=1)
        text += f", {number_text(round(float(steps.sum()), 1))} mm"
    return text
