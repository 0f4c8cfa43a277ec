"""A saved map in use: what it reaches, keeps to, refuses, says of itself and goes on to learn."""

from __future__ import annotations

from collections import Counter
from dataclasses import replace

import numpy as np
import pytest

from assistant.base.arrays import Floats
from assistant.base.diagnostics import Refused
from assistant.learning.experiments import TOOL_TIP, moved_aside, over_ranges, three_joints
from assistant.learning.extended_map import ExtendedMap, rates_in_use, try_targets
from assistant.learning.map_file import load_map
from assistant.learning.map_training import measure_errors, train_and_measure, usual_plan
from assistant.learning.observed_arm import Goals, InBox, observed_arm
from assistant.learning.proposals import MapInUse
from tests.learning.maps.small import SMALL, STEPS

EXPERIMENT = three_joints()
ARM = EXPERIMENT.arm


@pytest.fixture
def net() -> ExtendedMap:
    return load_map(SMALL)


def goals(count: int = 500, seed: int = 9) -> Goals:
    return EXPERIMENT.space.draw(ARM, count, np.random.default_rng(seed))


def place(joints: Floats) -> Floats:
    """(n, 3) mm of the tip by the robot's own kinematics."""
    whole = np.zeros((len(joints), 5))
    whole[:, :3] = joints
    flange, _ = ARM.robot.fk(whole)
    frames = ARM.robot.link_frames(whole)[1][:, -1]
    return flange + frames @ np.array([0.0, 0.0, 60.0])


def no_arm(joints: Floats) -> Floats:
    raise AssertionError("it moved")


def codes(refused: pytest.ExceptionInfo[Refused]) -> list[str]:
    return [finding.code for finding in refused.value.findings]


def test_it_places_the_tool_within_a_twentieth_percent_of_the_workspace(net, tell) -> None:
    asked = goals()
    done = try_targets(net, ARM, asked.pixels)
    off = np.linalg.norm(place(done.fine) - asked.points[:, 0], axis=1)
    diagonal = float(np.linalg.norm([150.0, 400.0, 200.0]))
    noisy = asked.pixels + np.random.default_rng(3).normal(0.0, 0.2, asked.pixels.shape)
    seen = try_targets(net, ARM.noisy(0.2, seed=4), noisy)
    blurred = np.linalg.norm(place(seen.fine) - asked.points[:, 0], axis=1)
    assert net.steps == STEPS
    assert off.mean() <= 0.0005 * diagonal
    tell(
        f"learned map, 3 joints, {net.steps:,} steps: mean {off.mean():.3f} mm "
        f"({off.mean() / diagonal:.3%} of the workspace), worst {off.max():.2f} mm; with 0.2 px of "
        f"noise {blurred.mean():.2f} mm, worst {blurred.max():.2f} mm"
    )


def test_no_proposal_leaves_the_limits_whatever_is_shown(net) -> None:
    draw = np.random.default_rng(1)
    shown = np.concatenate(
        [draw.uniform(-1e6, 1e6, (2000, 4)), draw.uniform(0.0, 640.0, (2000, 4)), [[1e300] * 4]]
    )
    asked: list[Floats] = []

    def arm(joints: Floats) -> Floats:
        asked.append(joints)
        return draw.uniform(-1e4, 1e4, (len(joints), 4))

    proposed = MapInUse(net).proposed(shown[:-1]).joints
    try_targets(net, arm, shown)
    low, high = ARM.robot.limits[:3].T
    for joints in (proposed, *asked):
        assert (joints >= low).all()
        assert (joints <= high).all()


def test_it_says_how_sure_it_is(net, tell) -> None:
    asked = goals()
    user = MapInUse(net)
    proposal = user.proposed(asked.pixels)
    off = np.linalg.norm(place(proposal.joints) - asked.points[:, 0], axis=1)
    order = np.argsort(proposal.spread)
    surest, least = off[order[:100]].mean(), off[order[-100:]].mean()
    assert proposal.known.all()
    assert np.isfinite(proposal.expected).all()
    assert least > surest
    beside = np.random.default_rng(2).uniform(0.0, 480.0, (500, 4))
    known = user.proposed(beside).known.mean()
    assert known < 0.02
    tell(
        f"learned map: coarse error {surest:.2f} mm where neighbours agree best, {least:.2f} mm "
        f"where least; {known:.1%} of pictures of nothing pass for known"
    )


