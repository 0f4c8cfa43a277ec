"""`pose`: a pose, or the columns of a table, as other controllers and libraries write it."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Final

from assistant.base.diagnostics import Refused, error
from assistant.cli.command import Option, argument, command, option
from assistant.cli.options import FormatOption
from assistant.cli.presentation import LengthUnit, print_answer, say

if TYPE_CHECKING:
    from assistant.program.se3 import Unit

_NO_UNIT: Final = error(
    "CL076",
    "nothing says whether the position is in mm or m, as {title} leave it open",
    "add --unit mm or --unit m",
)
_NO_TABLE: Final = error(
    "CL077",
    "--{option} is of tables, and `{given}` is read as a pose",
    "name a table that ends in .csv, .tsv or .txt, or leave --{option} out",
)
_TABLE: Final = (".csv", ".tsv", ".txt")


def _names(typed: str) -> list[str]:
    from assistant.languages.pose_conventions import conventions

    return [name for name in conventions() if name.startswith(typed)]


_UnitOption = Annotated[
    LengthUnit | None,
    Option("Unit of the given positions; mm of a controller's own convention if left out."),
]
_ToUnitOption = Annotated[
    LengthUnit | None, Option("Unit of the written positions; default the controller's own.")
]


@command
class Pose:
    """Convert a pose, or those of a table, between the conventions of controllers and libraries.

    Conventions: rapid (quaternion w x y z), melfa (A B C about X Y Z), kuka (A B C about Z Y X),
    fanuc (W P R), rotation-vector (rx ry rz, radians), xyzw (quaternion x y z w), matrix.
    """

    values: tuple[str, ...] = argument(
        "A pose as programs write it, its numbers, or a table (CSV).", metavar="POSE|FILE"
    )
    source: str = option(
        "Convention of the pose.", "--from", metavar="CONVENTION", completions=_names
    )
    target: str | None = option(
        "Convention to write; all of them if left out, of a table the first.",
        "--to",
        metavar="CONVENTION",
        completions=_names,
        default=None,
    )
    unit: _UnitOption
    to_unit: _ToUnitOption
    columns: str | None = option(
        "Columns of a table that hold the pose, in the order of the convention.",
        metavar="NAME,NAME,…",
        default=None,
    )
    output: Path | None = option(
        "File for the converted table.", "--output", "-o", metavar="FILE", default=None
    )
    format: FormatOption

    def run(self) -> int:
        from assistant.compiler.pose_tables import convert_table
        from assistant.program.settings_tables import shown

        unit: Unit | None = self.unit.value if self.unit else None
        to_unit: Unit | None = self.to_unit.value if self.to_unit else None
        name = self.values[0] if len(self.values) == 1 else ""
        if not name.lower().endswith(_TABLE):
            for option, value in (("columns", self.columns), ("output", self.output)):
                if value is not None:
                    given = shown(" ".join(self.values), 40)
                    raise Refused(_NO_TABLE(option=option, given=given), exit_status=2)
            return self._one(unit, to_unit)
        from assistant.base.file_sets import write_files
        from assistant.cli.source_input import keep_sources
        from assistant.languages.pose_conventions import conventions

        target = self.target or next(iter(conventions()))
        data = convert_table(
            Path(name),
            self.source,
            target,
            unit=unit,
            to_unit=to_unit,
            columns=() if self.columns is None else self.columns.split(","),
        )
        if self.output is None:
            say(data.decode().rstrip("\n"))
            return 0
        keep_sources([name], [self.output])
        written = write_files({self.output.name: data}, self.output.parent)
        print_answer(self.format, {"ok": True}, (), (), written)
        return 0

    def _one(self, unit: Unit | None, to_unit: Unit | None) -> int:
        from assistant.compiler.pose_tables import column_names, number_texts
        from assistant.languages import pose_conventions as pose

        given = pose.parse(" ".join(self.values), self.source)
        if unit is None and pose.convention(self.source).unit is None:
            raise Refused(_NO_UNIT(title=pose.convention(self.source).title), exit_status=2)
        there = to_unit or unit or pose.convention(self.source).unit
        names = [self.target] if self.target else list(pose.conventions())
        record, lines = {}, []
        width = max(map(len, names))
        for name in names:
            shown = pose.convention(name)
            kept = to_unit or shown.unit or there
            (row,) = pose.convert(given, self.source, name, unit=unit, to_unit=kept)
            texts = number_texts(row, shown, kept)
            record[shown.name] = dict(zip(column_names(shown, kept), row.tolist(), strict=True))
            start = f"{shown.name:{width}}  " if len(names) > 1 else ""
            if shown.form == "matrix":
                rows = [" ".join(texts[i : i + 4]) for i in range(0, 16, 4)]
                starts = [start, *[" " * len(start)] * 3]
                lines += [begin + one for begin, one in zip(starts, rows, strict=True)]
                continue
            said = ", ".join(column_names(shown, kept)) if len(names) > 1 else ""
            lines.append(f"{start}{' '.join(texts)}" + (f"   ({said})" if said else ""))
        print_answer(self.format, {"ok": True, "poses": record}, lines, ())
        return 0
