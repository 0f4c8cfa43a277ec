"""What is found when cameras are calibrated."""

from __future__ import annotations

from assistant.base.diagnostics import error, warning

BAD_BOARD = error("VS030", "`{text}` is no board: {reason}", "{cure}")
NO_BOARD = warning(
    "VS031", "no board is found in {name}", "show all of it, flat, in even light, and sharp"
)
MIRRORED_BOARD = error(
    "VS032",
    "the board in {name} is mirrored",
    "show the printed side, and switch off that the camera mirrors its picture",
)
FEW_VIEWS = error(
    "VS033",
    "the board is found in {count} views, and {least} are needed",
    "take more pictures of it",
)
VIEWS_ALIKE = error(
    "VS034",
    "the views are too much alike: {what}",
    "tilt the board by 20 to 40 degrees to all sides, and bring it into the corners of the picture",
)
POOR_LENS = warning(
    "VS035",
    "the lens of `{name}` leaves {residual:.2f} pixels, and its focal length is known to "
    "{percent:.1f} %",
    "take sharper views, or more of them",
)
UNEVEN_VIEWS = error(
    "VS036", "there are {count} views of {name} and {other} of {others}", "pair them, one to one"
)
UNEQUAL_SIZES = error(
    "VS037", "{name} has {given} pixels, others have {wanted}", "use pictures of one camera"
)
NO_PICTURES = error(
    "VS038",
    "there are no pictures of camera `{name}` in {folder}",
    "name a folder of PNG, JPEG, BMP or TIFF files",
)
AMBIGUOUS_BOARD = error(
    "VS039",
    "a chessboard of {columns} × {rows} corners looks the same upside down: "
    "it does not tell where cameras stand",
    "take one with an even and an odd number, or a ChArUco board",
)
FEW_POSES = error(
    "VS040", "there are {count} poses of the arm, and {least} are needed", "show more of them"
)
ONE_ROTATION_AXIS = error(
    "VS041",
    "the poses of the arm turn about one axis only, or by less than {least:g} degrees",
    "turn the hand about two axes at least, by 30 degrees or more",
)
METHODS_DIFFER = error(
    "VS042",
    "the methods differ by {mm:.1f} mm and {degrees:.2f} degrees; {residual:.1f} mm are left",
    "look whether poses and pictures belong together, and whether the poses are of the flange",
)
LARGE_PAIR_RESIDUAL = error(
    "VS043",
    "{residual:.1f} pixels are left of what `{one}` and `{other}` see together, "
    "{most:.1f} in {first} beside {second}",
    "look whether their pictures are of the same moments, in the same order, and not mirrored",
)
SAME_CAMERA_POSITION = error(
    "VS044",
    "`{one}` and `{other}` stand at one place, from which nobody sees how far things are",
    "name the folder of each camera's own pictures",
)
UNCOVERED_PICTURE = warning(
    "VS045",
    "the board covers {percent:.0f} % of the picture of `{name}`, and the centre of the lens is "
    "known to {centre:.1f} px: measurements outside the covered part are extrapolated",
    "add views with the board near each corner of the picture",
)
UNCERTAIN_PAIR = warning(
    "VS046",
    "the distance between `{one}` and `{other}` is known to {mm:.2g} mm ({percent:.2g} %) and the "
    "turn between them to {degrees:.2g} degrees: depths are as uncertain",
    "take more pairs of pictures, with the board near the corners of both and at several distances",
)
WRONG_POSE = warning(
    "VS047",
    "pose {name} of the arm is {mm:.3g} mm and {degrees:.2g} degrees off what the other poses "
    "agree on, and is left out",
    "take the picture and the pose again, with the arm at rest",
)
MANY_WRONG_POSES = error(
    "VS048",
    "{count} of {total} poses of the arm contradict the others: {which}",
    "check that each row belongs to its picture and is a pose of the flange in mm and degrees",
)
LARGE_HAND_EYE_RESIDUAL = warning(
    "VS049",
    "{mm:.2f} mm are left in the poses, and the pictures explain {explained:.2f} mm",
    "check that the board is fixed and the arm at rest in each picture; calibrate the arm if it is",
)
