"""Co-simulation models by FMI 2.0: variables, source in C, description, and compiled libraries.

Values are in a column of their type. The FMU has the same bytes for the same model. The compiler of
this system makes its library, cross compilers those of other systems.
"""

from __future__ import annotations

import hashlib
import importlib.util
import io
import shutil
import subprocess
import sys
import tempfile
import zipfile
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import field
from functools import cached_property
from pathlib import Path as FilePath
from typing import Any, Final, Literal

import assistant
from assistant.base.data_classes import dataclass
from assistant.base.diagnostics import Diagnostic, Refused
from assistant.blocks import rules
from assistant.blocks.code import SourceNames, number_literal, source_of, template_environment
from assistant.robots import Robot

VariableType = Literal["Real", "Integer", "Boolean", "String"]
Causality = Literal["parameter", "input", "output"]
_VARIABLE_TYPES: Final[tuple[VariableType, ...]] = ("Real", "Integer", "Boolean", "String")
_UNITS: Final = {
    "s": 's="1"',
    "deg": 'rad="1" factor="0.017453292519943295"',
    "mm": 'm="1" factor="0.001"',
    "deg/s": 'rad="1" s="-1" factor="0.017453292519943295"',
    "mm/s": 'm="1" s="-1" factor="0.001"',
    "deg/s2": 'rad="1" s="-2" factor="0.017453292519943295"',
    "mm/s2": 'm="1" s="-2" factor="0.001"',
}
"""Units of variables → their SI form, as a model description writes it."""

StartValue = float | int | bool | str


@dataclass(frozen=True, slots=True)
class Variable:
    """A variable. start: its value before anything is set; None for an output."""

    name: str
    description: str
    start: StartValue | None = None
    unit: str = ""


@dataclass(frozen=True, slots=True)
class Group:
    """Variables of one type beside each other; place: what the source calls the first one."""

    place: str
    type: VariableType
    causality: Causality
    variables: Sequence[Variable]


@dataclass(frozen=True, slots=True)
class _TypeColumn:
    """The values of one type in a source. kinds: a letter each. starts: literals of C."""

    kinds: str
    starts: Sequence[str]


@dataclass(frozen=True, slots=True)
class PlacedVariable:
    """A variable as a model description has it. reference: its place in the column of its type."""

    name: str
    description: str
    type: VariableType
    causality: Causality
    variability: str
    initial: str
    reference: int
    start: str | None
    unit: str


def _column_of_type(groups: Sequence[Group], type: VariableType) -> _TypeColumn:
    """The column of a type, with starts of 0 for outputs."""
    kinds, starts = "", []
    for group in groups:
        if group.type == type:
            kinds += group.causality[0] * len(group.variables)
            starts += [_c_literal(variable.start) for variable in group.variables]
    return _TypeColumn(kinds, starts)


def _group_offsets(groups: Sequence[Group]) -> Iterator[tuple[str, int]]:
    """Yield the name of each group and its offset in the column of its type."""
    counted = dict.fromkeys(_VARIABLE_TYPES, 0)
    for group in groups:
        yield group.place, counted[group.type]
        counted[group.type] += len(group.variables)


def _placed_variables(groups: Sequence[Group]) -> Iterator[PlacedVariable]:
    """The variables in their order, which is that of the groups."""
    for group, (_, first) in zip(groups, _group_offsets(groups), strict=True):
        for reference, one in enumerate(group.variables, first):
            varies = "continuous" if group.type == "Real" else "discrete"
            parameter = group.causality == "parameter"
            initial = {"parameter": "exact", "output": "calculated"}.get(group.causality, "")
            yield PlacedVariable(
                one.name,
                one.description,
                group.type,
                group.causality,
                "fixed" if parameter else varies,
                initial,
                reference,
                None if one.start is None else _xml_text(one.start),
                one.unit,
            )


def _c_literal(start: StartValue | None) -> str:
    if isinstance(start, str):
        return f'"{start}"'
    if isinstance(start, bool) or start is None:
        return str(int(start or False))
    return repr(start)


def _xml_text(start: StartValue) -> str:
    if isinstance(start, bool):
        return "true" if start else "false"
    return str(start)


_FILE_DATE: Final = (1980, 1, 1, 0, 0, 0)
"""Date of every file in an FMU, so that the same model gives the same bytes."""


