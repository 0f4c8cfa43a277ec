"""Findings after they are made: the rulebook, severities of a project, and report formats."""

from __future__ import annotations
