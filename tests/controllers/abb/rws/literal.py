"""What a controller answers, literally, in both dialects; see `test_literal`."""

import json
from datetime import datetime

from assistant.controllers.states import Fault, Position
from tests.controllers.abb.rws.peer import li, rows, xhtml


def hal(*items, embedded=False, following=""):
    links = {"base": {"href": "https://127.0.0.1/rw/"}, "self": {"href": ""}}
    if following:
        links["next"] = {"href": following}
    inside = {"_embedded": {"resources": items}} if embedded else {"state": items}
    return json.dumps({"_links": links, "status": {"code": 294912}, **inside})


def old_json(*items):
    return json.dumps({"_links": {"base": {"href": "x"}}, "_embedded": {"_state": items}})


def row(kind, title="", /, **values):
    return {"_type": kind, "_title": title, **{k.replace("_", "-"): v for k, v in values.items()}}


TASK = {"name": "T_ROB1", "type": "norm", "taskstate": "linked", "excstate": "stop", "active": "On"}
TASKS_1 = rows(li("rap-task-li", "T_ROB1", **TASK, motiontask="TRUE"))
TASKS_2 = hal(
    row("rap-tasks-spy-li", "spy"),
    row("rap-task-li", "T_ROB1", **{**TASK, "excstate": "ready"}, motiontask="TRUE"),
    embedded=True,
)
EVENT = {
    "msgtype": "3", "code": "50204", "tstamp": "2026-07-08 T 18:04:04",
    "title": "Motion supervision", "desc": "Motion supervision triggered.",
    "actions": "Check the load.", "conseqs": "", "causes": "", "argc": "0",
}  # fmt: skip
OLDER = {
    **EVENT,
    "msgtype": "1",
    "code": "10046",
    "title": "System reset",
    "desc": "",
    "actions": "",
}
FAULTS = (
    Fault(
        50204,
        "Motion supervision: Motion supervision triggered.",
        "error",
        "Check the load.",
        datetime(2026, 7, 8, 18, 4, 4),
    ),
    Fault(10046, "System reset", "info", "", datetime(2026, 7, 8, 18, 4, 4)),
)
JOINTS = {f"rax_{n}": v for n, v in enumerate(("10", "15", "-10.5", "20", "30", "45"), start=1)}
EXTERNAL = {f"eax_{a}": "8.999999488E+09" for a in "abcdef"}
POSE = {
    "x": "512.34",
    "y": "-123.45",
    "z": "800",
    "q1": "0.5",
    "q2": "0.5",
    "q3": "0.5",
    "q4": "0.5",
}
POSE |= {"cf1": "0", "cf4": "-1", "cf6": "1", "cfx": "0"}
POSE |= {f"eax_{a}": "9E+09" for a in "abcdef"}
POSITION = Position(
    (10, 15, -10.5, 20, 30, 45),
    (512.34, -123.45, 800),
    (0.5, 0.5, 0.5, 0.5),
    "[[512.34,-123.45,800],[0.5,0.5,0.5,0.5],[0,-1,1,0],[9E+09,9E+09,9E+09,9E+09,9E+09,9E+09]]",
)
UNIT = {"tool-name": "tGripper", "wobj-name": "wobj0", "type": "TCPRobot", "axes": "6"}
SIGNAL = {"name": "doGripper", "type": "DO", "category": "user", "lvalue": "1"}
TEXT_1 = "MODULE%20m%0a  ! 50%25 %C3%A4%0aENDMODULE"
TEXT = "MODULE m\n  ! 50% ä\nENDMODULE"
REG1 = "RAPID/T_ROB1/user/reg1"
START = "regain=continue&execmode=continue&condition=none&stopatbp=disabled&alltaskbytsp=false"

