"""Cures that no case follows, and what of others none writes, each with the reason."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Final

_LIVE: Final = "a controller has to be there while commands come and go: tests/{}"
_DIED: Final = "a deployment has to die half way: tests/deploy/test_unbreakable.py ends such ones"
_TAUGHT: Final = "points are taught on a controller: tests/cli/test_pulling.py brings them home"
_RUN: Final = "no test comes there: {}; what it says to do is run by {}"

NOT_FOLLOWED: Final[Mapping[str, str]] = {
    "CK442": "the planner is asked for a way by itself: tests/cell/planning/test_planner.py",
    "CK455": "a body has to be open and carried: tests/cell/exploration/test_filling.py closes it",
    "CK492": "the recording is of another run, by `monitor --log`, which CK480 and CK481 follow",
    "CK493": "it is asked of Python: tests/cell/exploration/test_known_space.py",
    "CL047": _LIVE.format("view/test_live.py"),
    "CL048": _LIVE.format("view/test_live.py"),
    "CL060": "a browser has to be missing: tests/view/test_reports.py has one that does not open",
    "CL055": "somebody sits at a terminal: tests/project/test_starting_values.py has one",
    "CL121": "an editor speaks to the command over pipes: tests/virtual/test_debugging.py",
    "CL903": "the environment has it: tests/cli/test_warm_server.py sets it",
    "CL251": _LIVE.format("cli/test_follow.py"),
    "CL254": _LIVE.format("cli/test_follow.py"),
    "CL511": "a controller is led to what is shown: tests/cli/test_pointing.py",
    "CL293": "a gateway runs until it is ended: tests/cli/test_gateways.py",
    "CN652": "another way leads the arm: tests/cli/test_exploring_safely.py asks for none",
    "CN653": "a program that runs decides: tests/cli/test_exploring_safely.py asks it",
    "CN113": _LIVE.format("cli/test_follow.py"),
    "CN115": "the line has to leave this computer: tests/cli/test_clear_text.py has one made up",
    "CN116": "the line has to leave this computer: tests/cli/test_clear_text.py has one made up",
    "CN118": "a deployment starts the controller then: tests/controllers/test_named.py",
    "CN208": _LIVE.format("controllers/abb/rws/test_session.py"),
    "CN512": "a controller runs the module: tests/controllers/abb/test_exchange.py",
    "CN518": "a module of an earlier version runs: tests/controllers/abb/test_exchange.py",
    "CN519": "another process exchanges poses: tests/controllers/abb/test_exchange.py",
    "CN719": _LIVE.format("controllers/mitsubishi/mxt/test_client.py"),
    "CO080": "tests/cli/test_translation_walk.py names the arm, and its joint angles change",
    "CO335": "a program of many files takes its time: tests/compiler/test_keeping.py",
    "CO623": "this package has to be at fault: tests/compiler/test_program_forms.py changes texts",
    "CO702": _LIVE.format("cli/test_moving.py"),
    "CO715": _LIVE.format("compiler/test_teaching.py"),
    "CT204": "a curve so wild is made by a function: tests/sources/contours",
    "CT208": "a process file is refused first, by CT309: tests/sources/contours",
    "LM008": "a process has to die twice: tests/program/system/test_worker_processes.py has it die",
    "LM013": "a cluster has to be there and be lost: tests/cli/test_cluster.py",
    "LM014": "it is said on Windows alone",
    "MB297": "2,000 positions of a stem are needed: tests/compiler/test_taught_names.py has them",
    "DP205": _LIVE.format("cli/test_deployments.py"),
    "DP208": _DIED,
    "DP210": _DIED,
    "DP211": _RUN.format(
        "a deployment dies, and somebody changes what it left", "tests/cli/test_pulling.py"
    ),
    "DP225": _RUN.format(
        "a deployment ends while its controller is gone", "tests/deploy/test_unbreakable.py"
    ),
    "DP229": _LIVE.format("cli/test_deployments.py"),
    "DP234": "a controller needs two tasks with one module: tests/deploy/test_memory.py",
    "DP305": _DIED,
    "DP306": _DIED,
    "ED011": "a port has to be taken meanwhile: tests/editing/test_server.py takes one",
    "CL105": "a controller runs until it is ended: tests/cli/test_exploring_arms.py",
    "CL284": "an arm would move: tests/cli/test_exploring_arms.py",
    "LN001": "a map is learnt for minutes: tests/learning/maps/test_map_files.py",
    "LN104": "poses are made by numbers of the arm: tests/learning/calibration/test_bad_poses.py",
    "LN105": "poses are made by numbers of the arm: tests/learning/calibration/test_bad_poses.py",
    "LN117": "poses are made by numbers of the arm: tests/learning/calibration/test_bad_poses.py",
    "LN118": "poses are made by numbers of the arm: tests/learning/calibration/test_commands.py",
    "LN122": "poses are made by numbers of the arm: tests/learning/calibration/test_bad_poses.py",
    "LM001": "how long it takes is up to the computer: tests/program/system/test_budgets.py",
    "LM002": "it would be the memory of the test: tests/program/system/test_budgets.py",
    "PR203": _RUN.format("the system kills a process that builds", "tests/cli/test_projects.py"),
    "PR501": _TAUGHT,
    "PR502": _TAUGHT,
    "PR503": _TAUGHT,
    "PR506": _RUN.format("a program vanishes between two looks", "tests/cli/test_pulling.py"),
    "PR508": _TAUGHT,
    "RA333": "a gateway runs until it is ended: tests/virtual/test_translated_bytes.py",
    "RB009": "it is asked of Python: tests/robots/test_coupling.py",
    "ST002": _LIVE.format("studio/test_serving.py"),
    "VS111": "a device moves from frame to frame: tests/vision/pointing/test_holding.py",
    "VS326": "pictures of two cameras are wanted: tests/vision/recognition/test_commands.py",
    "VS380": "a program asks at the other end: tests/vision/test_seen_answers.py",
    "VS382": "a program asks at the other end: tests/vision/test_seen_answers.py",
}
"""Rules whose cure names an option, a command or a key that is only looked up."""

_GIT: Final = "what was changed comes home into a repository: tests/cli/test_pulling.py"
_NUMBERS: Final = "the columns are there, and what is written is their numbers"
_SAME: Final = "the table is there, and what is written is a key in it"
_BINARY: Final = "the file is no text, so its names are not seen; the case has both"

NOT_WRITTEN: Final[Mapping[tuple[str, str], str]] = {
    ("CL282", "--box"): "one of both bounds is enough",
    ("CL283", "--camera"): "one source of contacts is enough",
    ("CL283", "--key"): "one source of contacts is enough",
    ("CO010", "kind"): "the direction is what is changed",
    ("CO073", "type"): "the type is written with the value that belongs to it",
    ("CO112", "--signals"): "the script that it names is what is changed",
    ("CO114", "--signals"): "the script that it names is what is changed",
    ("CO128", "--signals"): "the script that it names is what is changed",
    ("CO622", "constants"): "the points are arrays there, and these are what is changed",
    ("CO622", "style"): _SAME,
    ("DP204", "--pull"): _GIT,
    ("DP222", "--pull"): _GIT,
    ("MB201", "translate"): "the program is translated already; it is the option that is added",
    ("SR014", "seen"): _SAME,
    ("SR015", "seen"): _SAME,
    ("TB134", "back"): _NUMBERS,
    ("TB134", "down"): _NUMBERS,
    ("TB134", "flip"): _NUMBERS,
    ("TB313", "motion"): _SAME,
    ("TB415", "positions"): _BINARY,
    ("TB415", "quaternions"): _BINARY,
    ("TB508", "targets"): "the word is there already; it is the brackets that change",
    ("TB516", "moves"): "the word is there already; the list grows",
    ("CT237", "motion"): "the table is there already; the key is left out of it",
    ("CL079", "--jobs"): "the option is there already, and so is --on",
    ("CL079", "--on"): "the option is there already, with another value",
}
"""Of followed cures, by code and what they name."""
