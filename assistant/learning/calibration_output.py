"""Output of a calibration: the corrected robot file, its text, and its record with units.

The corrected robot is a TOML that reads back, with a URDF beside it for a free chain.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any, Final
from xml.sax.saxutils import quoteattr

import numpy as np

from assistant.base import rotations
from assistant.base.toml_edits import toml_item, toml_text
from assistant.learning.arm_calibration import Calibration
from assistant.learning.arm_models import LengthsModel
from assistant.learning.parameter_fit import BASE_PARAMETERS, PLACEMENT_COUNT, Residual
from assistant.learning.pose_selection import SuggestedPoses
from assistant.program.geometry import Pose
from assistant.robots import Robot
from assistant.robots.arms import FiveAxis, Scara, SixAxis
from assistant.robots.arms.arm import METRE, Chain
from assistant.robots.robot_file import LENGTH_NAMES, ROBOT_NAME


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


_FILE_DECIMALS: Final = 9
"""Decimals of mm and degrees; the flange of the file is that of the fit within 1e-6 mm."""


def corrected_files(done: Calibration, stem: str) -> dict[str, bytes]:
    """`STEM.toml`, and `STEM.urdf` if the axes of the arm lie otherwise than its kind has them."""
    model, values = done.fit.problem.model, done.fit.state.values
    zero = [round(float(value), _FILE_DECIMALS) + 0.0 for value in model.zero(values)]
    arm = model.arm(values) if isinstance(model, LengthsModel) else None
    head = _figures(done, stem)
    if isinstance(arm, SixAxis | FiveAxis | Scara):
        has = arm if isinstance(arm, Scara) else arm.lengths
        lengths = {
            name: round(float(getattr(has, name)), _FILE_DECIMALS)
            for name in LENGTH_NAMES[arm.kind]
        }
        kind = {"arm": arm.kind, "lengths_mm": lengths}
        return {f"{stem}.toml": _robot_file(head | kind | _axes(done.robot, done.robot.axes, zero))}
    chain = model.chain(values)
    names = [f"J{i}" for i in range(1, len(done.robot.axes) + 1)]
    link = {"urdf": f"{stem}.urdf"}
    return {
        f"{stem}.toml": _robot_file(head | link | _axes(done.robot, names, zero)),
        f"{stem}.urdf": _file_bytes(_urdf_lines(done.robot, chain, zero)),
    }


def _robot_file(content: dict[str, Any]) -> bytes:
    head = "# Corrected by measured poses. Lengths in mm, angles in degrees.\n\n"
    return (head + toml_text(content)).encode()


def _figures(done: Calibration, stem: str) -> dict[str, Any]:
    robot = done.robot
    count = int(done.fit.used.sum())
    how = f"calibrated by {count} poses of {done.measured.path or 'a program'}"
    left = f"{done.out.point:.3g} mm left in poses held out"
    return {
        "name": stem if ROBOT_NAME.fullmatch(stem) else f"{robot.name[:53]}-calibrated",
        "title": f"{robot.title} (calibrated)",
        "maker": robot.maker,
        "controller": robot.controller,
        "languages": robot.languages,
        "configuration": robot.counts,
        "reach_mm": robot.reach,
        "payload_kg": robot.payload,
        "tcp_speed_mm_s": robot.tcp_speed,
        "repeatability_mm": robot.repeatability,
        "time_to_speed_s": robot.time_to_speed,
        "time_to_speed_kg": robot.light or None,
        "coupling": robot.coupling or None,
        "source": f"{how}, {left}; else: {robot.source}",
        "unconfirmed": robot.unconfirmed,
    }


def _axes(robot: Robot, names: Sequence[str], zero: Sequence[float]) -> dict[str, Any]:
    """Tables of the axes, a line for each, and of the radii."""
    tables: dict[str, Any] = {}
    for i, name in enumerate(names):
        fields = {
            "limits": robot.limits[i].tolist(),
            "speed": float(robot.speeds[i]),
            "acceleration": None if robot.accelerations is None else float(robot.accelerations[i]),
            "zero": zero[i],
            "home": float(robot.home[i]),
        }
        axis = toml_item({key: value for key, value in fields.items() if value is not None})
        tables.setdefault("axes_mm" if robot.sliding[i] else "axes_deg", {})[name] = axis
    return {**tables, "radii_mm": dict(zip(("base", *names), robot.radii, strict=True))}


def _urdf_lines(robot: Robot, chain: Chain, zero: Sequence[float]) -> Iterator[str]:
    count = len(chain.joints)
    links = ["base_link", *(f"link_{i}" for i in range(1, count + 1)), "tool0"]
    yield '<?xml version="1.0"?>'
    yield f"<robot name={quoteattr(robot.name)}>"
    yield from (f'  <link name="{name}"/>' for name in links)
    for i, joint in enumerate(chain.joints):
        low, high = robot.limits[i] + zero[i]
        speed = float(robot.speeds[i])
        if joint.sliding:
            low, high, speed = low / METRE, high / METRE, speed / METRE
        else:
            low, high, speed = np.radians(low), np.radians(high), float(np.radians(speed))
        kind = "prismatic" if joint.sliding else "revolute"
        yield f'  <joint name="joint_{i + 1}" type="{kind}">'
        yield from _fixed_joint(joint.pose, links[i], links[i + 1])
        yield f'    <axis xyz="{_number_text(joint.axis)}"/>'
        limit = f'lower="{float(low)!r}" upper="{float(high)!r}" velocity="{speed!r}"'
        yield f'    <limit {limit} effort="0"/>'
        yield "  </joint>"
    yield '  <joint name="flange" type="fixed">'
    yield from _fixed_joint(chain.flange, links[-2], links[-1])
    yield "  </joint>"
    yield "</robot>"


def _fixed_joint(pose: Pose, parent: str, child: str) -> Iterator[str]:
    yaw, pitch, roll = np.radians(rotations.to_euler(np.array(pose.quaternion))).tolist()
    place = _number_text([value / METRE for value in pose.position])
    yield f'    <parent link="{parent}"/>'
    yield f'    <child link="{child}"/>'
    yield f'    <origin xyz="{place}" rpy="{_number_text([roll, pitch, yaw])}"/>'


def _number_text(values: Sequence[float]) -> str:
    """All their digits: an angle with few of them may be read as the quarter turn beside it."""
    return " ".join(repr(float(value) + 0.0) for value in values)


def _file_bytes(lines: Iterator[str] | Sequence[str]) -> bytes:
    return ("\n".join(lines) + "\n").encode()
