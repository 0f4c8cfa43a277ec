"""Where motions of MELFA-BASIC lead, worked out by hand from the manuals' words."""

from __future__ import annotations

import math

import pytest

from assistant import robots
from assistant.base import rotations
from tests.virtual.melfa_cell import moves, run, shown

# ----------------------------------------------------------------------------------- positions


def test_a_product_moves_along_the_tool_and_a_sum_in_the_base() -> None:
    done = run("Mvs P1*(0,0,10,0,0,0)\nMvs P1+(0,0,10,0,0,0)(0,0)\nMvs P1,-20\nEnd")
    assert shown(done) == [(400, 0, 490), (400, 0, 510), (400, 0, 520)]


def test_a_product_turns_what_stands_right_of_it() -> None:
    turned = "PF=(100,0,0,0,0,90)(0,0)\nPA=(10,20,30,0,0,0)(7,0)"
    assert shown(run(f"{turned}\nMvs PF*PA\nEnd")) == [(80, 10, 30)]
    assert shown(run(f"{turned}\nMvs Inv(PF)*PF*PA\nEnd")) == [(10, 20, 30)]
    assert shown(run(f"{turned}\nMvs PA/PF\nEnd")) == [(10, 120, 30)]


def test_components_are_radian_and_mm() -> None:
    done = run("P9=P1\nP9.X=P2.X+1\nP9.C=P9.C-Rad(90)\nMvs P9\nEnd")
    (one,) = moves(done)
    assert one.flange is not None and one.flange.position == pytest.approx((451, 0, 500))
    wanted = rotations.from_euler((90.0, 0.0, 180.0))
    assert one.flange.quaternion == pytest.approx(tuple(wanted))


def test_positions_are_scaled_and_halved() -> None:
    done = run("Mvs (P1+P2)/2\nEnd")
    assert shown(done) == [(425, 25, 500)]


def test_joints_are_degrees_as_constants_and_radian_as_components() -> None:
    done = run("J1=(0,10,80,0,90,0)\nJ1.J1=Rad(30)\nMov J1\nEnd")
    (one,) = moves(done)
    assert one.joints == pytest.approx((30, 10, 80, 0, 90, 0)) and one.flange is None


def test_with_a_robot_joints_become_poses_and_back() -> None:
    robot = robots.get("rv-4frl")
    done = run(
        "J1=(20,10,80,15,60,30)\nMov J1\nP8=P_Curr\nMov P8\nJ2=J_Curr\nMov J2\nEnd", robot=robot
    )
    first, second, third = moves(done)
    assert first.flange is not None and second.flange is not None
    assert second.flange.position == pytest.approx(first.flange.position)
    assert third.joints == pytest.approx((20, 10, 80, 15, 60, 30), abs=1e-6)


# -------------------------------------------------------------------------------- tool and base


def test_a_tool_holds_at_once() -> None:
    done = run("Tool PT\nMvs P1\nTool P_NTool\nP9=P_Curr\nMvs P9\nEnd")
    first, second = moves(done)
    assert first.flange is not None and second.flange is not None
    assert first.flange.position == pytest.approx((400, 0, 600))
    assert second.flange.position == pytest.approx((400, 0, 600))  # where it stands


def test_the_base_is_where_the_robot_stands() -> None:
    """Shown = Base · flange · Tool, so a base moved by 100 takes 100 off."""
    done = run("PB=(100,0,0,0,0,0)(0,0)\nBase PB\nMvs P1\nP9=P_Curr\nBase P_NBase\nMvs P9\nEnd")
    flanges = [one.flange for one in moves(done)]
    assert [f.position[0] for f in flanges if f] == pytest.approx([300, 400])


def test_a_distance_alone_goes_from_here_along_the_tool() -> None:
    assert shown(run("Mvs P1\nMvs ,-30\nEnd")) == [(400, 0, 500), (400, 0, 530)]


# ------------------------------------------------------------------------------------ settings


def test_speeds_and_corners() -> None:
    text = "Spd 100\nOvrd 50\nJOvrd 40\nCnt 1,20,10\nMov P1\nMvs P2\nCnt 0\nSpd M_NSpd\nMvs P1\nEnd"
    one, two, three = moves(run(text))
    assert (one.speed, one.percent, one.blend) == (None, 20, 10)
    assert (two.speed, two.percent, two.blend) == (50, None, 10)
    assert (three.speed, three.blend) == (None, 0)


