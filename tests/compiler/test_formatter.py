"""A formatter that changes more than the layout is found out."""

from assistant.base.source_text import SourceText
from assistant.compiler.formatter import NOT_THE_SAME, format_text
from assistant.languages.rapid import Rapid


class Forgetful(Rapid):
    """Formats by leaving something out."""

    left_out = ""

    def format(self, tree):
        return super().format(tree).replace(self.left_out, "")


def test_a_wrong_formatter_does_no_harm():
    text = "MODULE m\n VAR num a:= ! a note\n 1;\nVAR num b;\nENDMODULE\n"
    for left_out in ("    VAR num b;\n", "! a note", ";"):
        language = Forgetful()
        language.left_out = left_out
        formatted = format_text(SourceText(text, "m.mod"), language)
        assert not formatted.changed
        assert formatted.text == text
        assert [f.code for f in formatted.findings] == [NOT_THE_SAME.code], left_out
