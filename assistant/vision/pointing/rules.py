"""What is found while somebody shows places; nothing of a doubtful sight is stored or gone to."""

from __future__ import annotations

from assistant.base.diagnostics import error, warning

TOO_DARK_PICTURE = error(
    "VS101",
    "the picture of camera `{camera}` is dark: half of it is below grey level {level:.0f}",
    "turn on the light, take off the cap, or lengthen the exposure",
)
TOO_BRIGHT_PICTURE = error(
    "VS102",
    "{percent:.0f} percent of the picture of camera `{camera}` is as bright as it can tell",
    "shorten the exposure, or take away the light that dazzles it",
)
UNCALIBRATED_SIZE = error(
    "VS103",
    "the picture of camera `{camera}` has {width} x {height} pixels, and it was calibrated for "
    "{wanted_width} x {wanted_height}",
    "set the camera as it was calibrated, or calibrate it as it is set",
)
MARK_NOT_SEEN = error(
    "VS104",
    "camera `{camera}` does not see the {mark}",
    "hold the device where both cameras see all of it",
)
MARK_AT_EDGE = error(
    "VS105",
    "the {mark} reaches the edge of the picture of camera `{camera}`",
    "show a place nearer to the middle of the pictures, or move the camera",
)
MARK_DISAGREES = error(
    "VS106",
    "the cameras do not see the {mark} at one place: {residual:.1f} pixels off, {most:.1f} allowed",
    "calibrate the cameras again if one was moved; take away what looks like the device",
)
MARK_WITHOUT_DEPTH = error(
    "VS107",
    "the rays to the {mark} tell no place before both cameras",
    "show it where the cameras look at it from different sides",
)
OTHER_MARK_DISTANCES = error(
    "VS108",
    "the marks are not as far apart as those of the {device}: {residual:.1f} pixels off, "
    "{most:.1f} allowed",
    "state the device's own measures, or calibrate the cameras again",
)
TWO_DEVICES = error(
    "VS109",
    "there are {count} of the {mark} in the pictures, {distance:.0f} mm apart",
    "take the other one away",
)
OTHER_BALL_RADIUS = error(
    "VS110",
    "the {mark} is seen as large as a ball of radius {seen:.1f} mm, and it has {stated:.1f} mm",
    "state the radius that it has, or take away what looks like it",
)
DEVICE_JUMPED = error(
    "VS111",
    "the device was {distance:.0f} mm away from where it was {seconds:.3f} s before",
    "move it slower, or allow more by --fastest",
)
DEVICE_MOVED = warning(
    "VS112",
    "the device moved by {distance:.1f} mm while it was held, {most:.1f} allowed; it is held anew",
    "hold it still, or rest it on the work",
)
DEVICE_TURNED = warning(
    "VS113",
    "the device turned by {angle:.1f} degrees while it was held, {most:.1f} allowed; it is held "
    "anew",
    "hold it still, or rest it on the work",
)
POSITION_NOT_SHOWN = error(
    "VS114",
    "the pictures ended before `{name}` was shown: {seen} of {count} moments were good{mostly}",
    "hold the device still for {frames} pictures at each place",
)
ONE_CAMERA = error(
    "VS115",
    "a place is told by two cameras, and there is {count}",
    "calibrate two cameras into one file, or name two",
)
CARRIED_CAMERA = error(
    "VS116",
    "camera `{camera}` stands on `{parent}`, and a place is told by cameras that stand still",
    "name cameras whose parent is `world`",
)
BAD_DEVICE = error("VS117", "the device {what}", "{cure}")
SHORT_STROKE = error(
    "VS118",
    "the stroke is {length:.1f} mm long, which is no way",
    "hold the device still, move it along the way, and hold it still again",
)
GAP_IN_STROKE = error(
    "VS119",
    "the device was not seen for {distance:.0f} mm of the stroke, {most:.0f} allowed",
    "show the stroke again where both cameras see all of it, or slower",
)
NO_PICTURE_SOURCE = error(
    "VS120",
    "the file does not say where the pictures of camera `{camera}` come from",
    'write source = "…" there: a folder, a file, an address, or the number of a device',
)
