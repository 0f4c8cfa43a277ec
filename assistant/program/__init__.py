"""The pseudo-program, its text form, and the analyses and passes that work on it."""

from __future__ import annotations
