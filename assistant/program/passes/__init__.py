"""Passes over a program, whichever language it comes from or goes to.

Most bring it within a language's capabilities; some make of vendor statements what every language
can express.
"""

from __future__ import annotations
