"""Static analyses of programs: data flow, values, types, uses, and the state of motion."""

from __future__ import annotations
