"""Installs programs on controllers, so that it can always be taken back.

plan = deploy.plan(["out/seam.mod"], controller)
deployment = deploy.deploy(plan)
deploy.rollback(controller)
"""

from assistant.deploy.deployment import deploy
from assistant.deploy.files import gathered
from assistant.deploy.finishing import resume, rollback
from assistant.deploy.held import Held
from assistant.deploy.journal import Journal, Step, all_journals, journals, place_of
from assistant.deploy.many import PARALLEL, Cell, CellState, Halt, Outcome, Rollout, deploy_to_all
from assistant.deploy.outcome import Deployment, FileState
from assistant.deploy.plan import EVERY, Change, Plan, PlannedFile, plan
from assistant.deploy.record import Record
from assistant.deploy.verifying import Seen, SeenProgram, Verified, verify

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