def test_a_target_is_reached_by_movements_that_are_seen(net) -> None:
    asked = goals(20)
    user = MapInUse(net)
    for pixels, point in zip(asked.pixels, asked.points, strict=True):
        found = user.reach(ARM, pixels, corrections=3)
        assert not found.findings
        assert len(found.missed) == 4
        assert found.missed[-1] < 0.01
        assert np.linalg.norm(place(found.joints[None])[0] - point[0]) < 0.05


def test_nothing_moves_for_a_doubtful_target(net) -> None:
    user = MapInUse(net)
    good = goals(1).pixels[0]
    hidden = good.copy()
    hidden[2:] = np.nan
    far = good + np.array([300.0, 0.0, -300.0, 0.0])

    for target, code in ((hidden, "LN004"), (good[:2], "LN004"), (far, "LN005")):
        with pytest.raises(Refused) as refused:
            user.reach(no_arm, target)
        assert codes(refused) == [code]
    with pytest.raises(Refused):
        user.reach(no_arm, good, asks=lambda _: False)


def test_a_tool_that_gets_out_of_sight_stops_there(net) -> None:
    moves = []

    def arm(joints: Floats) -> Floats:
        moves.append(joints)
        return np.full((1, 4), np.nan) if len(moves) == 2 else ARM(joints)

    with pytest.raises(Refused) as refused:
        MapInUse(net).reach(arm, goals(1).pixels[0], corrections=5)
    assert codes(refused) == ["LN012"]
    assert len(moves) == 2


def test_an_arm_that_answers_something_else_is_refused(net) -> None:
    with pytest.raises(Refused) as refused:
        MapInUse(net).reach(lambda joints: np.zeros((1, 3)), goals(1).pixels[0])
    assert codes(refused) == ["LN011"]


def test_a_changed_arm_is_told_of(net) -> None:
    found = MapInUse(net).reach(ARM.longer("a2", 1.1), goals(1).pixels[0])
    assert [finding.code for finding in found.findings] == ["LN013"]


@pytest.mark.one_in(2)
@pytest.mark.parametrize("what", ["a bent tool", "a moved camera"])
def test_it_goes_on_learning_in_use(net, tell, what: str) -> None:
    arm = ARM.bent(ARM.points + np.array([15.0, -10.0, 10.0]))
    if what == "a moved camera":
        arm = ARM.watched((ARM.cameras[0], moved_aside(ARM.cameras[1], 30.0)))
    shown = goals(300, seed=5)
    targets = arm.seen(shown.points)
    asked = replace(goals(200), pixels=arm.seen(goals(200).points))
    before = measure_errors(net, arm, asked)
    user = MapInUse(net)
    for target in targets:
        if user.proposed(target[None]).known[0]:
            user.reach(arm, target, pace=rates_in_use())
    after = measure_errors(net, arm, asked)
    assert after.coarse < 0.85 * before.coarse
    assert after.mm < before.mm
    tell(
        f"learned map, {what}: {before.mm:.2f} mm ({before.coarse:.1f} mm before the correction), "
        f"{after.mm:.2f} mm ({after.coarse:.1f}) after {len(targets):,} uses"
    )


@pytest.mark.parametrize("side", range(6))
def test_targets_beside_the_space_that_was_learnt_move_nothing(net, side: int) -> None:
    box = EXPERIMENT.space.box.copy()
    axis, far = divmod(side, 2)
    beyond = box[axis, far] + (80.0 if far else -80.0)
    box[axis] = beyond, beyond + 0.001
    points = InBox(box).draw(ARM, 100, np.random.default_rng(side)).points[:, 0]
    shown = np.concatenate([camera.project(points) for camera in ARM.cameras], axis=1)
    assert not MapInUse(net).proposed(shown).known.any()
    with pytest.raises(Refused) as refused:
        MapInUse(net).reach(no_arm, shown[0])
    assert codes(refused)[0] in {"LN005", "LN020"}


def test_nothing_moves_where_the_cameras_see_different_things(net) -> None:
    asked = goals(400).pixels
    other = np.concatenate([asked[:200, :2], asked[200:, 2:]], axis=1)
    apart = np.abs(asked[:200] - asked[200:]).max(axis=1) > 60.0
    known = MapInUse(net).proposed(other[apart]).known
    assert known.mean() < 0.1
    strange = asked[0] + np.array([0.0, 12.0, 0.0, -12.0])
    with pytest.raises(Refused) as refused:
        MapInUse(net).reach(no_arm, strange)
    assert codes(refused) == ["LN020"]


