"""FMUs: an arm, a program's motion or a live controller as a model that other tools import."""

from __future__ import annotations

from assistant.blocks.fmu.co_simulation import Model, compiled
from assistant.blocks.fmu.robot_models import arm_model, live_model, program_model, usual_period

__all__ = ["Model", "arm_model", "compiled", "live_model", "program_model", "usual_period"]
