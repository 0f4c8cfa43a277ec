"""Files are written by one mechanism: who opens one to write it by himself is known, and why."""

from __future__ import annotations

import re
from pathlib import Path

PACKAGE = Path(__file__).parent.parent / "assistant"
WRITES = re.compile(
    r"\.write_(?:bytes|text)\((?!self\b|given\b)|\bopen\([^)\n]*[\"'][wxa]b?\+?[\"']"
    r"|\bnp\.savez?(?:_compressed)?\(|\bsavefig\(|\bto_csv\(|\bos\.(?:replace|rename)\(|\bshutil\.(?:move|copy)"
)
KNOWN = {
    "base/file_access.py": "it is the mechanism",
    "program/pseudo/path_rows.py": "into memory",
    "cell/exploration/occupancy.py": "into memory",
    "report/figures.py": "into memory",
    "report/timing.py": "into memory",
    "report/workspace.py": "into memory",
    "base/mirrored_files.py": "files of another computer, in a folder for the moment",
    "blocks/display.py": "into memory",
    "blocks/fmu/co_simulation.py": "for a compiler, in a folder for the moment",
    "cli/controller_state.py": "a log, which grows by a row at a time",
    "cli/warm_server.py": "a lock and what samples become, in folders for the moment",
    "controllers/abb/ftp.py": "a part that later runs go on with",
    "controllers/abb/sftp.py": "on the controller",
    "controllers/recording.py": "into memory",
    "controllers/cyclic/process.py": "for a process of its own, in a folder for the moment",
    "controllers/cyclic/worker.py": "for the process that started it, in the same folder",
    "learning/map_file.py": "into memory",
    "languages/grammar.py": "kept like bytecode, and made anew where it is damaged",
    "project/builds.py": "in a folder for the moment",
    "virtual/irc5/cabinet.py": "in a folder that appears whole, on a virtual disk",
    "base/certificate.py": "a key, in a folder for the moment",
    "virtual/irc5/rws_files.py": "folders, on the disk of a virtual controller",
    "virtual/proving/compared_programs.py": "modules that a run loads, on a disk for the moment",
    "virtual/run_log.py": "into memory",
    "vision/recognition/object_library.py": "into memory",
}


def test_nobody_else_writes_files_in_a_way_of_his_own() -> None:
    found = {
        file.relative_to(PACKAGE).as_posix()
        for file in PACKAGE.rglob("*.py")
        if WRITES.search(file.read_text(encoding="utf-8"))
    }
    assert found == set(KNOWN)