@pytest.mark.parametrize(
    "arm",
    [
        pytest.param(
            ARM.bent(ARM.points + np.array([150.0, 0.0, 0.0])), id="a tool bent by 150 mm"
        ),
        pytest.param(ARM.longer("a2", 1.5), id="a link half as long again"),
    ],
)
def test_an_arm_that_is_another_one_stops_after_its_first_movement(net, arm) -> None:
    stopped = []
    for target in goals(30).pixels:
        moves = []

        def counted(joints: Floats, moves: list[Floats] = moves) -> Floats:
            moves.append(joints)
            return arm(joints)

        with pytest.raises(Refused) as refused:
            MapInUse(net).reach(counted, target, corrections=5)
        assert len(moves) == 1
        stopped += codes(refused)
    assert set(stopped) <= {"LN012", "LN021"}
    assert "LN021" in stopped


def test_an_arm_that_goes_away_from_the_target_stops(net) -> None:
    target, moves = goals(1).pixels[0], []

    def arm(joints: Floats) -> Floats:
        moves.append(joints)
        return (target + np.array([2.0, 1.0, 2.0, 1.0]) * 3.0 ** len(moves))[None]

    with pytest.raises(Refused) as refused:
        MapInUse(net).reach(arm, target, corrections=5)
    assert codes(refused) == ["LN021"]
    assert len(moves) <= 3


def test_whoever_says_that_nothing_is_wrong_is_right(net, tell) -> None:
    """Changes of every size: an arm that ends without a finding is where it was to be."""
    asked = goals(20)
    off, said = [], Counter()
    changed = [ARM.bent(ARM.points + np.array([by, 0.0, 0.0])) for by in (5.0, 20.0, 60.0)]
    left, right = ARM.cameras
    changed += [ARM.watched((left, moved_aside(right, by))) for by in (10.0, 40.0, 100.0)]
    changed += [ARM.longer("a2", 1.1), ARM.longer("d4", 0.8)]
    for arm in changed:
        for target, points in zip(arm.seen(asked.points), asked.points, strict=True):
            try:
                found = MapInUse(net).reach(arm, target, corrections=3)
            except Refused as refused:
                said[refused.findings[0].code] += 1
                continue
            said[found.findings[0].code if found.findings else "reached"] += 1
            if not found.findings:
                off.append(np.linalg.norm(arm.tool(found.joints[None])[0][0] - points))
    assert max(off) < 3.0
    assert set(said) <= {"reached", "LN004", "LN005", "LN012", "LN013", "LN020", "LN021"}
    tell(
        f"learned map, arms and cameras that have changed: {dict(sorted(said.items()))}; "
        f"reached within {max(off):.2f} mm"
    )


def test_a_target_outside_the_ranges_of_the_joints_is_refused(tell) -> None:
    """Joints that are 2 to 10 degrees beyond what was learnt: none is gone to without a word."""
    arm = observed_arm(
        ARM.robot, (), [TOOL_TIP], ("J1", "J2", "J3"), np.array([0.0, 0.0, 0.0, 45.0, 0.0])
    )
    ranges = np.array([[-50.0, 50.0], [0.0, 50.0], [50.0, 100.0]])
    learnt = over_ranges(arm, ranges)
    net = learnt.start()
    train_and_measure(net, learnt.arm, learnt.space, usual_plan(4000))
    draw, said = np.random.default_rng(1), Counter()
    for _ in range(50):
        inside = draw.uniform(ranges[:, 0], ranges[:, 1])
        outside, axis, beyond = inside.copy(), draw.integers(3), draw.uniform(2.0, 10.0)
        low, high = ranges[axis]
        outside[axis] = high + beyond if draw.random() < 0.5 else low - beyond
        for what, joints in (("inside", inside), ("outside", outside)):
            try:
                found = MapInUse(net).reach(learnt.arm, learnt.arm(joints[None])[0], corrections=2)
            except Refused as refused:
                said[what, refused.findings[0].code] += 1
            else:
                said[what, found.findings[0].code if found.findings else "reached"] += 1
    tell(f"learned map, joints inside and outside of its ranges: {dict(said)}")
    assert said["inside", "reached"] >= 49
    assert said["outside", "LN022"] >= 25
    assert said["outside", "reached"] == 0


def test_pixels_that_are_left_are_reported_however_bad_the_map_is() -> None:
    poor = replace(load_map(SMALL), missed=np.full(load_map(SMALL).units, 50.0))
    found = MapInUse(poor).reach(ARM.longer("a2", 1.1), goals(1).pixels[0])
    assert found.missed[-1] > 1.0
    assert [finding.code for finding in found.findings] == ["LN013"]
