"""The commands that look at and keep an IRC5, by Robot Web Services."""

from __future__ import annotations

import csv
import json

from assistant.sources import read
from assistant.virtual.irc5 import VirtualIrc5
from assistant.virtual.irc5.cabinet import Signal
from tests.cli.test_commands import run

MODULE = "MODULE cell\nPERS num made:=0;\nPROC main()\n  made:=made+1;\nENDPROC\nENDMODULE\n"


def test_an_irc5_from_a_shell(capsys, monkeypatch, tmp_path, here):
    (here / "cell.mod").write_text(MODULE, encoding="utf-8")
    signals = (Signal("doGrip", "DO"), Signal("diPart", "DI"))
    home = tmp_path / "home"
    with VirtualIrc5(home, password="secret", rate=10.0, rwss=None, signals=signals) as irc5:
        monkeypatch.setenv("ROBOT_ASSISTANT_CELL1_PASSWORD", "secret")
        table = f'address = "{irc5.rws_address}"\nrobot = "irb1200-7-0.7"\ntimeout = 5\n'
        (tmp_path / "assistant.toml").write_text(f"[controllers.cell1]\n{table}", encoding="utf-8")

        def said(*arguments: object) -> str:
            status, out, wrong = run(capsys, arguments[0], "cell1", *arguments[1:])
            assert status == 0, wrong
            return out

        said("put", "cell.mod")
        assert said("ls") == "cell.mod\n"
        said("get", "cell.mod", "-o", "back.mod")
        assert (here / "back.mod").read_bytes() == (here / "cell.mod").read_bytes()
        said("motors", "on", "--yes")
        assert "the program has ended" in said("start", "cell.mod", "--yes")
        assert said("variables", "made", "--program", "cell") == "made = 1\n"
        assert said("variables", "made=7", "--program", "cell") == "made = 7\n"
        assert said("outputs", "doGrip=on", "--yes") == "doGrip = 1\n"
        assert said("inputs", "diPart") == "diPart = 0\n"
        watching = ("--seconds", "0.05", "--interval", "0.02", "--signals", "doGrip")
        said("monitor", *watching, "--log", "run.csv")
        with (here / "run.csv").open(newline="") as file:
            assert {row["_doGrip"] for row in csv.DictReader(file)} == {"1.0"}
        assert len(json.loads(said("log", "--most", "2", "--format", "json"))["log"]) == 2
        assert "errors acknowledged" in said("reset")
        assert "stopped" in said("stop")
        said("teach", "above", "--now")
        assert read(here / "taught.toml").program.targets["above"].configuration is not None
        assert "saved" in said("backup", "saved")
        (home / "cell.mod").write_text(MODULE.replace("+1", "+2"), encoding="utf-8")
        assert "made:=made+1" in said("restore", "saved", "--dry-run")
        assert "+2" in (home / "cell.mod").read_text()
        said("restore", "saved", "--yes")
        assert "+1" in (home / "cell.mod").read_text()
