"""The schema for editors takes what the reader takes, and nothing else."""

import itertools
import json
import tomllib

import jsonschema
import pytest

from assistant import languages
from assistant.languages.language_types import Choice
from assistant.program.settings_tables import Wrong
from assistant.project.project_file import (
    CONTROLLER_KEYS,
    DEPLOY_KEYS,
    PROGRAM_KEYS,
    STYLE_TABLE_KEYS,
    TARGET_KEYS,
    project_schema,
    schema_text,
)
from assistant.resources import resource

TABLES = {
    "controllers": CONTROLLER_KEYS,
    "programs": PROGRAM_KEYS,
    "targets": TARGET_KEYS,
    "deploy": DEPLOY_KEYS,
    "style": STYLE_TABLE_KEYS,
}
VALUES = (
    *("", " ", "x", "T_ROB1", "1x", "a b", "mm", "rapid", "melfa-basic-5", "base", "irb", "Base"),
    *(True, False, 0, 1, 9, 10, 256, 257, 2**31, 10**8, -1, 0.5, 3599.5, 3600.5),
    *([], ["x"], ["x", "y"], ["x", 1], [""], {}, {"x": 1}),
)
WHOLE = jsonschema.Draft7Validator(project_schema())


def test_it_is_a_schema():
    jsonschema.Draft7Validator.check_schema(project_schema())
    assert json.loads(schema_text()) == project_schema()


@pytest.mark.parametrize("table", TABLES)
def test_each_key_takes_what_its_reader_takes(table):
    for (key, one), value in itertools.product(TABLES[table].items(), VALUES):
        try:
            one.read(value)
            taken = not (key == "programs" and value == [])  # the reader of the table asks for one
        except Wrong:
            taken = False
        assert jsonschema.Draft7Validator(dict(one.form)).is_valid(value) is taken, (key, value)


def test_it_knows_the_keys_of_all_tables():
    properties = project_schema()["properties"]
    controllers = properties["controllers"]["additionalProperties"]["anyOf"][1]
    of = {
        "controllers": controllers,
        "programs": properties["programs"]["additionalProperties"],
        "targets": properties["targets"]["additionalProperties"],
        "deploy": properties["deploy"],
        "style": properties["style"],
    }
    for name, keys in TABLES.items():
        assert set(of[name]["properties"]) == set(keys)
        assert of[name]["additionalProperties"] is False
    for language in map(languages.get, languages.names()):
        rows = properties[language.table]["properties"]
        assert set(rows) == set(language.settings)
        for name, setting in language.settings.items():
            if isinstance(setting, Choice):
                assert rows[name]["enum"] == list(setting.words)
            else:
                assert (rows[name]["minimum"], rows[name]["maximum"]) == (
                    setting.least,
                    setting.most,
                )


def test_it_knows_the_tables_that_the_reader_knows():
    from assistant.project.project_file import project_tables

    assert set(project_schema()["properties"]) == set(project_tables())
    assert not WHOLE.is_valid({"target": {}})


def test_the_example_is_valid():
    text = resource("templates", "project/assistant.toml").read_text("utf-8")
    example = tomllib.loads(text)
    WHOLE.validate(example)
    example["targets"]["cell1"]["taks"] = "T_ROB1"
    assert not WHOLE.is_valid(example)