@dataclass(frozen=True)
class Model:
    """A model that is written as C.

    identifier: of its library and functions. title, description: plain words for readers. template:
    in `templates/fmu/`. groups: its variables. robot: the robot whose kinematics it holds, if any.
    told: further values for the template. step, stop: seconds of the default experiment. any_step:
    whether steps may differ. copies: whether a state can be saved and restored. follows: places of
    the parameters that outputs depend on before the first step. libraries: further libraries that
    Windows needs.
    """

    identifier: str
    title: str
    description: str
    template: str
    groups: Sequence[Group]
    robot: Robot | None = None
    told: Mapping[str, Any] = field(default_factory=dict)
    step: float = 0.01
    stop: float = 10.0
    any_step: bool = True
    copies: bool = True
    follows: frozenset[str] = frozenset()
    libraries: tuple[str, ...] = ()

    @cached_property
    def sources(self) -> Mapping[str, bytes]:
        """The files of `sources/` by name; `model.c` includes the others."""
        words = self._words | {"guid": self.guid}
        return {
            "model.c": _render(f"{self.template}.c.j2", words),
            "fmi2.h": _render("fmi2.h.j2", words),
            **self._arm,
        }

    @cached_property
    def guid(self) -> str:
        """GUID of the model's contents; prevents a library with the description of another
        model.
        """
        words = self._words | {"guid": ""}
        parts = [
            _render(f"{self.template}.c.j2", words),
            self._described(""),
            *self._arm.values(),
        ]
        digest = hashlib.sha256(b"\0".join(parts)).hexdigest()
        return f"{{{digest[:8]}-{digest[8:12]}-{digest[12:16]}-{digest[16:20]}-{digest[20:32]}}}"

    @cached_property
    def _arm(self) -> Mapping[str, bytes]:
        """The kinematics of the arm, whose functions are called as the model is."""
        if self.robot is None:
            return {}
        named = SourceNames(f"{self.identifier}_arm", f"{self.identifier}_arm")
        return {f"{named.stem}{end}": source_of(self.robot, named, end) for end in (".h", ".c")}

    @property
    def variables(self) -> tuple[PlacedVariable, ...]:
        """Its variables in their order."""
        return tuple(_placed_variables(self.groups))

    @property
    def description_xml(self) -> bytes:
        """`modelDescription.xml`."""
        return self._described(self.guid)

    def packed(self, libraries: Mapping[str, bytes]) -> bytes:
        """The FMU. libraries: path below `binaries/` → compiled library."""
        files = {"modelDescription.xml": self.description_xml}
        files |= {f"sources/{name}": data for name, data in self.sources.items()}
        files |= {f"binaries/{path}": data for path, data in libraries.items()}
        out = io.BytesIO()
        with zipfile.ZipFile(out, "w", zipfile.ZIP_DEFLATED) as archive:
            for name, data in files.items():
                one = zipfile.ZipInfo(name, _FILE_DATE)
                one.compress_type = zipfile.ZIP_DEFLATED
                one.external_attr = 0o644 << 16
                archive.writestr(one, data)
        return out.getvalue()

    def _described(self, guid: str) -> bytes:
        variables = self.variables
        used = {one.unit for one in variables}
        begins = {i for i, place in enumerate(self._group_of, 1) if place in self.follows}
        words = {
            "title": self.title,
            "description": self.description,
            "identifier": self.identifier,
            "guid": guid,
            "version": assistant.__version__,
            "any_step": self.any_step,
            "copies": self.copies,
            "units": [
                {"name": name, "base": base} for name, base in _UNITS.items() if name in used
            ],
            "step": number_literal(self.step),
            "stop": number_literal(self.stop),
            "variables": variables,
            "outputs": [i for i, one in enumerate(variables, 1) if one.causality == "output"],
            "initial_dependencies": sorted(begins),
        }
        return _render("modelDescription.xml.j2", words)

    @property
    def _group_of(self) -> list[str]:
        """The place of the group of each variable."""
        return [group.place for group in self.groups for _ in group.variables]

    @property
    def _words(self) -> dict[str, Any]:
        """Return the values for a template, without the GUID."""
        arm = None if self.robot is None else f"{self.identifier}_arm"
        return {
            "title": self.title,
            "identifier": self.identifier,
            "macro": self.identifier.upper(),
            "prefix": arm,
            "arm_stem": arm,
            "copies": self.copies,
            "reals": _column_of_type(self.groups, "Real"),
            "integers": _column_of_type(self.groups, "Integer"),
            "booleans": _column_of_type(self.groups, "Boolean"),
            "strings": _column_of_type(self.groups, "String"),
            "places": list(_group_offsets(self.groups)),
            "tables": [],
            **self.told,
        }


def _render(template: str, words: Mapping[str, Any]) -> bytes:
    return template_environment().get_template(f"fmu/{template}").render(words).encode()