ONE = {
    "GET /ctrl/identity": rows(
        li("ctrl-identity-info", "identity", ctrl_name="IRC5_7", ctrl_id="12-34567", ctrl_type="RC")
    ),
    "GET /rw/system/robottype": old_json(row("sys-robottype", "robottype", robot_type="IRB 1200")),
    "GET /rw/panel/ctrlstate": rows(li("pnl-ctrlstate", "ctrlstate", ctrlstate="motoron")),
    "GET /rw/panel/opmode": old_json(row("pnl-opmode", "opmode", opmode="AUTO")),
    "GET /rw/panel/speedratio": rows(li("pnl-speedratio", "speedratio", speedratio="70")),
    "GET /rw/rapid/execution": rows(
        li("rap-execution", "execution", ctrlexecstate="stopped", cycle="forever")
    ),
    "GET /rw/rapid/tasks": TASKS_1,
    "GET /rw/rapid/tasks/T_ROB1/pcp": rows(
        li("pcp-info", "pcp", modulemame="Seam", routinename="main", beginposition="14,4")
    ),
    "GET /rw/motionsystem/mechunits/ROB_1": rows(li("ms-mechunit", "ROB_1", **UNIT)),
    "GET /rw/motionsystem/mechunits/ROB_1/jointtarget": rows(
        li("ms-jointtarget", "ROB_1", **JOINTS, **EXTERNAL)
    ),
    "GET /rw/motionsystem/mechunits/ROB_1/robtarget?tool=tGripper&wobj=wobj0": old_json(
        {"_type": "ms-robtargets", "_title": "ROB_1", **POSE}
    ),
    "GET /rw/elog/0?lang=en": rows(
        li("elog-message-li", "/rw/elog/0/8", **OLDER),
        li("elog-message-li", "/rw/elog/0/9", **EVENT),
    ),
    "GET /rw/rapid/modules?task=T_ROB1": rows(
        li("rap-module-info-li", "T_ROB1/BASE", name="BASE", type="SysMod"),
        li("rap-module-info-li", "T_ROB1/Seam", name="Seam", type="ProgMod"),
    ),
    "GET /rw/rapid/modules/m?resource=module-text&task=T_ROB1": old_json(
        row("rap-module-text", "m", change_count=42, module_text=TEXT_1)
    ),
    "GET /rw/rapid/symbol/data/RAPID/T_ROB1/user/reg1": rows(li("rap-data", "reg1", value="42.5")),
    "GET /rw/rapid/symbol/properties/RAPID/T_ROB1/user/reg1": rows(
        li("rap-sympropvar", REG1, symtyp="var", dattyp="num", ndim="0", ro="false")
    ),
    "POST /rw/rapid/symbol/data?action=validate": (204, ""),
    "POST /rw/rapid/symbol/data/RAPID/T_ROB1/user/reg1?action=set": (204, ""),
    "POST /rw/rapid/symbols?action=search-symbols": rows(
        li("rap-sympropvar-li", REG1, symburl=REG1, symtyp="var"),
        li("rap-sympropvar-li", "x", symburl="RAPID/T_ROB1/user/reg10", symtyp="var"),
    ),
    "POST /rw/rapid/tasks/T_ROB1?action=loadmod": (204, ""),
    "POST /rw/rapid/tasks/T_ROB1?action=unloadmod": (204, ""),
    "POST /rw/rapid/tasks/T_ROB1/program?action=loadprog": (204, ""),
    "POST /rw/rapid/execution?action=resetpp": (204, ""),
    "POST /rw/rapid/execution?action=start": (204, ""),
    "POST /rw/rapid/execution?action=stop": (204, ""),
    "POST /rw/panel/ctrlstate?action=setctrlstate": (204, ""),
    "POST /rw/panel/speedratio?action=setspeedratio": (204, ""),
    "POST /rw/iosystem/signals?action=signal-search": rows(
        li("ios-signal-li", "Local/DRV_1/doGripper", **SIGNAL),
        li("ios-signal-li", "Local/DRV_1/doGripper2", **{**SIGNAL, "name": "doGripper2"}),
    ),
    "GET /rw/iosystem/signals/Local/DRV_1/doGripper": rows(
        li("ios-signal", "Local/DRV_1/doGripper", **SIGNAL)
    ),
    "GET /rw/iosystem/signals": rows(
        li("ios-signal-li", "Local/DRV_1/doGripper", **SIGNAL),
        li("ios-signal-li", "aiForce", name="aiForce", type="AI", lvalue="3.25"),
    ),
    "POST /rw/iosystem/signals/Local/DRV_1/doGripper?action=set": (204, ""),
    "GET /rw/cfg/EIO/EIO_SIGNAL/instances": xhtml(
        '<ul><li class="cfg-dt-instance-li" title="doGripper"><span class="rdonly">false</span><ul>'
        '<li class="cfg-ia-t-li" title="Name"><span class="value">doGripper</span></li>'
        '<li class="cfg-ia-t-li" title="Access"><span class="value">Default</span></li>'
        "</ul></li></ul>"
    ),
    "POST /rw/cfg/EIO/EIO_SIGNAL/instances/doGripper?action=set": (204, ""),
}  # fmt: skip

