"""What is found in cell files and what they name."""

from __future__ import annotations

from assistant.base.diagnostics import error, info, warning

NO_LIBRARY = error(
    "CK400",
    "{what} handled by the library {name}, which is not installed",
    "install the extra: pip install 'robot-assistant[cell]'",
)
NO_PARENT = error(
    "CK401",
    "body `{name}` stands in `{parent}`, which the cell has not",
    "write one of {known}, or the name of another body",
)
CIRCULAR_PARENTS = error(
    "CK402", "body `{name}` stands in itself, by way of `{parent}`", "let one of them name `world`"
)
NO_BODY = error(
    "CK403", "there is no body `{name}`", "write the name of a body or link of the cell"
)
NO_ROBOT = error(
    "CK413", "there is no robot `{name}`", "choose one of {names}, or name a robot file beside it"
)
NO_SHAPE = error("CK404", "`{name}` has {what}", "{cure}")
SAME_BODY = error(
    "CK405", "bodies `{name}` and `{other}` differ only in upper and lower case", "rename one"
)
LONELY_TOOL = error(
    "CK406", "the tool `{name}` is no body of the cell", "give it a shape under [bodies]"
)
NO_MESH = error("CK407", "this is no mesh that is read: {reason}", "{cure}")
OPEN_MESH = warning(
    "CK408",
    "the mesh is open at {count} edges, so that nothing is inside it",
    "close it, or read it as `convex`",
)
INSIDE_OUT = warning(
    "CK409", "the triangles of the mesh face inwards; they are turned round", "export it again"
)
NO_AREA = warning(
    "CK410", "{count} of {total} triangles have no area and are left out", "repair the mesh"
)
SIMPLIFIED = warning(
    "CK411",
    "the mesh has {given:,} triangles; it is simplified to {kept:,}, at most {mm:.2g} mm thicker",
    "export it coarser",
)
NO_UNIT = info(
    "CK412",
    "the file says no unit; its numbers are taken as {unit}",
    'write unit = "mm" or another',
)
NO_SIZE = error("CK414", "this {what} is no body: {reason}", "give it finite sizes above 0 mm")