_COMPILER_TIMEOUT: Final = 300.0
"""Seconds of a compiler; zig makes its own C library when it is first used, which takes 80."""
_COMPILER_FLAGS: Final = ("-std=c99", "-O2", "-shared", "-fvisibility=hidden", "-ffp-contract=off")
"""No contraction: a product and a sum are rounded each, as numpy does."""
_PREFIX_FLAG: Final = "-DFMI2_OVERRIDE_FUNCTION_PREFIX"


@dataclass(frozen=True, slots=True)
class _Platform:
    """Target platform of the libraries.

    name: as FMI writes it, and the folder in `binaries/`. ending: of its libraries. commands:
    compilers for it, of which the first installed one is used. target: its name for zig. flags:
    extra compiler flags. needed: software to install for it.
    """

    name: str
    ending: str
    commands: tuple[str, ...]
    target: str
    flags: tuple[str, ...] = ()
    needed: str = ""


PLATFORMS: Final = {
    "linux64": _Platform(
        "linux64", ".so", ("gcc", "cc", "clang"), "x86_64-linux-gnu.2.17", ("-fPIC",), "gcc"
    ),
    "win64": _Platform(
        "win64",
        ".dll",
        ("x86_64-w64-mingw32-gcc",),
        "x86_64-windows-gnu",
        (),
        "mingw-w64 or the Python package ziglang",
    ),
    "darwin64": _Platform(
        "darwin64", ".dylib", (), "x86_64-macos", ("-fPIC",), "the Python package ziglang"
    ),
}
"""Names of FMI 2.0 → platforms."""


def this_platform() -> str:
    """The platform of this machine."""
    systems = {"linux": "linux64", "win32": "win64", "darwin": "darwin64"}
    return systems.get(sys.platform, "")


def compiled(model: Model, *, everywhere: bool = False) -> tuple[bytes, tuple[Diagnostic, ...]]:
    """The FMU of a model with its libraries, and what could not be made.

    everywhere: also for systems that this machine is not, by what cross compilers there are.
    Raises Refused where a compiler fails.
    """
    own = this_platform()
    wanted = [own, *(name for name in PLATFORMS if everywhere and name != own)]
    libraries, findings = {}, []
    for name in wanted:
        command = _compiler_command(name, own)
        if command is not None:
            platform = PLATFORMS[name]
            path = f"{name}/{model.identifier}{platform.ending}"
            libraries[path] = _compile_library(model, platform, command)
        elif name == own:
            findings.append(rules.NO_COMPILER())
        else:
            needed = PLATFORMS[name].needed
            findings.append(rules.NO_CROSS_COMPILER(platform=name, what=needed))
    return model.packed(libraries), tuple(findings)


def _compiler_command(name: str, own: str) -> list[str] | None:
    """Return the compiler command for a platform, None if no compiler is installed."""
    platform = PLATFORMS.get(name)
    if platform is None:
        return None
    commands = ("cc", "clang", "gcc") if name == own else platform.commands
    found = next(filter(None, map(shutil.which, commands)), None)
    if found is not None:
        return [found]
    zig = shutil.which("zig")
    if zig is not None:
        return [zig, "cc", "-target", platform.target]
    if importlib.util.find_spec("ziglang") is not None:
        return [sys.executable, "-m", "ziglang", "cc", "-target", platform.target]
    return None


def _compile_library(model: Model, platform: _Platform, command: list[str]) -> bytes:
    with tempfile.TemporaryDirectory() as name:
        folder = FilePath(name)
        for file, data in model.sources.items():
            (folder / file).write_bytes(data)
        output = f"{model.identifier}{platform.ending}"
        words = [*command, *_COMPILER_FLAGS, *platform.flags, _PREFIX_FLAG, "model.c", "-o", output]
        words += _linked_libraries(model, platform)
        try:
            done = subprocess.run(  # noqa: S603 - a compiler of the system, on our own source
                words,
                cwd=folder,
                capture_output=True,
                text=True,
                timeout=_COMPILER_TIMEOUT,
                check=False,
            )
            reason = done.stderr.strip().splitlines()[:1] if done.returncode else []
            if done.returncode == 0:
                return (folder / output).read_bytes()
        except (OSError, subprocess.TimeoutExpired) as wrong:
            reason = [str(wrong)]
    said = reason[0] if reason else "it says nothing"
    raise Refused(rules.NOT_COMPILED(compiler=command[0], reason=said), exit_status=2)


def _linked_libraries(model: Model, platform: _Platform) -> list[str]:
    """Return the linker flags: the mathematics library, or on Windows the libraries of the
    model.
    """
    if platform.name == "win64":
        return [f"-l{library}" for library in model.libraries]
    return ["-lm"]
