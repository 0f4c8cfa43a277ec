"""An interpreter of pseudo-programs: what they do, told as that of the vendors' languages is.

It reads the statements of a program as they stand. Vendor text in it is not run.
"""

from assistant.virtual.pseudo.statements import start_program

__all__ = ["start_program"]
