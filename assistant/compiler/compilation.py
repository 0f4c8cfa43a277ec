"""Compilation: a source or pseudo-program into the proven files of a robot language.

The written text is read back and compared before it is given out; a motion proof is made if one is
asked for.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import field, replace
from pathlib import Path as FilePath
from typing import TYPE_CHECKING, Any, Final

from assistant.base.budgets import COMPILING, PRINTING, staged, within
from assistant.base.data_classes import dataclass
from assistant.base.diagnostics import (
    Diagnostic,
    Refused,
    Severity,
    Span,
    error,
    fold,
    has_errors,
    warning,
)
from assistant.checks import check, with_robot
from assistant.checks.program_rules import group_values
from assistant.compiler.arithmetic import arithmetic_findings
from assistant.compiler.arms import (
    Arms,
    InCell,
    arms_of_loaded,
    known_robot,
    open_cell,
    robot_of,
    teaching_arm,
    with_robot_of_cell,
)
from assistant.compiler.loader import (
    Loaded,
    language_of,
    with_entry,
    with_process,
)
from assistant.compiler.merge_edits.last_output import write_unedited
from assistant.compiler.motion_proof import (
    ComparisonTerms,
    MotionProof,
    Proving,
    prove_motion,
    unreached_visits,
    wire_names,
    written_pair,
)
from assistant.compiler.program_files import load
from assistant.compiler.program_forms import (
    form_differences,
    form_refused,
    with_form,
    with_structure,
)
from assistant.compiler.program_names import interface_findings, stated_interface, with_interface
from assistant.compiler.read_back_proof import READ_BACK_DIFFERS, Proof, prove_read_back
from assistant.compiler.retarget import (
    for_arm,
    has_free_turns,
    has_percent_joints,
    joint_angle_errors,
    with_chosen_turns,
    with_converted_joint_speeds,
    with_joint_percent,
    with_joint_speed,
    with_other_arm_named,
    without_unused_joint_targets,
)
from assistant.compiler.seen_frames import with_located_frames
from assistant.compiler.source_map import Places, at_moves
from assistant.compiler.style import (
    PLAIN_STYLE,
    Style,
    apply_style,
    findings_of_templates,
    style_beside,
    without_comments,
)
from assistant.compiler.travel import has_travels, with_planned_travels
from assistant.compiler.uncalled_routines import is_about_left_out, without_uncalled
from assistant.compiler.unit_proof import prove_by_unit
from assistant.compiler.work_locations import fold_unplaced_work, with_locations
from assistant.lazy import pictured
from assistant.program.expressions import Verbatim
from assistant.program.passes.legalisation import traced
from assistant.program.program import Origin, Program
from assistant.program.statement_index import statements_with
from assistant.program.statements import Opaque, Travel
from assistant.sources.sights import NOTHING_SEEN, Seeing

if TYPE_CHECKING:
    from assistant.cell.scene import Scene
    from assistant.languages import Language
    from assistant.languages.language_types import Adapted, Conversion, Frames, Sampling
    from assistant.robots import Robot
    from assistant.sources.process import ProgramStyle
    from assistant.sources.process.placement import DrawingPlacement


_OTHER_MAKER = warning(
    "CO003",
    "the controller of {robot} does not run {language}",
    "choose one of {languages}, or another robot",
)
_TOO_FEW = error(
    "CO004", "a unit of {most} targets is too small", "allow at least {least} targets a unit"
)
_VENDOR_TEXT_DIFFERS = error(
    "CO104",
    "`{text}` keeps its text, but would be read back as something else where it is written",
    "say it in statements with plain conditions and numbers",
)
_VENDOR_TEXT_SETTINGS = error(
    "CO107",
    "`{text}` keeps its text, and the settings of the moves around it, which would be written"
    " as well, change what it does",
    "say it in plain statements, or take the moves around it out of the program",
)
_UNIT_ALONE = error(
    "CO008",
    "`{name}` is no program, but a part that one loads while it runs",
    "name the program that loads it: its parts are read with it",
)
_LEAST_TARGETS: Final = 10
"""A unit must hold an arc with its start, and be worth a file."""


@dataclass(frozen=True, slots=True)
class Compiled:
    """Outcome of a compilation.

    files: bytes by file name, empty if any error forbids writing them. program: the pseudo-program
    as the language expresses it. source: the program that it was compiled from. found: every
    finding, which may include errors; those of the source have its spans alone. wanting: errors
    that follow from these, see `Adapted`. motion: the motion proof, None if not requested. path:
    file of the source, None if it has none. lacks_joint_speed: joint moves have a percentage alone,
    which the language cannot say, and nothing states mm/s for them.
    """

    program: Program
    language: str
    proof: Proof
    source: Program
    places: Places
    files: dict[str, bytes] = field(default_factory=dict)
    found: tuple[Diagnostic, ...] = ()
    wanting: tuple[Diagnostic, ...] = ()
    motion: MotionProof | None = None
    path: str | None = None
    lacks_joint_speed: bool = False

    @property
    def findings(self) -> tuple[Diagnostic, ...]:
        """Those that were found, at their lines, folded."""
        return fold(map(self.places.finding, self.found))

    def proof_lines(self) -> Iterator[str]:
        """Yield the results of the proofs, one line each."""
        yield f"text read back: {self.proof.line()}"
        if self.motion is not None:
            yield f"motion compared: {self.motion.line()}"

    @property
    def ok(self) -> bool:
        return bool(self.files) and self.proof.holds and not has_errors(self.found)

    def write(self, folder: str | FilePath, *, overwrite: bool = False) -> tuple[FilePath, ...]:
        """Writes the files into a folder, which is made; all of them or none.

        Gives where they are. Raises Refused with all findings where the program is not to be
        written, and where a file there was edited since it was written, unless `overwrite`; with
        exit status 2 where the folder cannot be written.
        """
        if not self.ok:
            raise Refused(*self.findings)
        return write_unedited(self.files, folder, source=self.path, overwrite=overwrite)

    def __repr__(self) -> str:
        count = len(self.findings)
        state = "proven" if self.ok else "not written"
        told = [state, *sorted(self.files), f"{count} finding{'s' * (count != 1)}"]
        return f"<Compiled {self.program.name} in {self.language}: {', '.join(told)}>"

    def _repr_html_(self) -> str:
        return pictured(self)


def compile(
    source: str | FilePath | Program | Loaded,
    *,
    language: str,
    robot: str | Robot | None = None,
    process: str | FilePath | None = None,
    unit: str | None = None,
    placement: DrawingPlacement | None = None,
    cell: str | FilePath | InCell | None = None,
    from_robot: str | Robot | None = None,
    most_targets: int | None = None,
    frames: Frames = "base",
    grammar: Sampling = "samples",
    entry: str | None = None,
    called: str | None = None,
    main: bool | None = None,
    proving: Proving | None = None,
    seeing: Seeing = NOTHING_SEEN,
    style: Style | None = None,
    jobs: int | None = None,
) -> Compiled:
    """Compile the source to a program of the language; read it back and compare it before
    returning.

    robot: whose arm runs it; chooses configurations and checks reach and limits. Default the
    program's robot, or the only one of its cell. cell: file of the cell: a program that touches
    anything there is not written; or the cell read from it, whose findings the caller reports.
    process: process file of a drawing or table; of a `Program` or a vendor program, whose tools,
    frames and signals it states anew. unit: length unit of a drawing, overriding its own.
    placement: of a drawing. from_robot: the arm that a vendor program was written for.
    most_targets: of one unit, for controllers that take less. frames: how a language without work
    objects expresses them, see `Language.with_frames`. grammar: `full` has the proof parse programs
    of more than 20,000 lines completely with lark. entry: the procedure that the program begins
    with, if not the one that its source states. called: the name that others call the program by;
    main: False for no procedure that runs all of it; both override the process file. proving:
    settings of a motion proof, None for none; without a requested proof no files are returned.
    seeing: source of frames located by cameras, if `cell` does not state it. style: of the written
    files, None for the style of the project that contains the source. jobs: processes that share
    the proof of a program of many units, None for one for each processor if there are more than 20
    units, else one. Raises Unreadable or Refused for input that cannot be used at all.
    """
    target = language_of(language).with_frames(frames).with_sampling(grammar)
    if most_targets is not None and most_targets < _LEAST_TARGETS:
        raise Refused(_TOO_FEW(most=most_targets, least=_LEAST_TARGETS), exit_status=2)
    stands = cell if isinstance(cell, InCell) else replace(open_cell(cell, robot), seeing=seeing)
    if isinstance(source, Program):
        loaded = Loaded(source)
        if process is not None:
            loaded = with_process(loaded, process)
    elif isinstance(source, Loaded):
        loaded = source
    else:
        arm = robot_of(from_robot)
        loaded = load(
            source,
            process=process,
            robot=arm,
            unit=unit,
            around=stands.around,
            placement=placement,
        )
        loaded = replace(loaded, findings=tuple(f.within(str(source)) for f in loaded.findings))
    program = with_entry(loaded.program, entry)
    program = with_interface(program, stated_interface(program.interface, called, main), target)
    arms = with_robot_of_cell(program, arms_of_loaded(loaded, stands.arms(robot_of(from_robot))))
    program, located = with_locations(program, arms)
    if located:
        raise Refused(*located)
    program, sights = with_located_frames(program, arms)
    path = None if isinstance(source, Program | Loaded) else str(source)
    if style is None:
        style = style_beside(program, loaded.text, None if path is None else FilePath(path))
    places = Places(program, loaded.text)
    compiled = compile_program(
        program, places, target, arms, most_targets, style, form=loaded.form, jobs=jobs
    )
    begun = entry if program.interface is None or program.origin is not None else None
    compiled = proven_by_motion(compiled, arms, proving, begun)
    about = () if isinstance(cell, InCell) else stands.findings
    found = (*loaded.findings, *about, *sights, *compiled.found)
    return replace(compiled, found=found, path=path)


def lowered_for_language(program: Program, target: Language[Any]) -> Program:
    """Lower a program's data for another language than its own."""
    origin = program.origin
    return program if origin is None else language_of(origin.language).told(program, target)


