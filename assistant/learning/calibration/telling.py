"""A calibration in words, and as plain data whose names tell their units."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np

from assistant.learning.calibration.calibrating import Calibration
from assistant.learning.calibration.poses import SuggestedPoses
from assistant.learning.calibration.problem import BASE_PARAMETERS, PLACEMENT_COUNT
from assistant.learning.calibration.validating import Residual
from assistant.program.geometry import Pose


def calibration_lines(done: Calibration) -> Iterator[str]:
    used, count = int(done.fit.used.sum()), len(done.measured)
    point, turn = done.noise
    turned = "" if turn is None else f" and {turn:.3g} degrees"
    yield f"{done.robot.name}: {used} of {count} poses, noise {point:.3g} mm{turned} (one sigma)"
    yield ""
    yield "residual          nominal arm   corrected"
    yield f"of the fit      {_residual_text(done.before):>13}{_residual_text(done.after):>12}"
    yield f"at worst        {done.before.worst:>10.3f} mm{done.after.worst:>9.3f} mm"
    yield f"held out        {_residual_text(done.out_before):>13}{_residual_text(done.out):>12}"
    if done.after.turn is not None:
        yield f"turns, fit      {_turn_text(done.before):>13}{_turn_text(done.after):>12}"
        yield f"turns, held out {_turn_text(done.out_before):>13}{_turn_text(done.out):>12}"
    yield ""
    yield "parameter     nominal   corrected        off   sigma"
    for one in done.corrections:
        name, unit = one.parameter.name, one.parameter.unit
        numbers = f"{one.parameter.nominal:>9.3f}{one.corrected:>12.4f}{one.value:>+11.4f}"
        yield f"{name:<11}{numbers}{one.sigma:>8.4f} {unit}"
    yield ""
    yield f"condition number {done.condition:.1f}"
    for first, second, much in done.alike:
        yield f"{first} and {second} are told together (correlation {much:.2f})"
    if done.known.base is None:
        yield f"base of the arm in the measuring frame: {_pose_text(done.base)}"
    if done.known.tool is None:
        yield f"measured point in the flange: {_position_text(done.tool)}"


def calibration_record(done: Calibration) -> dict[str, Any]:
    point, turn = done.noise
    rows = done.measured.rows
    return {
        "robot": done.robot.name,
        "estimate": done.estimate,
        "poses": len(done.measured),
        "left_out_rows": rows[~done.fit.used].tolist(),
        "noise_mm": point,
        "noise_deg": turn,
        "residuals": {
            "nominal": _residual_record(done.before),
            "corrected": _residual_record(done.after),
            "nominal_held_out": _residual_record(done.out_before),
            "corrected_held_out": _residual_record(done.out),
        },
        "parameters": [
            {
                "name": one.parameter.name,
                "unit": one.parameter.unit,
                "nominal": one.parameter.nominal,
                "corrected": one.corrected,
                "sigma": one.sigma,
            }
            for one in done.corrections
        ],
        "held": [
            {"name": one.parameter.name, "reason": one.reason, "sums": [list(p) for p in one.parts]}
            for one in done.held
        ],
        "alike": [list(one) for one in done.alike],
        "condition": done.condition,
        "base": _pose_record(done.base) | _placement_sigmas(done, 0),
        "tool": _pose_record(done.tool) | _placement_sigmas(done, len(BASE_PARAMETERS)),
    }


def suggestion_lines(found: SuggestedPoses) -> Iterator[str]:
    yield "parameter       sigma  by chance"
    for one, sigma, chance in zip(found.parameters, found.sigmas, found.by_chance, strict=True):
        yield f"{one.name:<11}{sigma:>10.4f}{chance:>11.4f} {one.unit}"


def _residual_text(one: Residual) -> str:
    return f"{one.point:.3f} mm"


def _turn_text(one: Residual) -> str:
    return f"{one.turn:.4f} deg"


def _position_text(pose: Pose) -> str:
    x, y, z = pose.position
    return f"[{x:.3f}, {y:.3f}, {z:.3f}] mm"


def _pose_text(pose: Pose) -> str:
    turn = ", ".join(f"{value:.7f}" for value in pose.quaternion)
    return f"{_position_text(pose)}, quaternion [{turn}]"


def _residual_record(one: Residual) -> dict[str, float | None]:
    return {"mm": one.point, "worst_mm": one.worst, "degrees": one.turn}


def _pose_record(pose: Pose) -> dict[str, Any]:
    return {"position_mm": list(pose.position), "quaternion": list(pose.quaternion)}


def _placement_sigmas(done: Calibration, first: int) -> dict[str, Any]:
    """None for what is known or held."""
    assert first < PLACEMENT_COUNT
    values = done.sigmas[first : first + 6]
    told = [None if not np.isfinite(value) else float(value) for value in values]
    return {"sigma_mm": told[:3], "sigma_deg": told[3:]}
