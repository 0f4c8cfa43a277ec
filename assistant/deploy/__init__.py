"""Installs programs on controllers, so that it can always be taken back.

plan = deploy.plan(["out/seam.mod"], controller)
deployment = deploy.deploy(plan)
deploy.rollback(controller)
"""

from assistant.deploy.deployment import deploy
from assistant.deploy.finishing import resume, rollback
from assistant.deploy.held import Held
from assistant.deploy.journal import Journal, Step, journals, place_of
from assistant.deploy.many import Cell, CellState, Halt, Outcome, Rollout, deploy_to_all
from assistant.deploy.outcome import Deployment, FileState
from assistant.deploy.plan import EVERY, Change, Plan, PlannedFile, plan
from assistant.deploy.record import Record

__all__ = [
    "EVERY",
    "Cell",
    "CellState",
    "Change",
    "Deployment",
    "FileState",
    "Halt",
    "Held",
    "Journal",
    "Outcome",
    "Plan",
    "PlannedFile",
    "Record",
    "Rollout",
    "Step",
    "deploy",
    "deploy_to_all",
    "journals",
    "place_of",
    "plan",
    "resume",
    "rollback",
]