def proven_by_motion(
    compiled: Compiled, arms: Arms, proving: Proving | None, entry: str | None
) -> Compiled:
    """Return a program with its motion proof, if one is requested; without files if that fails."""
    if proving is None or not compiled.ok:
        return compiled
    pair = written_pair(compiled.source, compiled.program, compiled.language, compiled.files)
    warnings = {f.code for f in compiled.found if f.severity is Severity.WARNING}
    motion = prove_motion(
        pair, arms, proving, entry, ComparisonTerms(warnings=tuple(sorted(warnings)))
    )
    arm = arms.robot or known_robot(compiled.program.robot)
    if arm is not None:
        unreached = unreached_visits(motion, arm, wire_names(pair))
        motion = replace(motion, findings=(*motion.findings, *unreached))
    files = compiled.files if motion.holds else {}
    found = (*compiled.found, *motion.findings)
    return replace(compiled, motion=motion, files=files, found=found)


_TRAVEL_POINTS: Final = 5_000
"""Points that a planned travel counts as: its search alone may take half a minute."""


def _points(program: Program) -> int:
    """The size of a program, in the unit of the budget for compiling."""
    travels = sum(isinstance(statement, Travel) for statement in program.statements())
    return program.size() + _TRAVEL_POINTS * travels


@staged(COMPILING, lambda source, *_, **__: _points(source))
def compile_program(
    source: Program,
    places: Places,
    target: Language[Any],
    arms: Arms,
    most_targets: int | None = None,
    style: Style = PLAIN_STYLE,
    *,
    form: ProgramStyle | None = None,
    jobs: int | None = 1,
) -> Compiled:
    """A program, with the spans of its places, in the target language and a style.

    form: of a program that was made from a drawing or table. jobs: processes that share the proof
    of many units, None for the usual number.
    """
    program = source
    findings = list(check(program))
    arm = arms.robot or known_robot(program.robot)
    unlike = tuple[Diagnostic, ...]()
    # Constructs that only the source's language has are lowered for the target language.
    if source.origin is not None:
        said = language_of(source.origin.language).exported(program, target, arm)
        program, findings = traced("exported", said.program), [*findings, *said.findings]
        findings += (f for f in group_values(program) if f not in findings)  # of questions as well
        unlike = said.findings
    as_loaded = program
    # Joint values mean another pose on an arm other than the one that they were taught on.
    taught = teaching_arm(program, arms)
    if taught is not None or not arms.same:
        program, left = without_unused_joint_targets(program, target, taught, arms.robot)
        findings += (*left, *joint_angle_errors(program, target, taught, arms.robot))
    if arms.joint_percent is not None and target.joint_percent:
        program, changed = with_joint_percent(program, arms.joint_percent)
        findings += changed
    before = program
    if arm is not None:
        program, changed = for_arm(program, taught, arm)
        findings += changed
        traced("for-the-arm", program)
    if has_free_turns(program):
        program, changed = with_chosen_turns(program, arm, arms.scene)
        findings += changed
        # The proofs compare with the chosen turns, so they belong to the source from here on.
        source = before = traced("with-turns", program)
    if has_travels(program):
        ways = with_planned_travels(program, arm, arms.scene, places)
        findings += ways.findings
        # The planned travels are part of what is proven.
        source = before = program = traced("travelled", ways.program)
        if has_errors(ways.findings):
            compiled = Compiled(program, target.name, Proof(None), source, places)
            return replace(compiled, found=tuple(findings))
    # A converted dialect keeps its trees as they are: they cannot be split into units.
    conversion = target.convert(program, arm) if most_targets is None else None
    if conversion is not None:
        return _converted_dialect(conversion, findings, source, places, target, (arm, arms.scene))
    if source.origin is not None:
        spoken = language_of(source.origin.language)
        alone = all(procedure.unit is not None for procedure in program.procedures)
        if spoken.name != target.name and program.procedures and alone:
            findings.append(_UNIT_ALONE(name=program.name))
        findings += (
            *spoken.assumed(source, target.name),
            *arithmetic_findings(source, as_loaded, spoken, target),
        )
    if arm is not None:
        program = replace(program, robot=arm.name)
        if target.name not in arm.languages:
            findings.append(_other_maker_finding(arm, target))
        from assistant import robots

        solution = robots.solve_program(program, arm)
        traced("with-configurations", solution.program)
        program, changed = with_converted_joint_speeds(
            solution, before, taught, target.joint_percent, arms.joint_speed
        )
        traced("at-the-pace", program)
        solved = (*solution.findings, *with_robot(solution, scene=arms.scene))
        if taught is None:
            solved = tuple(with_other_arm_named(solved, program, arm))
        told = fold_unplaced_work(program, arm, at_moves(solved, solution.program, places))
        findings += (*told, *changed)
    if arms.joint_speed is not None and not target.joint_percent:
        program, changed = with_joint_speed(program, arms.joint_speed)
        findings += changed
    lacking = arms.joint_speed is None and not target.joint_percent and has_percent_joints(program)
    if form is not None:
        program = with_structure(program, form)
    adapted = target.adapt(program, arm, most_targets=most_targets)
    unformed: Adapted | None = None
    if form is not None and not has_errors(adapted.findings):
        formed = with_form(program, form, target)
        findings += formed.findings
        if formed.program is not program:
            shaped = target.adapt(formed.program, arm, most_targets=most_targets)
            if has_errors(shaped.findings):
                findings.append(form_refused(shaped.findings, target))
            else:
                adapted, unformed = shaped, adapted
    # A routine that is left out may have been the only caller of others: repeat until none is left.
    while source.origin is not None:
        rest = without_uncalled(program, (*unlike, *adapted.findings), target.name)
        if rest is None:
            break
        program, uncalled = rest
        findings = [one for one in findings if not is_about_left_out(one, uncalled)]
        unlike = tuple(one for one in unlike if not is_about_left_out(one, uncalled))
        findings += uncalled
        adapted = target.adapt(program, arm, most_targets=most_targets)
    findings += adapted.findings
    program = adapted.program
    if program.interface is not None:
        findings += interface_findings(program.interface, program, target)
    compiled = Compiled(program, target.name, Proof(None), source, places)
    if has_errors(findings):
        return replace(
            compiled, found=tuple(findings), wanting=adapted.wanting, lacks_joint_speed=lacking
        )
    if style.folder is None and unformed is None:
        by_unit = prove_by_unit(target, adapted, arm, jobs)
        if by_unit is not None:
            return replace(
                compiled, proof=by_unit.proof, files=by_unit.files, found=tuple(findings)
            )
    # One file for the program itself (None), and one for each of its units.
    units = dict.fromkeys([None, *(p.unit for p in program.procedures)])
    with within(PRINTING, None, program.size()):
        plain = {
            (unit, target.file_name(program, unit)): target.encode(target.built(adapted, arm, unit))
            for unit in units
        }
    styled = {
        name: apply_style(data, target, style, program, unit)
        for (unit, name), data in plain.items()
    }
    files = {name: one.data for name, one in styled.items()}
    framed = any(one.lines for one in styled.values())
    proof = prove_read_back(
        target, program, files, arm, reduced=without_comments if framed else None
    )
    # Without the templates the proof tells whether they or the translation are at fault.
    if framed and not proof.holds:
        unframed = prove_read_back(
            target, program, {name: data for (_, name), data in plain.items()}, arm
        )
        if unframed.holds:
            findings += findings_of_templates(proof.findings, styled)
            return replace(compiled, found=tuple(findings))
        proof = unframed
    if unformed is not None and proof.holds and proof.lifted is not None:
        # The read-back text does what the plain program does.
        unlike = tuple(form_differences(unformed.program, proof.lifted, target))
        proof = replace(proof, findings=(*proof.findings, *unlike))
    own = () if proof.holds else _own_faults(program.origin)
    findings += own or dict.fromkeys(_explained_proof(proof, program))
    kept = files if proof.holds else {}
    return replace(compiled, proof=proof, files=kept, found=tuple(findings))


