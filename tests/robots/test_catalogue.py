"""The catalogue: every file loads, and a file that says something wrong is told so."""

from __future__ import annotations

import tomllib
from importlib.resources import files

import pytest

from assistant import robots
from assistant.base.diagnostics import Refused, Unreadable
from assistant.robots import robot_file

GOOD = (
    files("assistant.robots")
    .joinpath("catalogue", "rv-2aj.toml")
    .read_text("utf-8")
    .replace("repeatability_mm", "# repeatability_mm")
)


@pytest.mark.parametrize("name", robots.names())
def test_every_robot_is_whole(name: str) -> None:
    robot = robots.get(name)
    assert robot.name == name
    assert robot.limits.shape == (len(robot.axes), 2)
    assert robot.speeds.shape == robot.home.shape == (len(robot.axes),)
    assert robot.inside(robot.home)
    assert robot.source
    assert robot.reach == pytest.approx(robot.arm.reach, abs=0.1)
    assert robot.counts == ("quadrants" if robot.maker == "ABB" else "turns")


def test_names_of_the_catalogue() -> None:
    assert {"irb1200-7-0.7", "irb1200-5-0.9", "irb120-3-0.58", "rv-2aj", "rv-4frl"} <= set(
        robots.names()
    )
    assert robots.get("RV-2AJ").name == "rv-2aj"
    assert robots.get("rv-2aj").axes == ("J1", "J2", "J3", "J5", "J6")


def test_axis_three_of_a_scara_is_in_millimetres() -> None:
    robot = robots.get("rh-6frh5520")
    assert robot.axes == ("J1", "J2", "J3", "J4")
    assert robot.units == ("degrees", "degrees", "mm", "degrees")
    assert robot.limits[2].tolist() == [133.0, 333.0]
    with pytest.raises(TypeError, match="RH-6FRH5520"):
        assert robot.lengths


def test_what_not_every_source_tells() -> None:
    known, unknown = robots.get("rv-4frl"), robots.get("irb140-6-0.81")
    assert known.accelerations is not None
    assert known.accelerations.shape == known.speeds.shape
    assert known.repeatability == 0.02
    assert unknown.accelerations is unknown.repeatability is unknown.tcp_speed is None


@pytest.mark.parametrize("name", robots.names())
def test_unconfirmed_names_fields_of_the_file(name: str) -> None:
    file = files("assistant.robots").joinpath("catalogue", f"{name}.toml")
    for field in robots.get(name).unconfirmed:
        entry = tomllib.loads(file.read_text("utf-8"))
        for key in field.split("."):
            entry = entry[key]


def test_an_unknown_name_lists_the_known_ones() -> None:
    with pytest.raises(KeyError, match="rv-2aj"):
        robots.get("irb9999")


@pytest.mark.parametrize(
    ("old", "new", "field"),
    [
        ('name = "rv-2aj"', "", "name"),
        ('name = "rv-2aj"', 'name = "my arm"', "name"),
        ('name = "rv-2aj"', 'name = "../x"', "name"),
        ('controller = "CR1"', 'controller = "a\\nb"', "controller"),
        ("payload_kg = 2", 'payload_kg = "two"', "payload_kg"),
        ("payload_kg = 2", "payload_kg = nan", "payload_kg"),
        ("payload_kg = 2", "payload_kg = 0", "payload_kg"),
        ("payload_kg = 2", f"payload_kg = {'9' * 400}", "payload_kg"),
        ("a2 = 250", "a2 = 1e300", "lengths_mm.a2"),
        ("d1 = 300", "d9 = 300", "lengths_mm.d9"),
        ("d1 = 300", "", "lengths_mm.d1"),
        ("a2 = 250", "a2 = 0", "lengths_mm.a2"),
        ("a3 = 0", "a3 = -50", "lengths_mm"),
        ("limits = [-150, 150]", "limits = [150, -150]", "axes_deg.J1.limits"),
        ("home = 90 }\nJ6", "home = 91 }\nJ6", "axes_deg.J5.home"),
        ("J5 = {", "J4 = {", "axes_deg"),
        ("reach_mm", "axes_mm = 3\nreach_mm", "axes_mm"),
        (
            "[axes_deg]",
            "[axes_mm]\nJ3 = { limits = [0, 1], speed = 1, home = 0 }\n[axes_deg]",
            "axes_deg",
        ),
        ("reach_mm", 'arm = "six-axis"\nreach_mm', "axes_deg"),
        ("reach_mm", 'arm = "scara"\nreach_mm', "axes_mm"),
        ("reach_mm", 'arm = "parallel"\nreach_mm', "arm"),
        ("reach_mm", "arm = [3]\nreach_mm", "arm"),
        ('"turns"', '"quarters"', "configuration"),
        ('languages = ["melfa-basic-4"]', 'languages = "melfa"', "languages"),
        ("reach_mm", "repeatability_mm = 0\nreach_mm", "repeatability_mm"),
        ("speed = 90", "speed = 90, acceleration = -1", "axes_deg.J2.acceleration"),
        ("speed = 90", "speed = 90, acceleration = 900", "axes_deg.J5.acceleration"),
        ("reach_mm", "colour = 1\nreach_mm", "colour"),
    ],
)
def test_a_wrong_field_is_named(old: str, new: str, field: str) -> None:
    assert old in GOOD
    with pytest.raises(Refused) as refused:
        robot_file.read(GOOD.replace(old, new).encode(), "mine.toml")
    assert refused.value.exit_status == 1
    assert field in {finding.place for finding in refused.value.findings}
    assert all(f.code == "RB002" and f.path == "mine.toml" for f in refused.value.findings)


@pytest.mark.parametrize(
    "data", [b"name = ", b"\xff\xfe", b"= 3", b"a = " + b"9" * 5000, b"a = " + b"[" * 50000]
)
def test_a_file_that_is_no_toml(data: bytes) -> None:
    with pytest.raises(Unreadable) as refused:
        robot_file.read(data, "mine.toml")
    assert [f.code for f in refused.value.findings] == ["RB001"]


def test_a_robot_of_the_users_own(tmp_path) -> None:
    file = tmp_path / "mine.toml"
    file.write_text(GOOD.replace('name = "rv-2aj"', 'name = "mine"'), encoding="utf-8")
    assert robots.load(file).name == "mine"
    with pytest.raises(Unreadable):
        robots.load(tmp_path / "missing.toml")
