"""Installs programs on controllers: plan, back up, upload, verify; all of them or none.

plan = deploy.plan(["out/seam.mod"], controller)
deployment = deploy.deploy(plan)
"""

from assistant.deploy.deployment import Deployment, FileState, deploy
from assistant.deploy.plan import Change, Plan, PlannedFile, plan

__all__ = [
    "Change",
    "Deployment",
    "FileState",
    "Plan",
    "PlannedFile",
    "deploy",
    "plan",
]
