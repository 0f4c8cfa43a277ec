"""Findings of the vision room, in the order of their codes.

VS0: OpenCV, camera files, pictures, calibration. VS1: pointing devices. VS20 and VS21: servoing.
VS22: exploration by an arm. VS3: known objects. Programs that ask for poses have theirs in
`pose_server`.
"""

from __future__ import annotations

from typing import Final

from assistant.base.diagnostics import error, info, warning
from assistant.base.installation import missing_extra

NO_OPENCV = missing_extra(
    "VS001",
    "pictures are handled by the library OpenCV, which is not installed",
    "vision",
)


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


TARGET_NOT_SEEN = error(
    "VS201",
    "it is not seen for sure: {reason}; nothing was moved",
    "light it, free the view, or jog the arm to where all of it is in the picture",
)
TARGET_LOST = error(
    "VS202",
    "it was lost from sight ({reason}) at picture {number}, {left} from the goal; the arm was "
    "brought to rest",
    "free the view, and start from where the arm is",
)
STALE_PICTURES = error(
    "VS203",
    "pictures come {age:.2f} s late at picture {number}, {left} from the goal; the arm was brought "
    "to rest",
    "look at the camera and its line, or allow older pictures in the file of what is led where",
)
SINGULAR_INTERACTION = error(
    "VS204",
    "what is seen does not tell how to move: the interaction matrix is singular (condition "
    "{condition:.3g}) at picture {number}; the arm was brought to rest",
    "use points that are not in one line, more of them, or one more camera",
)
ERROR_GROWS = error(
    "VS205",
    "the error grows: it was {first:.3g} and is {now:.3g} at picture {number}; the arm was brought "
    "to rest",
    "look whether the camera stands where its file says, and lower the gain",
)
SERVO_TIMEOUT = error(
    "VS206",
    "the goal was not reached in {seconds:g} s: {left} were left; the arm was brought to rest",
    "look at the log, then allow more time or a larger tolerance",
)
BARRED_BY_LIMIT = error(
    "VS207",
    "the way to the goal is barred by {what}, {left} from the goal; the arm was brought to rest",
    "choose another goal or start, or widen the limit if it is safe",
)
ARM_OUTSIDE_BOUNDS = error(
    "VS208",
    "the arm stands outside of its limits: {what}; nothing was moved",
    "jog it into them, or correct the limits",
)
BAD_SETTING = error("VS209", "`{name}` cannot be {value}: {reason}", "give another one")
BAD_SERVO_FILE = error("VS210", "the servo file {what}", "{cure}")
NO_SERVO_SOURCE = error(
    "VS211", "no source of pictures is known of camera `{camera}`", "write `source` into its table"
)
MIXED_CAMERAS = error(
    "VS212",
    "camera `{camera}` is carried by `{parent}`, and {why}",
    "use one camera in the hand, or cameras that stand in the world",
)
PICTURES_ENDED = error(
    "VS213",
    "camera `{camera}` gives no more pictures after picture {number}",
    "look at the camera and its line",
)


STILL_TOUCHING: Final = error(
    "VS220",
    "the contact did not end on the way back, {back:.0f} mm long; the arm has been stopped",
    "free the arm by hand, and check the source of the contact",
)
START_OUTSIDE_BOUNDS: Final = error(
    "VS221",
    "the arm explores only inside its bounds, and {what}",
    "move the arm into its bounds, or state wider ones",
)
EMPTY_BOX: Final = error(
    "VS222",
    "none of {count:,} random postures has the flange in the box, so there is nowhere to move",
    "move the box to where the arm reaches, or make it larger",
)
NO_CONTACT_PICTURE: Final = error(
    "VS223",
    "no picture of camera `{camera}` came within {seconds:g} s, so contacts cannot be seen",
    "check the camera, and begin again",
)
BAD_REGION: Final = error(
    "VS224",
    "the region {region} is not in the picture of camera `{camera}`, which is {size}",
    "write LEFT,TOP,RIGHT,BOTTOM in pixels of that picture",
)
EXPLORATION_TIME_OVER: Final = warning(
    "VS225",
    "the time is over after {moves} moves",
    "explore again with the same chart, which goes on from there",
)


