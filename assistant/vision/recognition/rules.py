"""What is found when objects are learnt and looked for."""

from __future__ import annotations

from assistant.base.diagnostics import error, info, warning

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