def test_cnt_without_sizes_is_of_the_controllers_choice() -> None:
    assert moves(run("Cnt 1\nMvs P1\nEnd"))[0].blend == math.inf


@pytest.mark.parametrize("text", ["Ovrd 0", "Ovrd 101", "Spd 0", "JOvrd 0", "Dly -1"])
def test_settings_out_of_range_are_refused(text: str) -> None:
    assert run(f"{text}\nEnd").message.startswith("error 3110")


def test_straight_moves_want_one_posture() -> None:
    other = "P9=(400,0,500,180,0,180)(6,0)"
    assert run(f"{other}\nMvs P1\nMvs P9\nEnd").message.startswith("error 2810")
    assert run(f"{other}\nMvs P1\nMov P9\nEnd").ended == "end"


# ---------------------------------------------------------------------------------------- arcs


def test_an_arc_begins_with_a_straight_move_to_its_start() -> None:
    kinds = [one.kind for one in moves(run("Mvr P1,P2,P3\nEnd"))]
    assert kinds == ["linear", "circular"]
    assert [one.kind for one in moves(run("Mvs P1\nMvr P1,P2,P3\nEnd"))] == ["linear", "circular"]


def test_mvr2_goes_round_the_other_side() -> None:
    """The circle about (400, 50): from P1 to P3, not over P2 on its right."""
    done = moves(run("Mvs P1\nMvr2 P1,P3,P2\nEnd"))
    assert done[1].via is not None
    assert done[1].via.position == pytest.approx((350, 50, 500))


def test_mvr3_goes_about_its_centre_by_less_than_half_a_turn() -> None:
    done = moves(run("PC=(400,50,500,180,0,180)(7,0)\nMvs P1\nMvr3 P1,P2,PC\nEnd"))
    half = math.sqrt(0.5) * 50
    assert done[1].via is not None
    assert done[1].via.position == pytest.approx((400 + half, 50 - half, 500))


def test_mvc_comes_back() -> None:
    done = moves(run("Mvs P1\nMvc P1,P2,P3\nEnd"))
    assert [one.kind for one in done] == ["linear", "circular", "circular"]
    assert shown(run("Mvs P1\nMvc P1,P2,P3\nEnd"))[-1] == (400, 0, 500)


def test_three_places_on_a_line_are_a_straight_move() -> None:
    done = moves(run("PA=P1+(50,0,0,0,0,0)(0,0)\nPB=P1+(90,0,0,0,0,0)(0,0)\nMvr P1,PA,PB\nEnd"))
    assert [one.kind for one in done] == ["linear", "linear"]


# ------------------------------------------------------------------------------------- pallets


@pytest.mark.parametrize(
    ("direction", "at", "place"),
    [
        (2, 1, (400, 0)), (2, 3, (440, 0)), (2, 4, (400, 50)), (2, 6, (440, 50)),
        (1, 3, (440, 0)), (1, 4, (440, 50)), (1, 6, (400, 50)),
    ],
)  # fmt: skip
def test_pallets(direction: int, at: int, place: tuple[float, float]) -> None:
    done = run(
        "PA=P1+(40,0,0,0,0,0)(0,0)\nPB=P1+(0,50,0,0,0,0)(0,0)\n"
        f"Def Plt 1,P1,PA,PB,,3,2,{direction}\nMvs (Plt 1,{at})\nEnd"
    )
    assert shown(done) == [(*place, 500)]


def test_a_fourth_corner_pulls_the_grid() -> None:
    done = run(
        "PA=P1+(40,0,0,0,0,0)(0,0)\nPB=P1+(0,50,0,0,0,0)(0,0)\nPC=P1+(60,60,0,0,0,0)(0,0)\n"
        "Def Plt 1,P1,PA,PB,PC,3,3,2\nMvs (Plt 1,9)\nMvs (Plt 1,5)\nEnd"
    )
    assert shown(done) == [(460, 60, 500), (425, 27.5, 500)]


def test_a_pallet_has_no_other_points() -> None:
    text = "PA=P1+(40,0,0,0,0,0)(0,0)\nDef Plt 1,P1,PA,P3,,3,2,2\nMvs (Plt 1,7)\nEnd"
    assert run(text).message.startswith("error 3110")
    assert run("Mvs (Plt 1,1)\nEnd").message.startswith("error 3850")