NO_OBJECT_LIBRARY = error(
    "VS301",
    "`{name}` is no object library: {reason}",
    "name the folder that `robot-assistant objects add` writes",
)
OTHER_LIBRARY_VERSION = error(
    "VS302",
    "the object library is of version {version}, and {known} is the one that is known here",
    "update robot-assistant, or learn the objects anew into another folder",
)
NO_OBJECT = error("VS303", "this is no known object: {reason}", "learn it anew with --again")
EMPTY_LIBRARY = error(
    "VS304", "the object library has no objects", "add one: `robot-assistant objects add`"
)
OBJECT_EXISTS = error(
    "VS305", "there is an object `{name}` already", "choose another name, or add --again"
)
BAD_OBJECT_NAME = error(
    "VS306", "`{name}` cannot name an object", "write letters, digits and `_`, a letter first"
)
NO_OUTLINE = error(
    "VS310",
    "there is no closed contour {where}",
    "close it, or name its layer by --contour; layers with closed contours: {names}",
)
AMBIGUOUS_LAYER = error(
    "VS311", "closed contours are on several layers: {names}", "name one of them by --contour"
)
BAD_OUTLINE = error("VS312", "the outline of the part {what}", "{cure}")
NO_LAYER = error("VS313", "there is no layer `{name}` with curves", "choose one of {names}")
SYMMETRIC_OUTLINE = info(
    "VS314",
    "`{name}` looks the same when it is turned {how}, so that a picture does not tell which way "
    "round it lies",
    "draw what makes it different, or put on it only what may be turned in that way",
)
NO_TEXTURE = error(
    "VS320",
    "the view shows {count} marks, too few of {least} to know it by",
    "take a sharp picture of the face that fills it; a part without marks is known by its drawing",
)
UNRELATED_VIEW = error(
    "VS321",
    "the view shows something else than the first one: {count} marks agree",
    "show the same face, from less aside",
)
REPEATED_VIEWS = warning(
    "VS322",
    "the views are all alike, so that more than one of them teaches nothing",
    "turn the part, or look at it from aside and in other light",
)
NO_FACE_SIZE = error(
    "VS323",
    "nothing says how large the face is",
    "give its width in mm by --width, or --cameras and the plane that it lies on",
)
DRAWING_AND_PICTURES = error(
    "VS324", "an object is learnt from a drawing or from pictures, not both", "{cure}"
)
UNKNOWN_FACE_HEIGHT = warning(
    "VS326",
    "two pictures do not tell how high the face of `{name}` is, so it is taken to lie in the plane",
    "give its height in mm by --height, or pictures of cameras that stand nearer together",
)
NOT_TWO_CAMERAS = error(
    "VS327",
    "a solid is learnt by pictures of two cameras, and this is of one",
    "name a picture of each of them, as CAMERA=FILE",
)
NOTHING_IN_PICTURE = error(
    "VS325",
    "the picture shows nothing that differs from its background",
    "lay the part alone on a plain background of another colour",
)
AMBIGUOUS_CAMERA = error(
    "VS334",
    "nothing says which camera took `{name}`",
    "write CAMERA={name}, or name the file like its camera; there are {names}",
)
TWO_PICTURES = error("VS335", "two pictures are of the camera `{name}`", "give one for each camera")
PLANE_NOT_SEEN = error(
    "VS336",
    "the camera `{camera}` does not see the plane on which objects lie",
    "give the height of the plane by --plane, or calibrate the camera where it stands",
)
UNKNOWN_MOUNTING = error(
    "VS337",
    "the camera `{camera}` hangs on `{parent}`, and nothing says where that is",
    "name the cell by --cell and the joints at which the picture was taken by --joints",
)
NOTHING_FOUND = error(
    "VS340",
    "no known object is in the pictures; {count} things are unknown",
    "look whether an object of the library is there, and at light and background",
)
OBJECT_NOT_SEEN = error(
    "VS341", "`{name}` is not in the pictures", "lay it there, or do not ask for it by --expect"
)
POSES_DISAGREE = error(
    "VS342",
    "the cameras disagree where `{name}` is: by {mm:.3g} mm, {sigmas:.0f} sigmas",
    "take the pictures at one time, or calibrate the cameras anew",
)
AMBIGUOUS_TILT = error(
    "VS343",
    "`{name}` may be tilted in two ways, which look alike",
    "look from nearer, more from aside, or with a second camera; or lay it on the plane",
)
UNKNOWN_OBJECT = info(
    "VS344",
    "something unknown lies at x {x:.1f}, y {y:.1f} mm of the plane, {size:.0f} mm across",
    "add it to the library if it is to be known",
)
NOT_ON_PLANE = warning(
    "VS345",
    "`{name}` does not lie on the plane: it is {mm:+.1f} mm above it and tilted by {degrees:.1f} "
    "degrees",
    "look whether the plane is right",
)
UNCERTAIN_POSE = error(
    "VS346",
    "`{name}` is only known to {sigma:.2g} {unit}, more than {most:g} {unit}",
    "look from nearer, with a second camera or less of it hidden, or allow more by --{option}",
)
AMBIGUOUS_TURN = error(
    "VS347",
    "`{name}` may be turned in two ways, as what tells them apart is hidden or small",
    "uncover it, look from nearer, or draw what makes it different",
)
CONTRADICTED_SIZE = error(
    "VS348",
    "`{name}` looks {percent:.1f} % {how} than it is if it lies on the plane: it is up to {mm:.2g} "
    "mm from where it seems, or another object",
    "state the height of what it lies on by --plane, or learn the object that is there",
)
NOTHING_TO_DO = warning(
    "VS350",
    "nothing is to be done on what was found",
    "add places or lines to the objects, or layers of their drawings by --line",
)
FOREIGN_FILE = error(
    "VS351",
    "`{name}` was not written by `see`, and is not replaced",
    "name another file, or move that one away",
)
