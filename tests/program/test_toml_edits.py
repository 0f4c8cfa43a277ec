"""TOML texts changed in place: all but the lines of one key stays byte for byte."""

from __future__ import annotations

import math
import tomllib

import pytest

from assistant.base.toml_edits import toml_text, toml_value, with_values, without_table

ROWS = "rows = [\n  [1, 2],  # one\n  [3, 4],\n]\n"
LIST = 'a = [ # of letters\n  "x", # x\n  {b = 1},  # y\n] # end\n'
MULTILINE = f'a = """\n[b]\n# c = 1\nb = 2\n"""\n{ROWS}\n[b]\nc = 3\n'
OUT_OF_ORDER = "[a.x]\nk = 1\n\n[b]\nk = 2\n\n[a.y]\nk = 3\n\n[a]\nk = 4\n"
ENTRIES = "[[t]]\nn = 1\n\n[t.s]\nv = 1\n\n[[t]]\nn = 2  # two\n[[t.u]]\nw = 1\n[[t.u]]\nw = 2\n"


@pytest.mark.parametrize(
    ("before", "path", "value", "after"),
    [
        ("a = 1\n", "b.c", None, "a = 1\n"),
        ("a = 1\n", "b.c.d", None, "a = 1\n"),
        # Comments at ends of lines keep their column while there is room, tabs and blanks stay.
        ("a = 1   # one\nb=2\n", "a", 100, "a = 100 # one\nb=2\n"),
        ("a = 100 # one\n", "a", 1, "a = 1   # one\n"),
        ("\ta\t=\t1\t# one\n", "a", 2, "\ta\t=\t2 # one\n"),
        ("[t]\n\ta = 'x' # é\n", "t.a", "é", '[t]\n\ta = "é" # é\n'),
        ("a = 1", "a", 2, "a = 2"),
        ("a = 1", "b", 2, "a = 1\nb = 2\n"),
        ("a = 1", "t.b", 2, "a = 1\n\n[t]\nb = 2\n"),
        ("", "t.b", 2, "[t]\nb = 2\n"),
        ("a = 1\nb = 2 # b", "a", None, "b = 2 # b"),
        # CRLF.
        ("a = 1\r\n[t]\r\nb = 2\r\n", "t.b", 3, "a = 1\r\n[t]\r\nb = 3\r\n"),
        ("a = 1 # x\r\n[t]\r\nb = 2\r\n", "a", 3, "a = 3 # x\r\n[t]\r\nb = 2\r\n"),
        ("a = 1\r\n[t]\r\nb = 2\r\n", "c", 3, "a = 1\r\nc = 3\r\n[t]\r\nb = 2\r\n"),
        ("a = 1\r\n# b = 2 # two\r\n", "b", 3, f"a = 1\r\n{'b = 3':29} # two\r\n"),
        ("a = 1\r\n", "t.b", 2, "a = 1\r\n\r\n[t]\r\nb = 2\r\n"),
        # Inline tables.
        ("a = {b = 1, c = {d = 2}} # x\n", "a.c.d", 3, "a = {b = 1, c = {d = 3}} # x\n"),
        ("a = {b = 1, c = 2}\n", "a.c", None, "a = {b = 1 }\n"),
        ("a = {b = 1}\n", "a.c.d.e", 2, "a = {b = 1, c = {d = {e = 2}}}\n"),
        ("a = {b = 1}\n", "a.c", None, "a = {b = 1}\n"),
        ("a = {b = 1}\n", "a.b.c", None, None),
        ("a = [{b = 1}, {b = 2}]\n", "a.1.b", 3, "a = [{b = 1}, {b = 3}]\n"),
        ("a = 1\n", "b", {"c d": [1, {"e": "f"}]}, 'a = 1\nb = {"c d" = [1, {e = "f"}]}\n'),
        # Dotted keys.
        ('a . "b c" = [1,\n 2] # x\n', "a.b c", [3.0, 4.5], 'a . "b c" = [3, 4.5] # x\n'),
        ("a.b = 1\na.c.d = 2\nz = 3\n", "a.c.e", 4, "a.b = 1\na.c.d = 2\na.c.e = 4\nz = 3\n"),
        ("a.b = 1\na.c = 2\nz = 3\n", "a", None, "z = 3\n"),
        ("[t]\na.b = 1\n[u]\n", "t.a.c", 2, "[t]\na.b = 1\na.c = 2\n[u]\n"),
        # Multi-line strings and arrays.
        (MULTILINE, "b.c", 4, MULTILINE.replace("c = 3", "c = 4")),
        (MULTILINE, "b.d", 4, MULTILINE + "d = 4\n"),
        (MULTILINE, "a", "x\ny", 'a = "x\\ny"\n' + MULTILINE[MULTILINE.index("rows") :]),
        (MULTILINE, "rows", [[5]], MULTILINE.replace(ROWS, "rows = [[5]]\n")),
        # Entries of arrays that stay keep their lines.
        (LIST, "a", ["x", {"b": 1}, "z"], LIST.replace("  # y\n", "  # y\n  \"z\",\n")),
        (LIST, "a", ["x"], 'a = [ # of letters\n  "x", # x\n] # end\n'),
        (LIST.replace("\n", "\r\n"), "a", ["x"], 'a = [ # of letters\r\n  "x", # x\r\n] # end\r\n'),
        ("a = [] # x\n", "a", [{"b": 1}], "a = [{b = 1}] # x\n"),
        (f'a = ["{"x" * 99}"]\n', "a", ["x" * 99, "y"], f'a = [\n    "{"x" * 99}",\n    "y",\n]\n'),
        # Tables out of order, and arrays of tables.
        (OUT_OF_ORDER, "a.x.k", 9, OUT_OF_ORDER.replace("k = 1", "k = 9")),
        (OUT_OF_ORDER, "a.y.l", 9, OUT_OF_ORDER.replace("k = 3", "k = 3\nl = 9")),
        (OUT_OF_ORDER, "a.k", 9, OUT_OF_ORDER.replace("k = 4", "k = 9")),
        ("[a.x]\nk = 1\n", "a.l", 2, "[a.x]\nk = 1\n\n[a]\nl = 2\n"),
        (ENTRIES, "t.1.n", 9, ENTRIES.replace("n = 2", "n = 9")),
        (ENTRIES, "t.0.s.v", None, ENTRIES.replace("v = 1\n", "")),
        (ENTRIES, "t.1.u.1.x", 9, ENTRIES + "x = 9\n"),
        # Keys that are commented out, but not inside of what looks like them.
        ("[t]\n# b = 1\n", "t.b", 2, "[t]\nb = 2\n"),
        ('[t]\na = """\n# b = 1\n"""\n', "t.b", 2, '[t]\na = """\n# b = 1\n"""\nb = 2\n'),
        # What cannot be said without changing anything else.
        ("a = 1\n", "a.b", 2, None),
        ("[[t]]\nn = 1\n", "t.n", 2, None),
        ("[[t]]\nn = 1\n", "t.5.n", 2, None),
        ("a = {b = 1}\n[t]\n", "t", 5, None),
        ("a = \n", "a", 1, None),
        ("a = 1\na = 2\n", "a", 1, None),
    ],
)  # fmt: skip
def test_one_key_is_changed(before, path, value, after):
    changed = with_values(before, {tuple(path.split(".")): value})
    assert changed == after
    if changed is not None:
        tomllib.loads(changed)


