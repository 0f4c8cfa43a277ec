"""What is found in files of cameras and in what cameras give."""

from __future__ import annotations

from assistant.base.diagnostics import error, warning

NO_CAMERAS = error("VS010", "the file describes no camera", "write [cameras.NAME] for each of them")
INCOMPLETE_CAMERA = error(
    "VS011", "camera `{name}` has no {keys}", "write them, or calibrate the camera"
)
BAD_LENS = error("VS012", "the lens of camera `{name}` {what}", "calibrate the camera anew")
NO_CAMERA = error("VS013", "there is no camera `{name}`", "write one of {known}")
CAMERA_NOT_OPENED = error(
    "VS020", "camera `{name}` gives no picture from {source}: {reason}", "{cure}"
)
OTHER_PICTURE_SIZE = error(
    "VS021",
    "camera `{name}` gives {given} pixels, and was calibrated with {wanted}",
    "set it to that size, or calibrate it anew",
)
DARK_PICTURE = warning(
    "VS022", "the picture of camera `{name}` is dark: half of it is below {level:.0f} of 255",
    "switch on a light, take the cap off, or expose longer",
)  # fmt: skip
SATURATED_PICTURE = warning(
    "VS023", "{percent:.0f} % of the picture of camera `{name}` are as bright as can be",
    "expose shorter, or turn a light away",
)  # fmt: skip
CAMERA_LOST = error(
    "VS024",
    "camera `{name}` gives no more pictures, after {count} of them",
    "look whether it is still plugged in, and whether the network is there",
)
NOT_A_PICTURE = error("VS025", "this is no picture: {reason}", "name a PNG, JPEG, BMP or TIFF file")
CAMERAS_DISAGREE = error(
    "VS026",
    "cameras `{one}` and `{other}` leave {pixels:.1f} pixels on what both see",
    "one of them was moved, or it is not the same moment: calibrate them anew",
)
UNKNOWN_CARRIER = error(
    "VS027",
    "camera `{name}` is carried by `{parent}`, and nothing says where that is",
    "name its cell by --cell, or the poses of the flange by --poses",
)
PICTURES_OUT_OF_STEP = error(
    "VS028",
    "pictures of `{one}` and `{other}` are not of the same moments: {first} is beside {second}",
    "add the picture that is missing, or take away the other one of its moment",
)
UNEVEN_PICTURES = error(
    "VS029",
    "there are {count} pictures of `{one}` and {others} of `{other}`, "
    "and their names do not tell which belong together",
    "number them by their moments, or take away those that have no other",
)