def _converted_dialect(
    conversion: Conversion[Any],
    found: Sequence[Diagnostic],
    source: Program,
    places: Places,
    target: Language[Any],
    standing: tuple[Robot | None, Scene | None],
) -> Compiled:
    """A program of a sister dialect, whose trees were converted, for an arm in a cell."""
    arm, scene = standing
    findings = [*found, *(places.spanned(f) for f in conversion.findings)]
    if arm is not None:
        if target.name not in arm.languages:
            findings.append(_other_maker_finding(arm, target))
        from assistant import robots

        # positions stay as they are written, so branches that would be chosen are of no interest
        solution = robots.solve_program(replace(source, robot=arm.name), arm)
        findings += (f for f in solution.findings if f.severity is not Severity.INFO)
        findings += with_robot(solution, scene=scene)
    compiled = Compiled(source, target.name, Proof(None), source, places)
    if has_errors(findings):
        return replace(compiled, found=tuple(findings))
    with within(PRINTING, None, source.size()):
        files = {name: target.encode(tree) for name, tree in conversion.files.items()}
    proof = prove_read_back(target, source, files, arm, conversion.compared)
    own = () if proof.holds else _own_faults(source.origin)
    kept = files if proof.holds else {}
    found = (*findings, *(own or proof.findings))
    return replace(compiled, proof=proof, files=kept, found=found)


