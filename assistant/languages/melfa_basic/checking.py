"""The language's own rules over the files of a program."""

from assistant.languages.melfa_basic.checks import check

__all__ = ["check"]
