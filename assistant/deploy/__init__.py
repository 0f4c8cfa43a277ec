"""Installs programs on controllers, so that it can always be taken back.

plan = deploy.plan(["out/seam.mod"], controller)
deployment = deploy.deploy(plan)
deploy.rollback(controller)
"""

from assistant.deploy.deployment import Deployment, FileState, deploy
from assistant.deploy.history import Journal, Step, all_journals, journals, place_of
from assistant.deploy.plan import EVERY, Change, Plan, PlannedFile, gathered, plan
from assistant.deploy.record import Held, Record
from assistant.deploy.recovery import resume, rollback
from assistant.deploy.rollout import (
    PARALLEL,
    Cell,
    CellState,
    Halt,
    Outcome,
    Rollout,
    deploy_to_all,
)
from assistant.deploy.verification import Seen, SeenProgram, Verified, verify

__all__ = [
    "EVERY",
    "PARALLEL",
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
    "Seen",
    "SeenProgram",
    "Step",
    "Verified",
    "all_journals",
    "deploy",
    "deploy_to_all",
    "gathered",
    "journals",
    "place_of",
    "plan",
    "resume",
    "rollback",
    "verify",
]