def test_tables_are_removed_with_their_comments_but_not_those_of_the_next_one():
    text = "a = 1\n\n[t]\n# of t\nb = 1\n\n# of u\n[u]\nc = 1\n"
    assert without_table(text, ("t",)) == "a = 1\n\n# of u\n[u]\nc = 1\n"
    assert without_table(text, ("u",)) == text[: text.index("[u]")]
    assert without_table("[t]\n[t.u]\na = 1\n", ("t",)) is None
    assert without_table("[[t]]\n[[t]]\n", ("t",)) is None


def test_nan_elsewhere_does_not_hinder():
    assert with_values("a = [nan]\nb = 1\n", {("b",): 2}) == "a = [nan]\nb = 2\n"


def test_values_come_back():
    content = {
        "text": 'a"b\\c\n\t\x00\x7fé\u2028',
        "numbers": [1, -2.5, 1e300, 5e-324, 0.1, math.inf, True],
        "key with . and ' and \"": {"": {"deep": ["a", ["b"]]}},
        "entries": [{"a": 1}, {"b": {"c": 2}}],
    }
    assert tomllib.loads(toml_text(content)) == content
    assert tomllib.loads(f"it = {toml_value(content)}") == {"it": content}
    assert toml_value([3.0, -0.0, 1e15]) == "[3, 0, 1000000000000000.0]"


@pytest.mark.parametrize("value", [None, "\ud800", [None], {"\ud800": 1}, object()])
def test_what_toml_cannot_express(value):
    with pytest.raises(ValueError):
        toml_value(value)
