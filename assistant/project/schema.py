"""The JSON schema of assistant.toml, for editors: printed from the tables that its readers use."""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import Final

from assistant import languages
from assistant.controllers.named import NAME as CONTROLLER_NAME
from assistant.findings.severities import LEVELS, TABLE
from assistant.languages.language_types import Choice, Setting
from assistant.project.tables import CONTROLLER, DEPLOYING, NAME, PROGRAM, STYLE, TARGET, Key
from assistant.sources.project_file import CONTROLLERS, DEPLOY, PROGRAMS, TARGETS
from assistant.sources.project_file import STYLE as STYLE_TABLE

FILE: Final = "assistant.schema.json"
DRAFT: Final = "http://json-schema.org/draft-07/schema#"
Schema = dict[str, object]


def schema() -> Schema:
    """Of a whole file."""
    controller = _table(CONTROLLER, "address")
    of_languages = {}
    for language in map(languages.get, languages.names()):
        if language.table:
            of_languages[language.table] = _settings(language.settings)
    return {
        "$schema": DRAFT,
        "title": "assistant.toml of robot-assistant",
        "type": "object",
        "properties": {
            CONTROLLERS: _named(
                CONTROLLER_NAME.pattern, {"anyOf": [CONTROLLER["address"].form, controller]}
            ),
            PROGRAMS: _named(NAME.pattern, _table(PROGRAM, "source")),
            TARGETS: _named(NAME.pattern, _table(TARGET, "programs")),
            DEPLOY: _table(DEPLOYING),
            STYLE_TABLE: _table(STYLE),
            TABLE: {"type": "object", "additionalProperties": {"enum": list(LEVELS)}},
            **of_languages,
        },
        "additionalProperties": False,
    }


def schema_text() -> str:
    return json.dumps(schema(), indent=2, ensure_ascii=False) + "\n"


def _table(keys: Mapping[str, Key], *required: str) -> Schema:
    rows = {name: {**key.form, "description": key.about} for name, key in keys.items()}
    table: Schema = {"type": "object", "properties": rows, "additionalProperties": False}
    return {**table, "required": list(required)} if required else table


def _named(pattern: str, content: Schema) -> Schema:
    names = {"pattern": f"^(?:{pattern})$"}
    return {"type": "object", "propertyNames": names, "additionalProperties": content}


def _settings(settings: Mapping[str, Setting | Choice]) -> Schema:
    rows: Schema = {}
    for name, one in settings.items():
        if isinstance(one, Choice):
            form: Schema = {"enum": list(one.words)}
        else:
            form = {"type": "integer", "minimum": one.least, "maximum": one.most}
        rows[name] = {**form, "description": one.meaning}
    return {"type": "object", "properties": rows, "additionalProperties": False}
