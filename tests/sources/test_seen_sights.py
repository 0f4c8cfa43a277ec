"""Files of what was found, and how far it is trusted."""

from __future__ import annotations

import datetime
import math
from pathlib import Path
from tempfile import TemporaryDirectory

import pytest
from hypothesis import given
from hypothesis import strategies as st

from assistant.base.diagnostics import Refused
from assistant.program.geometry import Frame, Pose
from assistant.program.settings_tables import Wrong
from assistant.sources.process.file import read_process
from assistant.sources.seen_settings import PoseServer, Trust
from assistant.sources.sights import Sight, doubts, read_sights, seeing

NOW = datetime.datetime(2026, 1, 31, 12, 0, tzinfo=datetime.UTC)
SIGHT = Sight("bracket", Pose((300.0, 0.0, 20.0)), 0.2, 0.1, 0.97, NOW)
FOUND = """[found.bracket]
position = [300, 0, 20]
quaternion = [1, 0, 0, 0]
sigma_mm = 0.2
sigma_deg = 0.1
confidence = 0.97
seen = 2026-01-31T13:00:00+01:00
"""


def written(folder: Path, text: str, name: str = "found.toml") -> Path:
    (folder / name).write_text(text, "utf-8")
    return folder / name


def refused(path: Path) -> list[str]:
    with pytest.raises(Refused) as caught:
        read_sights(path)
    assert caught.value.exit_status == 2
    return [finding.code for finding in caught.value.findings]


def test_a_file_of_what_was_found_is_read(tmp_path: Path):
    assert read_sights(written(tmp_path, FOUND)) == {"bracket": SIGHT}


def test_keys_that_nobody_needs_here_are_left_aside(tmp_path: Path):
    text = FOUND + "pixels = 800\n\n[unknown]\ncount = 2\n"
    assert read_sights(written(tmp_path, text)) == {"bracket": SIGHT}


def test_a_text_is_a_date_too_and_a_date_without_a_zone_is_of_this_computer(tmp_path: Path):
    text = FOUND.replace("2026-01-31T13:00:00+01:00", '"2026-01-31T12:00:00Z"')
    assert read_sights(written(tmp_path, text))["bracket"].seen == NOW
    local = FOUND.replace("2026-01-31T13:00:00+01:00", "2026-01-31T13:00:00")
    seen = read_sights(written(tmp_path, local))["bracket"].seen
    assert seen == datetime.datetime(2026, 1, 31, 13).astimezone()


@pytest.mark.parametrize(
    ("text", "code"),
    [
        ("", "IN005"),
        ("[found]\n", "SR010"),
        ("found = 1\n", "CT304"),
        (FOUND.replace("sigma_mm = 0.2\n", ""), "SR011"),
        (FOUND.replace("confidence = 0.97", "confidence = 1.5"), "CT303"),
        (FOUND.replace("sigma_deg = 0.1", "sigma_deg = nan"), "CT303"),
        (FOUND.replace("sigma_deg = 0.1", "sigma_deg = -1"), "CT303"),
        (FOUND.replace("[1, 0, 0, 0]", "[0, 0, 0, 0]"), "CT303"),
        (FOUND.replace("[300, 0, 20]", "[300, nan, 20]"), "CT303"),
        (FOUND.replace("2026-01-31T13:00:00+01:00", '"yesterday"'), "CT303"),
        (FOUND.replace("2026-01-31T13:00:00+01:00", "2026-01-31"), "CT303"),
        (FOUND + 'frame = "camera"\n', "CT303"),
    ],
)
def test_what_is_wrong_in_it_is_a_finding(tmp_path: Path, text: str, code: str):
    assert code in refused(written(tmp_path, text))


