"""What a project states of a source takes the place of options that are not given."""

from __future__ import annotations

from dataclasses import fields, is_dataclass, replace
from pathlib import Path
from typing import Any, TypeVar

T = TypeVar("T")


def with_project_defaults(source: str, options: T) -> T:
    """Options of a command, a record, with what the project of a source says of the rest.

    Raises Refused where it says several things.
    """
    if source == "-" or not Path(source).is_file():
        return options
    from assistant.project.stated import OPTIONS, SourceOptions, completed_options

    assert is_dataclass(options) and not isinstance(options, type)
    names = [field.name for field in fields(options) if field.name in OPTIONS]
    given = SourceOptions(**{name: getattr(options, name) for name in names})
    done = completed_options(source, given, names)
    changed: dict[str, Any] = {name: getattr(done, name) for name in names}
    return replace(options, **changed)
