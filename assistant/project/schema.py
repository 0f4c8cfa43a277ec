"""The JSON schema of assistant.toml, for editors: printed from the tables that its readers use."""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import Final

from assistant import languages
from assistant.controllers.named import NAME as CONTROLLER_NAME
from assistant.findings.severities import LEVELS, TABLE
from assistant.languages.language_types import Choice, Setting
from assistant.project.tables import (
    CONTROLLER_KEYS,
    DEPLOY_KEYS,
    PROGRAM_KEYS,
    PROJECT_NAME,
    STYLE_TABLE_KEYS,
    TARGET_KEYS,
    ProjectKey,
)
from assistant.sources.project_file import CONTROLLERS, DEPLOY, PROGRAMS, TARGETS
from assistant.sources.project_file import STYLE as STYLE_TABLE

SCHEMA_FILE: Final = "assistant.schema.json"
SCHEMA_DRAFT: Final = "http://json-schema.org/draft-07/schema#"
Schema = dict[str, object]


def project_schema() -> Schema:
    """Of a whole file."""
    controller = _table_schema(CONTROLLER_KEYS, "address")
    of_languages = {}
    for language in map(languages.get, languages.names()):
        if language.table:
            of_languages[language.table] = _settings_schema(language.settings)
    return {
        "$schema": SCHEMA_DRAFT,
        "title": "assistant.toml of robot-assistant",
        "type": "object",
        "properties": {
            CONTROLLERS: _named_schema(
                CONTROLLER_NAME.pattern, {"anyOf": [CONTROLLER_KEYS["address"].form, controller]}
            ),
            PROGRAMS: _named_schema(PROJECT_NAME.pattern, _table_schema(PROGRAM_KEYS, "source")),
            TARGETS: _named_schema(PROJECT_NAME.pattern, _table_schema(TARGET_KEYS, "programs")),
            DEPLOY: _table_schema(DEPLOY_KEYS),
            STYLE_TABLE: _table_schema(STYLE_TABLE_KEYS),
            TABLE: {"type": "object", "additionalProperties": {"enum": list(LEVELS)}},
            **of_languages,
        },
        "additionalProperties": False,
    }


def schema_text() -> str:
    return json.dumps(project_schema(), indent=2, ensure_ascii=False) + "\n"


def _table_schema(keys: Mapping[str, ProjectKey], *required: str) -> Schema:
    rows = {name: {**key.form, "description": key.about} for name, key in keys.items()}
    table: Schema = {"type": "object", "properties": rows, "additionalProperties": False}
    return {**table, "required": list(required)} if required else table


def _named_schema(pattern: str, content: Schema) -> Schema:
    names = {"pattern": f"^(?:{pattern})$"}
    return {"type": "object", "propertyNames": names, "additionalProperties": content}


def _settings_schema(settings: Mapping[str, Setting | Choice]) -> Schema:
    rows: Schema = {}
    for name, one in settings.items():
        if isinstance(one, Choice):
            form: Schema = {"enum": list(one.words)}
        else:
            form = {"type": "integer", "minimum": one.least, "maximum": one.most}
        rows[name] = {**form, "description": one.meaning}
    return {"type": "object", "properties": rows, "additionalProperties": False}
