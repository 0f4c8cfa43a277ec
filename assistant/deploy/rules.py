"""Findings of planning and deploying."""

from __future__ import annotations

from typing import Final

from assistant.base.diagnostics import Severity, error, info, warning

ERROR: Final = Severity.ERROR

NO_FILES = error("DP101", "there is nothing to deploy", "name at least one program file")
SAME_NAME = error(
    "DP102",
    "`{first}` and `{second}` would both become `{name}` on the controller",
    "rename one of them",
)
WRONG_LANGUAGE = error(
    "DP103",
    "the file is {given}, but {address} takes {taken}",
    "compile it for that controller, or deploy it to another",
)
UNKNOWN_LANGUAGE = error(
    "DP104",
    "the file is no program that {address} takes ({taken})",
    "compile it for that controller",
)
SAME_MODULE = error(
    "DP105",
    "`{first}` and `{second}` both hold the module `{name}`, of which one can be loaded",
    "rename one of the modules, or deploy one of the files",
)
CLASH = error(
    "DP106",
    "`{name}` is declared by the module `{own}` ({kind}) and by the module `{other}` ({there}), "
    "which share one memory; nothing was changed",
    "rename one of them, make it known to its own module only, or take the other module out of the "
    "memory",
)
EMPTY_FOLDER = error(
    "DP107",
    "the folder holds no program that the controller takes",
    "name a folder with programs in the controller's language, or files",
)
NOT_BESIDE = error(
    "DP108",
    "the list names `{name}`, which is not a file beside it",
    "put all modules of the program into the folder of the list, and name them without a folder",
)
NOT_THERE = error(
    "DP109", "the list names `{name}`, which is not there", "put it beside the list, or take it out"
)
NOT_SHOWN = error(
    "DP141",
    "`{name}` says `{word}`: the controller would not show its text, so that nobody could see "
    "whether it arrived, nor take it back; nothing was changed",
    "leave that word out, or deploy the file only and load it at the controller",
)
NO_MODULE = error(
    "DP142",
    "`{name}` does not hold one module: what is loaded from it could not be told nor taken back; "
    "nothing was changed",
    "put each module into a file of its own",
)
CHANGED_SINCE = error(
    "DP201",
    "`{name}` on the controller changed since the plan was made; nothing was changed by this run",
    "plan again and look at the difference",
)
ALTERED = error(
    "DP202",
    "`{name}` read back from the controller is not what was sent (first difference in line "
    "{row}: sent {sent}, read {read})",
    "check the line and the controller's version of the language",
)
NO_HISTORY = error(
    "DP203",
    "the deployments in `{folder}` cannot be kept or read: {reason}",
    "make room, choose another folder with `--history`, or mend the file",
)
UNDECIDED = error(
    "DP204",
    "`{name}` on the controller is not what a deployment left there; nothing was changed",
    "look at the difference, then bring the change home with `--pull`, or drop it with "
    "`--replace {name}`",
)
BLIND = error(
    "DP205",
    "over this connection it cannot be seen what was taught in `{name}` since it was loaded, nor "
    "whether it runs; nothing was changed",
    "deploy over Robot Web Services (`rws://`, `rwss://`), or say `--files-only` if only the files "
    "count",
)
RUNNING = error(
    "DP206",
    "`{name}` is not replaced while it may be in use: {reason}; nothing was changed",
    "stop the program, and deploy again",
)
IN_USE = error(
    "DP237",
    "`{name}` is not deleted: {reason}; nothing was changed",
    "stop the program, load another one in its place, and delete it then",
)
IS_FOLDER = error(
    "DP238",
    "`{name}` is a folder, and only files are deleted; nothing was changed",
    "name a file; a file inside is reached by an address with the folder, as "
    "`ftp://user@host/HOME:/parts`",
)
LOADED_UNSEEN = warning(
    "DP239",
    "over this connection it cannot be seen whether `{name}` is loaded or runs",
    "delete programs over Robot Web Services (`rws://`, `rwss://`), which refuses that",
)
ANOTHER = error(
    "DP207",
    "it is another controller than the plan was made for; nothing was changed",
    "look which one is at that address, and plan again",
)
STILL_OPEN = error(
    "DP208",
    "the deployment `{name}` was interrupted and is neither finished nor taken back",
    "finish it with `deploy --resume`, or take it back with `rollback`",
)
BUSY_HERE = error(
    "DP209", "another process of this computer deploys to that controller", "wait until it is done"
)
BUSY_THERE = error(
    "DP210",
    "the controller is held by the deployment `{name}` that {who} began at {time}",
    "wait until it is done; if it died, finish it with `deploy --resume` or take it back with "
    "`rollback`, there or here",
)
CHANGED_BETWEEN = error(
    "DP211",
    "`{name}` on the controller is neither what was there before the deployment nor what it "
    "brought; nothing was changed by this run",
    "look at it; `--replace {name}` puts the program of the deployment in its place",
)
NOTHING_OPEN = error("DP212", "no deployment to it was interrupted", "deploy, or see `deployments`")
NO_DEPLOYMENT = error(
    "DP213", "there is no deployment {number} to it in the history", "see `deployments`"
)
NO_RECORD = error(
    "DP214",
    "no deployment to it is known, neither there nor in the history here",
    "deploy first; of a controller without a disk only the computer that deployed knows it",
)
BAD_RECORD = warning(
    "DP221",
    "`{name}` cannot be trusted as the record of a deployment: {reason}",
    "programs that are there count as somebody else's until the next deployment",
)
NOT_OURS_ANY_MORE = error(
    "DP216",
    "the deployment `{name}` was ended on another computer: `{other}` has been deployed since; "
    "nothing was changed by this run",
    "plan again; the history here does not hold it for open any more",
)
DEPLOYED_SINCE = error(
    "DP217",
    "somebody else has deployed to the controller since the plan was made; nothing was changed by "
    "this run",
    "plan again",
)
CLAIM_GONE = error(
    "DP215",
    "somebody took the controller from this deployment before a program was changed",
    "look who deploys to it, and deploy again",
)
STILL_HELD = warning(
    "DP225",
    "the controller is still held by the deployment `{name}`, although that has ended: {reason}",
    "free it with `rollback` once it can be reached: that changes no program then",
)
FREED = warning(
    "DP226",
    "the controller was held by {who}, who changed nothing: it is free again, and no program was "
    "changed",
    "deploy again",
)
FREED_LATE = warning(
    "DP227",
    "the controller was still held by the deployment `{name}`, which had {how}: it is free again",
    "nothing else is left of it",
)
CONFLICT = warning(
    "DP222",
    "`{name}` is not replaced: {reason}",
    "bring the change home with `--pull`, or drop it with `--replace {name}`",
)
REPLACED = warning(
    "DP223",
    "`{name}` is replaced as was asked for: {reason}",
    "what was there is kept in the history",
)
OF_ANOTHER = warning(
    "DP231",
    "the record of the deployment `{name}` is of another controller ({then}) than this one ({now})",
    "programs that are there count as somebody else's until the next deployment",
)
UNTOLD = warning(
    "DP232",
    "{what} of the controller cannot be told over this connection; it should be `{wanted}`",
    "look which controller that is, or use another kind of connection to it",
)
NOT_MEANT = error(
    "DP233",
    "{what} of the controller is `{told}`, but the project means `{wanted}`; nothing was changed",
    "look which controller is at that address, or correct the project",
)
ELSEWHERE = warning(
    "DP234",
    "the module `{name}` is loaded in {others} as well, where it stays as it is: only `{here}` is "
    "changed",
    "deploy it there too, with `--task`",
)
SEVERAL_MEMORIES = error(
    "DP236",
    "the deployments that would be taken back are of the memories of several: {which}",
    "take them back one by one, the last one first",
)
POINTER_LOST = info(
    "DP235",
    "the program pointer of `{task}` is lost, because its modules were replaced; nothing was "
    "started",
    "move it to the begin of the program before the next start",
)
UNSEEN = warning(
    "DP229",
    "what was taught in `{name}` since it was loaded, and whether it runs, cannot be seen over "
    "this connection",
    "look over Robot Web Services (`rws://`, `rwss://`); over this one `deploy` replaces it only "
    "with `--files-only`",
)
BROUGHT_HOME = info(
    "DP224",
    "`{name}` was changed on the controller, and what is sent has that change: {reason}",
)
PUT_BACK = info("DP301", "`{name}` on the controller is again what it was before")
REMOVED = info("DP302", "`{name}`, which was new, is off the controller again")
NOT_PUT_BACK = error(
    "DP303",
    "`{name}` on the controller could not be seen to be what it was before; {backup}",
    "do not start the program; look at the file and put the right one there by hand",
)
INTERRUPTED = error(
    "DP304", "the deployment was interrupted while `{name}` was written", "run it again"
)
LINE_LOST = warning(
    "DP305",
    "the line to the controller is lost: {reason}; what was begun is taken back once the "
    "controller answers, for which {patience:g} s are allowed",
    "wait; Ctrl-C leaves the deployment open, and `deploy --resume` or `rollback` ends it later",
)
LEFT_OPEN = error(
    "DP306",
    "putting back was interrupted while the line was lost; the deployment `{name}` is open",
    "finish it with `deploy --resume`, or take it back with `rollback`, before any program starts",
)
NO_CANARY = error("DP401", "no controller of this deployment is called `{name}`", "write {known}")
NOT_BEGUN = warning(
    "DP402",
    "the deployment to `{name}` was not begun: it was interrupted before",
    "run it again; what is done already is left as it is",
)
NOT_BEGUN_AFTER = warning(
    "DP403",
    "the deployment to `{name}` was not begun: `{failed}` failed before",
    "mend that, and run it again; what is done already is left as it is",
)
IN_WRITTEN: Final = info(
    "DP330",
    "`{source}` has no place for what was changed in `{name}`: it is in `{file}`, and stays there "
    "when that is compiled again",
    "keep `{file}` with the sources, or have the source say it, before the folder is emptied",
)
