"""Which request is answered by what: one row an operation, for both dialects.

Paths as of the reference, 4.3, and of the path tables of the public client
ichbinmeraj/abb-rws-client (src/paths), which were tried on RobotWare 6.16 and 7.21. What follows a
`?` is the `action` (or `resource`) that the query names. `{name}` is one part of a path,
`{name...}` any number of them.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Final, NamedTuple

from assistant.virtual.irc5.cabinet import Cabinet
from assistant.virtual.irc5.rws.answers import Answer, Rejected
from assistant.virtual.irc5.rws.paths import find_route, make_route
from assistant.virtual.irc5.rws.request import Request
from assistant.virtual.irc5.rws.resources import (
    files,
    log,
    mastership,
    motion,
    panel,
    parameters,
    rapid,
    signals,
    symbols,
    system,
)

Handler = Callable[[Cabinet, Request], Answer]


class Row(NamedTuple):
    """one, two: the path of each dialect, empty where it has none.

    needs: the domain whose mastership it takes, with `?` behind it if it is enough that nobody else
    holds that.
    """

    method: str
    one: str
    two: str
    handler: Handler
    needs: str = ""


E: Final = "/rw/rapid/execution"
D: Final = "/rw/rapid/symbol"
S: Final = "/rw/iosystem/signals"
H: Final = "/rw/mastership"
F: Final = "/fileservice"
P: Final = "/rw/panel"
C: Final = "/rw/cfg"
C2: Final = "/rw/cfg/{domain}/{type}/instances"
T: Final = "/rw/rapid/tasks/{task}"
U: Final = "/rw/motionsystem/mechunits/{unit}"
M2: Final = f"{T}/modules/{{module}}"

ROWS: Final = (
    Row("GET", f"{P}/ctrlstate", f"{P}/ctrl-state", panel.motor_state),
    Row("POST", f"{P}/ctrlstate?setctrlstate", f"{P}/ctrl-state", panel.set_motor_state, "motion?"),
    Row("GET", f"{P}/opmode", f"{P}/opmode", panel.operating_mode),
    Row("POST", f"{P}/opmode", f"{P}/opmode", panel.set_operating_mode),
    Row("GET", f"{P}/speedratio", f"{P}/speedratio", panel.speed_ratio),
    Row("POST", *((f"{P}/speedratio?setspeedratio",) * 2), panel.set_speed_ratio, "rapid"),
    Row("GET", f"{P}/coldetstate", f"{P}/coldetstate", panel.collision_detection),
    Row("POST", "", f"{P}/emergency-stop", panel.emergency_stop),
    Row("GET", E, E, rapid.execution_state),
    Row("POST", f"{E}?start", f"{E}/start", rapid.start_execution, "rapid?"),
    Row("POST", f"{E}?stop", f"{E}/stop", rapid.stop_execution),
    Row("POST", f"{E}?resetpp", f"{E}/resetpp", rapid.reset_pointer, "rapid"),
    Row("POST", f"{E}?setcycle", f"{E}/cycle", rapid.set_cycle, "rapid?"),
    Row("POST", f"{E}?startprodentry", f"{E}/startprodentry",
        rapid.start_production, "rapid"),
    Row("GET", "/rw/rapid/tasks", "/rw/rapid/tasks", rapid.list_tasks),
    Row("GET", T, T, rapid.task_facts),
    Row("POST", f"{T}?activate", "/rw/rapid/tasks/activate", rapid.activate_task, "rapid"),
    Row("POST", f"{T}?deactivate", "/rw/rapid/tasks/deactivate", rapid.deactivate_task, "rapid"),
    Row("GET", "/rw/rapid/modules", f"{T}/modules", rapid.list_modules),
    Row("GET", "/rw/rapid/modules/{module}", M2, rapid.module_facts),
    Row("GET", f"{T}/modules/{{module}}", "", rapid.module_facts),
    Row("GET", "/rw/rapid/modules/{module}?module-text", f"{M2}/text", rapid.module_text),
    Row("POST", "", f"{M2}/text", rapid.set_module_text, "rapid"),
    Row("POST", "/rw/rapid/modules/{module}?save", f"{M2}/save", rapid.save_module),
    Row("POST", f"{T}?loadmod", f"{T}/loadmod", rapid.load_module, "rapid"),
    Row("POST", f"{T}?unloadmod", f"{T}/unloadmod", rapid.unload_module, "rapid"),
    Row("GET", f"{T}/program", f"{T}/program", rapid.program_facts),
    Row("POST", f"{T}/program?loadprog", f"{T}/program/load", rapid.load_program, "rapid"),
    Row("GET", f"{T}/pcp", f"{T}/pcp", rapid.read_pointer),
    Row("POST", f"{T}/pcp?set-pp-routine", f"{T}/pcp/routine", rapid.set_pointer, "rapid"),
    Row("POST", "", f"{T}/pcp/reset", rapid.reset_pointer, "rapid"),
    Row("POST", f"{D}/data?validate", f"{D}/RAPID/{{task}}/data?validate", symbols.validate_value),
    Row("GET", f"{D}/data/RAPID/{{symbol...}}", f"{D}/RAPID/{{symbol...}}/data", symbols.read_symbol),
    Row("POST", f"{D}/data/RAPID/{{symbol...}}?set", f"{D}/RAPID/{{symbol...}}/data",
        symbols.write_symbol, "rapid"),
    Row("GET", f"{D}/properties/RAPID/{{symbol...}}", f"{D}/RAPID/{{symbol...}}/properties",
        symbols.symbol_properties),
    Row("POST", "/rw/rapid/symbols?search-symbols", "/rw/rapid/symbols/search", symbols.search_symbols),
    Row("POST", "/rw/rapid/symbols?search-symbol", "", symbols.search_symbols),
    Row("GET", S, S, signals.list_signals),
    Row("POST", f"{S}?signal-search", f"{S}/signal-search", signals.search_signals),
    Row("GET", *((f"{S}/{{signal...}}",) * 2), signals.read_signal),
    Row("POST", f"{S}/{{signal...}}?set", f"{S}/{{signal...}}/set-value", signals.write_signal),
    Row("GET", "/rw/iosystem/networks", "/rw/iosystem/networks", signals.list_networks),
    Row("GET", "/rw/iosystem/devices", "/rw/iosystem/devices", signals.list_devices),
    Row("GET", "/rw/motionsystem", "/rw/motionsystem", motion.motion_system),
    Row("GET", "/rw/motionsystem?change-count", "/rw/motionsystem?change-count", motion.motion_system),
    Row("GET", "/rw/motionsystem/mechunits", "/rw/motionsystem/mechunits", motion.mechanical_units),
    Row("GET", U, U, motion.mechanical_unit),
    Row("GET", f"{U}?static", "", motion.mechanical_unit),
    Row("GET", f"{U}?dynamic", "", motion.mechanical_unit),
    Row("GET", f"{U}/jointtarget", f"{U}/jointtarget", motion.joint_target),
    Row("GET", f"{U}/robtarget", f"{U}/robtarget", motion.robot_target),
    Row("GET", f"{U}/cartesian", f"{U}/cartesian", motion.cartesian_pose),
    Row("GET", H, H, mastership.list_mastership),
    Row("GET", f"{H}/{{domain}}", f"{H}/{{domain}}", mastership.mastership_holder),
    Row("POST", f"{H}?request", f"{H}/request", mastership.take_mastership),
    Row("POST", f"{H}?release", f"{H}/release", mastership.release_mastership),
    Row("POST", f"{H}/{{domain}}?request", f"{H}/{{domain}}/request", mastership.take_mastership),
    Row("POST", f"{H}/{{domain}}?release", f"{H}/{{domain}}/release", mastership.release_mastership),
    Row("GET", "/rw/elog", "/rw/elog", log.event_domains),
    Row("POST", "/rw/elog?clearall", "/rw/elog/clearall", log.clear_events),
    Row("GET", "/rw/elog/{domain}", "/rw/elog/{domain}", log.event_messages),
    Row("POST", "/rw/elog/{domain}?clear", "/rw/elog/{domain}/clear", log.clear_events),
    Row("GET", "/rw/elog/{domain}/{number}", "/rw/elog/{domain}/{number}", log.event_message),
    Row("GET", C, C, parameters.parameter_domains),
    Row("POST", f"{C}?load", f"{C}/load", parameters.load_parameters, "cfg"),
    Row("POST", f"{C}?validate", "", parameters.validate_parameters),
    Row("GET", f"{C}/{{domain}}", f"{C}/{{domain}}", parameters.parameter_types),
    Row("POST", f"{C}/{{domain}}?saveas", f"{C}/{{domain}}/saveas", parameters.save_parameters),
    Row("GET", C2, C2, parameters.parameter_instances),
    Row("GET", f"{C2}/{{instance}}", f"{C2}/{{instance}}", parameters.parameter_instance),
    Row("POST", f"{C2}/{{instance}}?set", f"{C2}/{{instance}}", parameters.change_parameter, "cfg"),
    Row("GET", "/rw/system", "/rw/system", system.system_info),
    Row("GET", "/rw/system/options", "/rw/system/options", system.system_options),
    Row("GET", "/rw/system/robottype", "/rw/system/robottype", system.robot_type),
    Row("GET", "/ctrl", "/ctrl", system.controller_identity),
    Row("GET", "/ctrl/identity", "/ctrl/identity", system.controller_identity),
    Row("GET", "/ctrl/clock", "/ctrl/clock", system.read_clock),
    Row("PUT", "/ctrl/clock", "/ctrl/clock", system.set_clock),
    Row("GET", "/ctrl/backup", "/ctrl/backup", system.backup_state),
    Row("GET", "/ctrl/backup?backupstate", "/ctrl/backup/state", system.backup_ready),
    Row("GET", "/progress/{number}", "/progress/{number}", system.read_progress),
    Row("POST", "/ctrl/backup?backup", "/ctrl/backup/create", system.create_backup),
    Row("POST", "/ctrl/backup?restore", "/ctrl/backup/restore", system.restore_backup, "rapid"),
    Row("POST", "", "/ctrl/backup/check-restore", system.check_backup),
    Row("GET", "/ctrl/${volume}", "", system.volume_path),
    Row("GET", F, F, files.list_volumes),
    Row("GET", *((f"{F}/{{path...}}",) * 2), files.read_path),
    Row("PUT", *((f"{F}/{{path...}}",) * 2), files.store_file),
    Row("DELETE", *((f"{F}/{{path...}}",) * 2), files.delete_path),
    Row("POST", f"{F}/{{path...}}", "", files.act_on_path),
    Row("POST", "", f"{F}/{{path...}}/create", files.create_folder),
    Row("POST", "", f"{F}/{{path...}}/copy", files.copy_path),
    Row("POST", "", f"{F}/{{path...}}/rename", files.rename_path),
    Row("GET", "/users/rmmp", "/users/rmmp", mastership.privilege_status),
    Row("POST", "/users/rmmp", "/users/rmmp", mastership.request_privilege),
    Row("GET", "/users/rmmp/poll", "/users/rmmp/poll", mastership.poll_privilege_request),
    Row("POST", "/users/rmmp?cancel", "/users/rmmp/cancel", mastership.cancel_privilege),
    Row("POST", "/users", "/users/register", mastership.register_user),
    Row("GET", "", "/users/login-info", mastership.login_info),
)  # fmt: skip


ROUTES: Final = {
    dialect: tuple(
        make_route(row.method, path, row.handler, row.needs)
        for row in ROWS
        if (path := row.one if dialect == 1 else row.two)
    )
    for dialect in (1, 2)
}


def serve_resource(cabinet: Cabinet, request: Request) -> Answer:
    """Finds the handler of a request and has it answer; raises Rejected."""
    found = find_route(ROUTES[request.dialect], request)
    if isinstance(found, Rejected):
        raise found
    row, captures = found
    if row.needs:
        mastership.check_mastership(cabinet, request, row.needs)
    return row.handler(cabinet, replace(request, captures=captures))
