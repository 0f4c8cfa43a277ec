"""FMUs: an arm, a program's motion or a live controller as a model that other tools import."""

from __future__ import annotations

from assistant.blocks.fmu.arm import arm_model
from assistant.blocks.fmu.compilers import compiled
from assistant.blocks.fmu.live import live_model
from assistant.blocks.fmu.model import Model
from assistant.blocks.fmu.program import program_model, usual_period

__all__ = ["Model", "arm_model", "compiled", "live_model", "program_model", "usual_period"]
