"""Merged programs, run by the virtual controllers, go where the source and the touch-ups say."""

from __future__ import annotations

import re
import tempfile
from pathlib import Path

import ezdxf
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from assistant import compile as compiled
from assistant.compiler.merge_edits import Keeper, written_in
from assistant.virtual.events import Moved
from tests.compiler.same_motion import ran
from tests.examples import drawn

ABOVE = 40
Z = 300
SPOTS = [(x, y) for x in range(380, 500, 20) for y in range(-100, 120, 20)]
NUDGES = st.tuples(*(st.sampled_from((-1.5, -0.5, 0.5, 1.25)) for _ in range(3)))


def program(folder, beads, language):
    """The text of beads that were drawn in this order, as it is compiled."""
    drawing = ezdxf.new("R2010", units=4)
    for first, last in beads:
        ends = ((*first, Z), (*last, Z))
        drawing.modelspace().add_line(*ends, dxfattribs={"layer": "SEAM"})
    file = folder / "part.dxf"
    drawing.saveas(file)
    process = folder / "part.process.toml"
    placed = "[placement]\nposition = [0, 0, 0]\n"
    seam = f"[layers.SEAM]\nspeed = 50\napproach = {ABOVE}\nretract = {ABOVE}\n"
    process.write_text(placed + seam)
    done = compiled(file, language=language, robot="rv-4frl" if language != "rapid" else None)
    assert done.ok, done.findings
    ((_, data),) = done.files.items()
    return data


def merged(folder, base, edited, made, language):
    """The merged text, None if that was refused."""
    file, memory = folder / "part.txt", written_in(folder)
    memory.mkdir(parents=True, exist_ok=True)
    (memory / "part.txt.written").write_bytes(base)
    file.write_bytes(edited)
    kept = Keeper(language).kept({file: made}, memory)
    return kept.files[file] if kept.ok else None


def way(text, language):
    """Where the tip ends each motion."""
    done = ran(text.decode("ascii"), language)
    assert done.ended == "end", done.message
    ends = [one.flange @ one.tool for one in done.events if isinstance(one, Moved)]
    return [tuple(round(v, 2) + 0.0 for v in end.position) for end in ends]


def touched(text, at, nudge, language):
    """The text with the target at a place taught anew there."""
    if language == "rapid":
        old = f":=[[{at[0]},{at[1]},{Z}]"
        new = f":=[[{at[0] + nudge[0]:g},{at[1] + nudge[1]:g},{Z + nudge[2]:g}]"
    else:
        old = f"=({at[0]:+.2f},{at[1]:+.2f},{Z:+.2f},"
        new = f"=({at[0] + nudge[0]:+.2f},{at[1] + nudge[1]:+.2f},{Z + nudge[2]:+.2f},"
    assert text.count(old.encode()) == 1, old
    return text.replace(old.encode(), new.encode())


def moved(places, nudges):
    """Places with those that were touched up, and what is above them, where they are then."""
    found = []
    for x, y, z in places:
        dx, dy, dz = nudges.get((x, y), (0, 0, 0))
        found.append((round(x + dx, 2), round(y + dy, 2), round(z + dz, 2)))
    return found


@pytest.mark.parametrize("language", ["rapid", "melfa-basic-5"])
def test_a_touched_up_start_takes_the_place_above_it_along(tmp_path, language):
    beads = [((400, -100), (440, -100)), ((460, -60), (400, -60))]
    base = program(tmp_path, beads, language)
    edited = touched(base, (460, -60), (1.5, -0.5, 0.5), language)
    made = program(tmp_path, [((440, -140), (400, -120)), *beads], language)
    text = merged(tmp_path, base, edited, made, language)
    assert text is not None
    found = way(text, language)
    assert found == moved(way(made, language), {(460, -60): (1.5, -0.5, 0.5)})
    assert (461.5, -60.5, 340.5) in found and (461.5, -60.5, 300.5) in found
    assert not any((x, y) == (460, -60) for x, y, _ in found)


@st.composite
def changes(draw):
    """Beads, those of the next drawing, and touch-ups by the points that they are of."""
    spots = draw(st.permutations(SPOTS))
    beads = [(spots.pop(), spots.pop()) for _ in range(draw(st.integers(2, 4)))]
    points = [point for bead in beads for point in bead]
    nudges = draw(st.dictionaries(st.sampled_from(points), NUDGES, min_size=1, max_size=3))
    after = [bead for bead in beads if draw(st.integers(0, 4))]
    after = [
        (spots.pop(), last) if kind == 0 else (first, spots.pop()) if kind == 1 else (first, last)
        for first, last in after
        for kind in [draw(st.integers(0, 6))]
    ]
    after += [(spots.pop(), spots.pop()) for _ in range(draw(st.integers(not after, 2)))]
    return beads, draw(st.permutations(after)), nudges


def check(case):
    beads, after, nudges = case
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        base = program(folder, beads, "rapid")
        made = program(folder, after, "rapid")
        edited = base
        for at, nudge in nudges.items():
            edited = touched(edited, at, nudge, "rapid")
        text = merged(folder, base, edited, made, "rapid")
        starts, now = _ends(base), _ends(made)
        whole = {point for bead in starts if bead in now for point in bead}
        gone = {p for bead in starts for k, p in enumerate(bead) if p not in {n[k] for n in now}}
        if text is None:
            assert not set(nudges) <= whole, "what has not changed is refused"
            return
        assert not gone & set(nudges), "an edit is lost"
        assert way(text, "rapid") == moved(way(made, "rapid"), nudges)


def _ends(text):
    """The first and the last point of each bead, as they are worked."""
    found = dict(re.findall(r"robtarget (\w+):=\[\[([^\]]*)\]", text.decode()))
    places = {k: tuple(int(float(v)) for v in at.split(",")[:2]) for k, at in found.items()}
    names = [name.removesuffix("_start") for name in places if name.endswith("_start")]
    return [(places[f"{name}_start"], places[f"{name}_end"]) for name in names]


quick = settings(deadline=None, suppress_health_check=list(HealthCheck))


@settings(quick, max_examples=6)
@given(changes())
def test_touch_ups_follow_their_places_or_are_refused(case):
    check(case)


@pytest.mark.slow
@settings(quick, max_examples=drawn(150))
@given(changes())
def test_many_touch_ups_follow_their_places_or_are_refused(case):
    check(case)
