"""An interpreter of pseudo-programs, which reports events like those of the vendors' languages.

It runs the statements of a program as they are. It does not run vendor text in it.
"""

from assistant.virtual.pseudo.statements import start_program

__all__ = ["start_program"]
