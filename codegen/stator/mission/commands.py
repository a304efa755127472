"""Commands and frames of MAVLink (common.xml): which the vehicle knows, and their names."""

from __future__ import annotations

from stator.build.cpp_source import enumerators, numbers

_ITEM = "apps/navigator/item.hpp"
_KINDS = enumerators(_ITEM, "ItemKind")
_FRAMES = enumerators(_ITEM, "Frame")
_FENCE = enumerators("apps/navigator/geofence.hpp", "FenceKind")

WAYPOINT, LOITER_UNLIMITED = _KINDS["Waypoint"], _KINDS["LoiterUnlimited"]
LOITER_TURNS, LOITER_TIME = _KINDS["LoiterTurns"], _KINDS["LoiterTime"]
LOITER_TO_ALTITUDE, EIGHT = _KINDS["LoiterToAltitude"], _KINDS["Eight"]
RETURN, LAND, TAKEOFF = _KINDS["Return"], _KINDS["Land"], _KINDS["Takeoff"]
VTOL_TAKEOFF, VTOL_LAND = _KINDS["VtolTakeoff"], _KINDS["VtolLand"]
SPLINE, DELAY = _KINDS["SplineWaypoint"], _KINDS["Delay"]
CHANGE_ALTITUDE = _KINDS["ContinueAndChangeAltitude"]
CONDITION_ALTITUDE = _KINDS["ConditionChangeAltitude"]
CONDITION_DELAY, CONDITION_YAW = _KINDS["ConditionDelay"], _KINDS["ConditionYaw"]
CONDITION_DISTANCE = _KINDS["ConditionDistance"]
JUMP, CHANGE_SPEED = _KINDS["Jump"], _KINDS["ChangeSpeed"]
REGION_NAV, REGION = _KINDS["RegionOfInterestNav"], _KINDS["RegionOfInterest"]
REGION_PLACE = _KINDS["RegionOfInterestLocation"]

# The vehicle goes there: these have a place.
PLACES = frozenset(
    (WAYPOINT, SPLINE, LOITER_UNLIMITED, LOITER_TURNS, LOITER_TIME, LOITER_TO_ALTITUDE, EIGHT)
) | {LAND, VTOL_LAND}
TAKEOFFS = frozenset((TAKEOFF, VTOL_TAKEOFF))
LANDINGS = frozenset((LAND, VTOL_LAND))
ALTITUDES = frozenset((CHANGE_ALTITUDE, CONDITION_ALTITUDE))
FLOWN = PLACES | TAKEOFFS | ALTITUDES | {RETURN, DELAY}
CONDITIONS = frozenset((CONDITION_DELAY, CONDITION_DISTANCE, CONDITION_YAW))
KNOWN = frozenset(_KINDS.values())
PASSED_BY = numbers(_ITEM, "kPassedBy")
ENDS = LANDINGS | {RETURN, LOITER_UNLIMITED}

GLOBAL, LOCAL, NO_PLACE = _FRAMES["Global"], _FRAMES["Local"], _FRAMES["Mission"]
RELATIVE = _FRAMES["Relative"]
ABOVE_SEA = frozenset((GLOBAL, _FRAMES["GlobalInt"]))
ABOVE_HOME = frozenset((RELATIVE, _FRAMES["RelativeInt"]))
ABOVE_TERRAIN = frozenset((10, 11))

POLYGON_IN, POLYGON_OUT = _FENCE["PolygonInclusion"], _FENCE["PolygonExclusion"]
CIRCLE_IN, CIRCLE_OUT = _FENCE["CircleInclusion"], _FENCE["CircleExclusion"]
RALLY_POINT = 5100

SPEED_TYPES = {0: "airspeed", 1: "ground speed", 2: "climb speed", 3: "descent speed"}

NAMES = {
    WAYPOINT: "waypoint", LOITER_UNLIMITED: "loiter", LOITER_TURNS: "loiter turns",
    LOITER_TIME: "loiter for a time", RETURN: "return", LAND: "land", TAKEOFF: "takeoff",
    CHANGE_ALTITUDE: "change of altitude", LOITER_TO_ALTITUDE: "loiter to altitude",
    EIGHT: "figure of eight", SPLINE: "spline waypoint", VTOL_TAKEOFF: "VTOL take-off",
    VTOL_LAND: "VTOL land", DELAY: "delay", CONDITION_DELAY: "condition delay",
    CONDITION_ALTITUDE: "condition altitude", CONDITION_DISTANCE: "condition distance",
    CONDITION_YAW: "condition yaw", JUMP: "jump", CHANGE_SPEED: "change of speed",
    REGION_NAV: "region of interest", REGION: "region of interest",
    REGION_PLACE: "region of interest", 197: "no region of interest",
    # What it passes by.
    181: "set relay", 182: "repeat relay", 183: "set servo", 184: "repeat servo",
    189: "landing start", 196: "region of interest by offset", 202: "camera configuration",
    203: "camera trigger", 204: "mount configuration", 205: "mount control",
    206: "camera trigger distance", 211: "gripper", 214: "camera trigger interval",
    220: "mount control by quaternion", 530: "camera mode", 531: "camera zoom",
    532: "camera focus", 534: "camera source", 600: "jump tag", 1000: "gimbal pitch and yaw",
    1001: "gimbal configuration", 2000: "take photos", 2001: "stop photos", 2003: "camera trigger",
    2004: "camera tracking", 2010: "camera tracking stop", 2500: "start video", 2501: "stop video",
    2502: "start stream", 2503: "stop stream", 2800: "panorama",
    3000: "VTOL transition", 42600: "winch",
    # What it refuses.
    23: "local landing", 24: "local take-off", 32: "follow", 33: "follow", 34: "orbit",
    36: "arc waypoint", 81: "path planning", 83: "altitude wait", 92: "guided mode",
    94: "payload place", 159: "condition last", 176: "set mode", 179: "set home",
    180: "set parameter", 185: "termination", 186: "change altitude", 188: "return path",
    190: "rally land", 191: "go around", 192: "reposition", 193: "pause", 194: "reverse",
    207: "fence enable", 208: "parachute", 209: "motor test", 210: "inverted flight",
    212: "autotune", 215: "resume after", 218: "auxiliary function", 222: "guided limits",
    223: "engine control", 252: "pause or continue", 300: "mission start", 400: "arm",
    601: "jump to tag", 2600: "control at high latency", 4501: "condition gate",
    5000: "fence return point", 5001: "fence", 5002: "fence", 5003: "fence", 5004: "fence",
    5005: "fence", 5100: "rally point", 42700: "script", 42702: "script",
}  # fmt: skip
# Why a device is missing, for what the vehicle passes by without doing it.
_DEVICES = (
    ("gimbal", (204, 205, 220, 1000, 1001)),
    ("camera", (196, 202, 203, 206, 214, 530, 531, 532, 534, 2000, 2001, 2003, 2004, 2005, 2010)),
    ("camera", (2500, 2501, 2502, 2503, 2800)),
    ("servo, relay, gripper or winch", (181, 182, 183, 184, 211, 42600)),
    ("wing", (3000,)),
)


def name_of(command: int) -> str:
    return NAMES.get(command, "unknown command")


def missing_device(command: int) -> str:
    """What the vehicle lacks to do it; empty for marks, which need nothing."""
    return next((device for device, commands in _DEVICES if command in commands), "")