TWO = {
    "GET /ctrl/identity": hal(
        {"_type": "ctrl-identity-info", "ctrl-name": "IRC5_7", "ctrl-id": "12-34567"}
    ),
    "GET /rw/system/robottype": hal(row("sys-robottype", "robottype", robot_type="IRB 1200")),
    "GET /rw/panel/ctrl-state": hal(row("pnl-ctrlstate", "ctrl-state", ctrlstate="motoron")),
    "GET /rw/panel/opmode": hal(row("pnl-opmode", "opmode", opmode="AUTO")),
    "GET /rw/panel/speedratio": hal(row("pnl-speedratio", "speedratio", speedratio="70")),
    "GET /rw/rapid/execution": hal(row("rap-execution", "execution", ctrlexecstate="stopped")),
    "GET /rw/rapid/tasks": TASKS_2,
    "GET /rw/rapid/tasks/T_ROB1/pcp": hal(
        row("pcp-info", "pcp", modulemame="Seam", routinename="main", beginposition="14,4")
    ),
    "GET /rw/motionsystem/mechunits/ROB_1": hal({"_type": "ms-mechunit", **UNIT}),
    "GET /rw/motionsystem/mechunits/ROB_1/jointtarget": hal(
        {"_type": "ms-jointtarget", "_title": "ROB_1", **JOINTS, **EXTERNAL}
    ),
    "GET /rw/motionsystem/mechunits/ROB_1/robtarget?tool=tGripper&wobj=wobj0": hal(
        {"_type": "ms-robtargets", "_title": "ROB_1", **POSE}
    ),
    "GET /rw/elog/0?lang=en&order=lifo": hal(
        row("elog-message-li", "/rw/elog/0/9", **EVENT),
        embedded=True,
        following="0?lang=en&amp;order=lifo&amp;start=1",
    ),
    "GET /rw/elog/0?lang=en&order=lifo&start=1": hal(
        row("elog-message-li", "/rw/elog/0/8", **OLDER), embedded=True
    ),
    "GET /rw/rapid/tasks/T_ROB1/modules": hal(
        row("rap-module-info-li", "T_ROB1/BASE", name="BASE", type="SysMod"),
        row("rap-module-info-li", "T_ROB1/Seam", name="Seam", type="ProgMod"),
    ),
    "GET /rw/rapid/tasks/T_ROB1/modules/m/text": hal(
        row("rap-module-text", "m", change_count=" 42 ", module_text=TEXT)
    ),
    "GET /rw/rapid/symbol/RAPID/T_ROB1/user/reg1/data": hal(row("rap-data", "reg1", value="42.5")),
    "GET /rw/rapid/symbol/RAPID/T_ROB1/user/reg1/properties": hal(
        row("rap-symproppers", "RAPID/T_ROB1/user/reg1", symtyp="per", dattyp="num", ndim="0"),
        embedded=True,
    ),
    "POST /rw/rapid/symbol/RAPID/T_ROB1/data?action=validate": (204, ""),
    "POST /rw/rapid/symbol/RAPID/T_ROB1/user/reg1/data": (204, ""),
    "POST /rw/rapid/symbols/search": rows(
        li("rap-symproppers-li", REG1, symburl=REG1, symtyp="per")
    ),
    "POST /rw/rapid/tasks/T_ROB1/loadmod": hal(row("rap-task-module-li", name="Seam")),
    "POST /rw/rapid/tasks/T_ROB1/unloadmod": (204, ""),
    "POST /rw/rapid/tasks/T_ROB1/program/load": (204, ""),
    "POST /rw/rapid/execution/resetpp": (204, ""),
    "POST /rw/rapid/execution/start": (204, ""),
    "POST /rw/rapid/execution/stop": (204, ""),
    "POST /rw/panel/ctrl-state": (204, ""),
    "POST /rw/panel/speedratio?action=setspeedratio": (204, ""),
    "POST /rw/iosystem/signals/signal-search": rows(
        li("ios-signal-li", "Local/DRV_1/doGripper", **SIGNAL)
    ),
    "GET /rw/iosystem/signals/Local/DRV_1/doGripper": hal(
        row("ios-signal-li", "Local/DRV_1/doGripper", **SIGNAL), embedded=True
    ),
    "GET /rw/iosystem/signals": hal(
        row("ios-signal-li", "Local/DRV_1/doGripper", **SIGNAL),
        embedded=True,
        following="signals?start=1&amp;limit=1",
    ),
    "GET /rw/iosystem/signals?start=1&limit=1": hal(
        row("ios-signal-li", "Net/Dev/aiForce", name="aiForce", type="AI", lvalue="3.25"),
        embedded=True,
    ),
    "POST /rw/iosystem/signals/Local/DRV_1/doGripper/set-value": (204, ""),
    "GET /rw/cfg/EIO/EIO_SIGNAL/instances": hal(
        {
            "_type": "cfg-dt-instance-li", "_title": "doGripper", "rdonly": "false",
            "attrib": [
                row("cfg-ia-t", "Name", value="doGripper"),
                row("cfg-ia-t", "Access", value="Default"),
            ],
        },
        embedded=True,
    ),
    "POST /rw/cfg/EIO/EIO_SIGNAL/instances/doGripper": (204, ""),
}  # fmt: skip
