"""A model for co-simulation by FMI 2.0: its source in C, its description, the file of both."""

from __future__ import annotations

import hashlib
import io
import zipfile
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any, Final

import assistant
from assistant.blocks.code.kinematics import SourceNames, source_of
from assistant.blocks.code.templates import number_literal, template_environment
from assistant.blocks.fmu.variables import (
    UNITS,
    Group,
    PlacedVariable,
    column_of_type,
    group_offsets,
    placed_variables,
)
from assistant.robots import Robot

FILE_DATE: Final = (1980, 1, 1, 0, 0, 0)
"""Of every file in an FMU, so that the same model gives the same bytes."""


@dataclass(frozen=True)
class Model:
    """A model that is written as C.

    identifier: of its library and functions. title, description: for people; plain words.
    template: of `templates/fmu/`. groups: its variables. robot: whose kinematics it holds, if any.
    told: what the template is told beside that. step, stop: seconds of the usual experiment.
    any_step: whether steps may differ. copies: whether a state can be kept and gone back to.
    follows: places of the parameters that outputs depend on before the first step.
    libraries: that Windows needs beside its own.
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
        """Of what the model is, so that a library and a description of others do not fit."""
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
        return tuple(placed_variables(self.groups))

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
                one = zipfile.ZipInfo(name, FILE_DATE)
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
            "units": [{"name": name, "base": base} for name, base in UNITS.items() if name in used],
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
        """What a template is told, but for the GUID."""
        arm = None if self.robot is None else f"{self.identifier}_arm"
        return {
            "title": self.title,
            "identifier": self.identifier,
            "macro": self.identifier.upper(),
            "prefix": arm,
            "arm_stem": arm,
            "copies": self.copies,
            "reals": column_of_type(self.groups, "Real"),
            "integers": column_of_type(self.groups, "Integer"),
            "booleans": column_of_type(self.groups, "Boolean"),
            "strings": column_of_type(self.groups, "String"),
            "places": list(group_offsets(self.groups)),
            "tables": [],
            **self.told,
        }


def _render(template: str, words: Mapping[str, Any]) -> bytes:
    return template_environment().get_template(f"fmu/{template}").render(words).encode()
