"""What a project's file says about the controllers of a language.

[melfa-basic]        # in assistant.toml; `[tool.robot-assistant.melfa-basic]` in pyproject.toml
name-length = 16
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path as FilePath
from typing import TYPE_CHECKING, Any, Final

from assistant.base.diagnostics import Diagnostic, Refused, error
from assistant.languages.language_types import Choice
from assistant.sources.project import Project, project_of

if TYPE_CHECKING:
    from assistant.languages import Language

UNKNOWN_LANGUAGE_SETTING: Final = error(
    "CO304", "`{key}` is no setting of {table}", "write one of {settings}"
)
SETTING_OUT_OF_RANGE: Final = error(
    "CO305", "`{key}` is {value}, no whole number from {least} to {most}",
    "{meaning}"
)  # fmt: skip
SETTING_NO_CHOICE: Final = error("CO307", "`{key}` is {value!a}, none of {words}", "{meaning}")
LANGUAGE_SETTINGS_NO_TABLE: Final = error(
    "CO306", "`{table}` is no table", "write lines such as {setting} = {value} in it"
)


def with_project_settings(language: Language[Any], folder: FilePath) -> Language[Any]:
    """The language with what the project of a folder says about its controllers.

    Raises Unreadable or Refused, both of exit status 2, if the project's file is broken.
    """
    if not language.settings:
        return language
    project = project_of(folder)
    content = project.content if project is not None else None
    if project is None or not isinstance(content, Mapping) or language.table not in content:
        return language
    return language.configured(_read_language_settings(project, language, content[language.table]))


def _read_language_settings(
    project: Project, language: Language[Any], given: object
) -> dict[str, int | str]:
    at = (language.table,)
    table = "[" + ".".join((*project.table, *at)) + "]"
    if not isinstance(given, Mapping):
        name, first = next(iter(language.settings.items()))
        value = f'"{first.words[0]}"' if isinstance(first, Choice) else first.least
        finding = project.finding(
            LANGUAGE_SETTINGS_NO_TABLE, at, table=language.table, setting=name, value=value
        )
        raise Refused(finding, exit_status=2)
    found: list[Diagnostic] = []
    for key, value in given.items():
        setting = language.settings.get(key)
        if setting is None:
            known = ", ".join(language.settings)
            found.append(
                project.finding(
                    UNKNOWN_LANGUAGE_SETTING, (*at, key), key=key, table=table, settings=known
                )
            )
        elif isinstance(setting, Choice):
            if value not in setting.words:
                words = {"words": ", ".join(setting.words), "meaning": setting.meaning}
                at_key = (*at, key)
                found.append(
                    project.finding(SETTING_NO_CHOICE, at_key, key=key, value=value, **words)
                )
        elif type(value) is not int or not setting.least <= value <= setting.most:
            fields = {"least": setting.least, "most": setting.most, "meaning": setting.meaning}
            found.append(
                project.finding(SETTING_OUT_OF_RANGE, (*at, key), key=key, value=value, **fields)
            )
    if found:
        raise Refused(*found, exit_status=2)
    return dict(given)