@given(st.integers(0, len(FOUND)), st.integers(0, 8), st.text(max_size=6))
def test_any_text_is_read_or_refused(at: int, count: int, text: str):
    with TemporaryDirectory() as folder:
        file = Path(folder) / "found.toml"
        file.write_bytes((FOUND[:at] + text + FOUND[at + count :]).encode("utf-8", "replace"))
        try:
            sights = read_sights(file)
        except Refused as caught:
            assert caught.exit_status == 2 and caught.findings
            return
    for one in sights.values():
        list(doubts(one, now=NOW))


def test_what_is_no_toml_cannot_be_read(tmp_path: Path):
    assert refused(written(tmp_path, "[found")) == ["CT301"]


@pytest.mark.parametrize(
    ("changed", "code"),
    [
        ({"seen": NOW - datetime.timedelta(seconds=601)}, "SR012"),
        ({"seen": NOW + datetime.timedelta(seconds=10)}, "SR013"),
        ({"sigma_mm": 1.01}, "SR014"),
        ({"sigma_deg": 1.01}, "SR014"),
        ({"sigma_mm": math.nan}, "SR014"),
        ({"confidence": 0.79}, "SR015"),
    ],
)
def test_what_is_doubtful_is_told(changed: dict[str, object], code: str):
    told = {name: getattr(SIGHT, name) for name in SIGHT.__slots__}
    assert [one.code for one in doubts(Sight(**{**told, **changed}), now=NOW)] == [code]


def test_what_is_within_its_limits_is_not(tmp_path: Path):
    assert not list(doubts(SIGHT, now=NOW + datetime.timedelta(seconds=599)))
    wide = Trust(oldest=1e6, sigma_mm=5.0, sigma_deg=5.0, confidence=0.5)
    old = NOW + datetime.timedelta(days=3)
    assert not list(doubts(Sight("b", Pose(), 4.0, 4.0, 0.6, NOW), wide, old))


def test_a_process_file_says_what_is_seen_and_how_it_is_trusted(tmp_path: Path):
    text = (
        '[frames.part]\nposition = [300, 0, 20]\nseen = "M6 bolt"\n\n'
        '[seen]\nask = "192.168.0.5:10010"\nfound = "now.toml"\noldest = 60\nwithin = 50\n'
    )
    process = read_process(written(tmp_path, text, "p.toml"))
    assert process.frames == {"part": Frame(Pose((300.0, 0.0, 20.0)), seen="M6 bolt")}
    assert process.seen.ask == PoseServer("client", "192.168.0.5", 10010)
    assert process.seen.trust == Trust(oldest=60.0, within=50.0)
    assert process.seen.found == str(tmp_path / "now.toml")


@pytest.mark.parametrize(
    "line",
    [
        *('ask = "nowhere"', 'ask = "pc:99999"', 'ask = "line:9"', "ask = 1", "oldest = 0"),
        *('found = "../found.toml"', 'found = "a/b.toml"', 'found = ""', "confidence = 2"),
    ],
)
def test_what_is_wrong_of_it_is_told_there(tmp_path: Path, line: str):
    with pytest.raises(Refused) as caught:
        read_process(written(tmp_path, f"[seen]\n{line}\n", "p.toml"))
    assert [(one.code, one.line) for one in caught.value.findings] == [("CT303", 2)]


@pytest.mark.parametrize(
    ("text", "asking"),
    [
        ("pc-2.local:10010", PoseServer("client", "pc-2.local", 10010)),
        ("listen:192.168.0.20:10003", PoseServer("server", "192.168.0.20", 10003)),
        ("line:3", PoseServer("line", "", 3)),
    ],
)
def test_whom_a_program_asks(text: str, asking: PoseServer):
    assert PoseServer.parse(text) == asking


def test_an_address_of_nobody_is_refused():
    with pytest.raises(Wrong):
        PoseServer.parse('pc":1')
    with pytest.raises(Refused) as caught:
        seeing(ask="pc")
    assert [one.code for one in caught.value.findings] == ["SR016"]
    assert caught.value.exit_status == 2
