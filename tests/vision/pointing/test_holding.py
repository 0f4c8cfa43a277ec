"""Devices that are followed and held still; strokes between two holds."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from assistant.base import rotations
from assistant.base.arrays import Floats
from assistant.base.diagnostics import Diagnostic, Refused
from assistant.program.geometry import Pose
from assistant.sources import read
from assistant.vision import rules
from assistant.vision.pointing.demonstrations import (
    USUAL_HOLD,
    HeldPosition,
    Stroke,
    average_hold,
    find_holds,
    find_strokes,
)
from assistant.vision.pointing.device_tracking import (
    Observation,
    Seen,
    Sighting,
    fit_device_poses,
    reject_jumps,
)
from assistant.vision.pointing.devices import HUES, Ball, Device, ball, wand
from tests.vision.pointing.scenes import pair, some_pose

UNSEEN = rules.MARK_NOT_SEEN(camera="left", mark="red ball")
DOWN = (0.0, 1.0, 0.0, 0.0)


class Hand:
    """Where a hand leads a device, as looks with 0.2 px of noise, 30 a second."""

    def __init__(self, device: Device, seed: int = 0) -> None:
        self.device, self.rng = device, np.random.default_rng(seed)
        self.poses: list[Pose | None] = []

    def at(self, pose: Pose, frames: int = 1, shake: float = 0.0) -> Hand:
        for _ in range(frames):
            x, y, z = np.array(pose.position) + self.rng.normal(0.0, 1.0, 3) * shake
            self.poses.append(Pose((x, y, z), pose.quaternion))
        return self

    def along(self, points: Floats) -> Hand:
        for x, y, z in points.tolist():
            self.at(Pose((x, y, z), DOWN))
        return self

    def lost(self, frames: int) -> Hand:
        self.poses += [None] * frames
        return self

    @property
    def looks(self) -> Iterator[Observation]:
        there = [pose for pose in self.poses if pose is not None]
        points = np.concatenate([pose.moved(self.device.positions) for pose in there])
        size = (len(there), len(self.device.marks), 2)
        pixels = np.stack([camera.project(points).reshape(size) for camera in pair()])
        pixels += self.rng.normal(0.0, 0.2, pixels.shape)
        posed = fit_device_poses(pair(), pixels, self.device.positions)
        row = 0
        for number, pose in enumerate(self.poses):
            seen: Seen = UNSEEN
            if pose is not None:
                known = self.device.turns_shown > 0
                turn = posed.quaternions[row] if known else np.array(DOWN)
                seen = Sighting(
                    Pose.of(posed.positions[row], turn),
                    pixels[:, row],
                    posed.covariances[row],
                    float(posed.residuals[row]),
                )
                row += 1
            yield Observation(number / 30.0, seen)


def held_by(hand: Hand) -> tuple[list[HeldPosition], list[Diagnostic]]:
    told: list[Diagnostic] = []
    return list(find_holds(reject_jumps(hand.looks), hand.device, pair(), tell=told.append)), told


def of_half_a_ball(k: int) -> tuple[Pose, HeldPosition]:
    """A hold during which something hides parts of the same balls, which moves what is seen."""
    rng = np.random.default_rng(k)
    pose = some_pose(rng)
    seen = [one.seen for one in Hand(wand(), seed=k).at(pose, 30).looks]
    alike = rng.normal(0.0, 0.06, (2, 3, 2))
    moments = [
        (i / 30.0, replace(one, pixels=one.pixels + alike, confidence=0.65))
        for i, one in enumerate(seen)
        if isinstance(one, Sighting)
    ]
    found = average_hold(moments, wand(), pair())
    assert isinstance(found, HeldPosition)
    return pose, found


def place(x: float) -> Pose:
    return Pose((x, 0.0, 250.0), DOWN)


def between(a: Pose, b: Pose, frames: int) -> Floats:
    part = np.linspace(0.0, 1.0, frames + 2)[1:-1, None]
    return np.array(a.position) + part * np.subtract(b.position, a.position)


def test_each_place_is_shown_once_however_long_the_hand_rests() -> None:
    hand = Hand(wand()).at(place(0.0), 200).along(between(place(0.0), place(80.0), 20))
    found, told = held_by(hand.at(place(80.0), 90))
    assert [round(h.pose.position[0] / 80.0) for h in found] == [0, 1]
    assert not told


def test_holds_are_exact_and_know_how_exact_they_are(tell: Callable[[str], None]) -> None:
    rng = np.random.default_rng(9)
    off, turned, sigmas = [], [], []
    for k in range(25):
        pose = some_pose(rng)
        (found,), _ = held_by(Hand(wand(), seed=k).at(pose, 30))
        off.append(np.subtract(found.pose.position, pose.position))
        turned.append(float(rotations.angle_between(found.pose.quaternion, pose.quaternion)))
        squares = off[-1] @ np.linalg.inv(found.covariance[:3, :3]) @ off[-1]
        sigmas.append(squares)
    away = np.linalg.norm(off, axis=1)
    assert away.mean() < 0.15 and np.max(turned) < 0.3
    assert 1.5 < np.mean(sigmas) < 5.0  # three, of a covariance that is right
    tell(f"25 holds of 30 frames: {away.mean():.3f} mm mean, {away.max():.3f} worst, "
         f"{np.mean(turned):.3f} degrees mean, {np.max(turned):.3f} worst")  # fmt: skip


def test_what_is_off_in_all_moments_alike_is_in_the_sigma_of_a_hold() -> None:
    """As far as balls were off that were hidden in part, in pictures drawn ray by ray."""
    squares = []
    for k in range(12):
        pose, found = of_half_a_ball(k)
        off = np.subtract(found.pose.position, pose.position)
        squares.append(off @ np.linalg.inv(found.covariance[:3, :3]) @ off)
    assert np.mean(squares) < 4.0 and np.max(squares) < 16.0


def test_a_device_that_moves_during_a_hold_is_held_anew() -> None:
    slowly = between(place(0.0), place(8.0), 40)  # 6 mm a second: no frame tells it alone
    found, told = held_by(Hand(wand()).at(place(0.0), 15).along(slowly).at(place(8.0), 30))
    assert [finding.code for finding in told] == ["VS112"]
    (one,) = found
    assert abs(one.pose.position[0] - 8.0) < 0.8  # half of what the means may differ by


def test_a_hand_that_shakes_holds_nothing() -> None:
    found, told = held_by(Hand(wand()).at(place(0.0), 60, shake=2.5))
    assert not found and [finding.code for finding in told] == ["VS112"]


def test_a_wand_that_turns_about_its_tip_is_not_held() -> None:
    hand = Hand(wand())
    for angle in np.linspace(0.0, 12.0, 30):
        turn = rotations.multiply(rotations.about(np.array([0.0, 1.0, 0.0]), angle), DOWN)
        hand.at(Pose.of(np.array(place(0.0).position), turn))
    found, told = held_by(hand)
    assert not found and [finding.code for finding in told] == ["VS113"]


def test_a_device_that_is_lost_begins_its_hold_anew() -> None:
    found, told = held_by(Hand(wand()).at(place(0.0), 20).lost(1).at(place(0.0), 29))
    assert not found and [finding.code for finding in told] == ["VS104"]
    assert len(held_by(Hand(wand()).at(place(0.0), 20).lost(1).at(place(0.0), 30))[0]) == 1


def test_a_jump_is_not_believed_until_the_device_was_looked_for_anew() -> None:
    looks = list(reject_jumps(Hand(ball()).at(place(0.0), 3).at(place(300.0), 8).looks))
    codes = [look.seen.code if isinstance(look.seen, Diagnostic) else "" for look in looks]
    assert codes == ["", "", "", *["VS111"] * 5, "", "", ""]
    # As far as a hand gets meanwhile, it is the device.
    fast = list(reject_jumps(Hand(ball()).at(place(0.0)).at(place(40.0)).looks))
    assert not any(isinstance(look.seen, Diagnostic) for look in fast)


def test_a_wand_of_two_balls_turns_its_x_along_the_x_of_the_world() -> None:
    marks = wand().marks[:2]
    stick = Device("wand", marks)
    assert stick.turns_shown == 2 and wand().turns_shown == 3 and ball().turns_shown == 0
    tilted = rotations.multiply(rotations.about(np.array([1.0, 0.0, 0.0]), 25.0), DOWN)
    pose = Pose.of(np.array([10.0, 20.0, 250.0]), tilted)
    (found,), _ = held_by(Hand(stick, seed=2).at(pose, 30))
    x, _, z = rotations.to_matrix(np.array(found.pose.quaternion)).T
    assert np.degrees(np.arccos(z @ rotations.rotate(tilted, [0.0, 0.0, 1.0]))) < 0.3
    assert x @ (1.0, 0.0, 0.0) > 0.999
    along = rotations.multiply(rotations.about(np.array([0.0, 1.0, 0.0]), -85.0), DOWN)
    lying = Pose.of(np.array([10.0, 20.0, 250.0]), along)
    (found,), _ = held_by(Hand(stick, seed=3).at(lying, 30))
    x, _, _ = rotations.to_matrix(np.array(found.pose.quaternion)).T
    assert x @ (0.0, 1.0, 0.0) > 0.999


# ------------------------------------------------------------------------------- strokes


def arc(frames: int) -> Floats:
    """Half a circle of 60 mm."""
    angle = np.linspace(np.pi, 0.0, frames)
    return np.stack([60.0 * np.cos(angle), 60.0 * np.sin(angle), np.full(frames, 250.0)], axis=1)


def stroke_of(hand: Hand) -> Stroke | None:
    ways: Iterator[Stroke] = find_strokes(
        reject_jumps(hand.looks), hand.device, pair(), still=USUAL_HOLD
    )
    return next(ways, None)


def drawn_arc(middle: Floats, device: Device) -> Hand:
    first, last = place(-60.0), place(60.0)
    return Hand(device).at(first, 40).along(middle).at(last, 40)


def test_a_stroke_is_smooth_even_and_near_what_was_drawn(tell: Callable[[str], None]) -> None:
    way = stroke_of(drawn_arc(arc(90), wand()))
    assert way is not None
    radius = np.linalg.norm(way.positions[:, :2], axis=1)
    off = np.hypot(radius - 60.0, way.positions[:, 2] - 250.0)
    steps = np.linalg.norm(np.diff(way.positions, axis=0), axis=1)
    assert off.max() < 1.5 and off.mean() < 0.5
    assert steps.max() <= 5.0 + 1e-9 and steps.min() > 4.0
    assert way.length == pytest.approx(np.pi * 60.0, rel=0.02)
    assert np.linalg.norm(way.positions[0] - place(-60.0).position) < 0.4
    tell(f"stroke along half a circle of 60 mm: {off.mean():.2f} mm mean, {off.max():.2f} worst")


def test_who_halts_on_the_way_leaves_no_knot() -> None:
    middle = arc(60)
    halted = np.concatenate([middle[:30], np.repeat(middle[30:31], 20, axis=0), middle[30:]])
    hand = drawn_arc(halted, wand())
    # Held for less than a hold: it is no end of the stroke.
    way = stroke_of(hand)
    assert way is not None and way.length == pytest.approx(np.pi * 60.0, rel=0.03)
    steps = np.diff(way.positions, axis=0)
    steps /= np.linalg.norm(steps, axis=1, keepdims=True)
    bends = np.degrees(np.arccos(np.clip((steps[1:] * steps[:-1]).sum(axis=1), -1.0, 1.0)))
    assert bends.max() < 20.0  # 4.8 degrees each if it were the circle


def test_a_stroke_is_read_as_waypoints(tmp_path: Path) -> None:
    way = stroke_of(drawn_arc(arc(60), ball()))
    assert way is not None
    file = tmp_path / "way.csv"
    file.write_text(way.csv(), encoding="ascii")
    reading = read(file)
    assert not reading.findings
    (path,) = (s.path for s in reading.program.statements() if hasattr(s, "path"))
    assert np.abs(path.positions - way.positions).max() < 1e-3
    assert len(path) == len(way.positions)


def test_strokes_that_tell_no_way_are_refused() -> None:
    hidden = drawn_arc(arc(40)[:12], ball())
    hidden = Hand(ball()).at(place(-60.0), 40).along(arc(40)[:12]).lost(20).along(arc(40)[30:])
    with pytest.raises(Refused) as refused:
        stroke_of(hidden.at(place(60.0), 40))
    assert refused.value.findings[0].code == "VS119"
    short = Hand(ball()).at(place(0.0), 40).along(between(place(0.0), place(17.0), 9))
    with pytest.raises(Refused) as refused:
        stroke_of(short.at(place(17.0), 60))
    assert refused.value.findings[0].code == "VS118"
    assert stroke_of(Hand(ball()).at(place(0.0), 40).along(arc(20))) is None


def test_two_balls_of_a_device_are_told_by_name() -> None:
    plain = Device("wand", (Ball(HUES["red"], 15.0), wand().marks[1]))
    assert plain.mark_names == ("ball", "green ball")