def _other_maker_finding(arm: Robot, target: Language[Any]) -> Diagnostic:
    languages = ", ".join(arm.languages)
    return _OTHER_MAKER(robot=arm.name, language=target.name, languages=languages)


def _own_faults(written: Origin | None) -> tuple[Diagnostic, ...]:
    """Errors that the source had before it was compiled: they tell why it cannot be proven."""
    if written is None:
        return ()
    found = language_of(written.language).check(written.trees)
    return tuple(f for f in found if f.severity is Severity.ERROR)


def _explained_proof(proof: Proof, program: Program) -> Iterator[Diagnostic]:
    """Yield the differences of the read-back proof, with a vendor statement as the cause.

    Settings that are read back as separate texts were written for moves, but also apply to vendor
    statements.
    """
    kept = {
        node.span: part.text
        for node, parts in statements_with(program, Verbatim)
        if node.span is not None
        for part in parts
    }
    texts = _vendor_texts(program)
    # The most likely cause first: a vendor statement that moves, a vendor expression, any other.
    cause = (
        _first_vendor_statement(program, moving=True)
        or next(iter(kept.items()), None)
        or _first_vendor_statement(program)
    )
    back = texts if proof.lifted is None else _vendor_texts(proof.lifted)
    beside, lost = bool(back - texts), next(iter(texts - back), None)
    for finding in proof.findings:
        same = finding.code == READ_BACK_DIFFERS.code and finding.line is None
        text = kept.get(finding.span) if same and finding.span else None
        if text is not None:
            yield _VENDOR_TEXT_DIFFERS(text=text, span=finding.span)
        elif same and beside and cause is not None:
            yield _VENDOR_TEXT_SETTINGS(text=cause[1], span=cause[0])
        elif same and lost is not None:
            yield _VENDOR_TEXT_DIFFERS(text=lost, span=finding.span)
        else:
            yield finding


def _first_vendor_statement(
    program: Program, *, moving: bool = False
) -> tuple[Span | None, str] | None:
    """Return the text and span of the first vendor statement.

    moving: only one that may move the robot.
    """
    for node in program.statements():
        if isinstance(node, Opaque) and (not moving or node.effect is None or node.effect.moves):
            return node.span, node.text
    return None


def _vendor_texts(program: Program) -> Counter[str]:
    """Texts of statements, and how often each is there."""
    return Counter(node.text for node in program.statements() if isinstance(node, Opaque))
