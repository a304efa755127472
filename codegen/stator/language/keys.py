"""The language, key by key: what a graph, a message, an interface and a board may say.

The checker, the JSON Schema for editors and the reference are all made from this file.
"""

from __future__ import annotations

from stator.language.nested import Key, Listing, OneOrMore, Short, Struct, Table
from stator.language.period import Period
from stator.language.shapes import NAME_PATTERN, Boolean, Choice, Integer, Name, Raw, Text

MAX_LEVELS = 15
MAX_TASKS_OF_THREAD = 30  # bits of a word, without the two of its own
DEPTHS = (1, 2, 4, 8, 16)
MAX_SLOTS = 32

MAX_TIMERS = 32  # of one node: a bit each in what woke it
MAX_MODES = 255
MAX_LOGGED_BYTES = 1000  # of a message; a block of the log holds no more
MAX_PARAM_NODES = 200  # whose parameters one node publishes; each is a port of its recording
MAX_PARAM_NAME = 92  # bytes of NODE.PARAMETER in messages, as DroneCAN has it

MESSAGE_NAME = Text(
    "[A-Z][A-Za-z0-9]{0,62}",
    "a message name",
    "bad-name",
    "message names are UpperCamel, such as SensorGyro",
)
_PATH_PART = "[A-Za-z0-9_][A-Za-z0-9_.-]{0,62}"
RELATIVE_PATH = Text(
    rf"(\.\./){{0,8}}({_PATH_PART}/){{0,8}}{_PATH_PART}\.yaml",
    "the path of a .yaml file, relative to this one",
    "include-path",
    "for example parts/estimation.yaml",
)
PREFIX = Text(
    "[a-z][a-z0-9]*(_[a-z0-9]+)*_?",
    "a prefix",
    "bad-name",
    "lower case letters, digits and single underscores, such as left_",
)
# It stands in comments and in the log's format, on one line.
UNIT = Text(
    r"[!-\[\]-~°µ ]{1,32}", "a unit", hint='one short line, for example m/s^2, or "1" for none'
)
_LATER = "graphs over several machines come in a later version"

INCLUDE = Struct(
    {
        "file": Key(
            RELATIVE_PATH,
            "The file to include, relative to this one, or one of Stator's own graphs.",
            required=True,
        ),
        "with": Key(Table(Raw(may_be_variable=True), "a variable"), "Values for its ${variables}."),
        "prefix": Key(PREFIX, "Put in front of its node names and the topics it publishes."),
    }
)

TRIGGER = Struct(
    {
        "irq": Key(Name("a line"), "A line of the node's device."),
        "min_interarrival": Key(
            Period(),
            "The least time between two events of the line; an assumption "
            "of the proof, checked at run time.",
        ),
        "topic": Key(Name("a topic"), "A topic among the node's inputs."),
        "min_interval": Key(Period(), "Activate at most this often, keeping the mean rate."),
        "every": Key(Period(), "A period."),
        "offset": Key(Period(least_us=0), "First release of the period."),
        "max_interval": Key(Period(), "The task is watched for life: it runs at least this often."),
    }
)

INPUT = Short(
    "topic",
    Struct(
        {
            "topic": Key(Name("a topic"), "The topic to read.", required=True),
            "max_age": Key(Period(), "A sample older than this reads as absent."),
            "read": Key(Choice(("latest", "queue")), "The newest sample, or all in order."),
        }
    ),
)

NODE = Struct(
    {
        "app": Key(Name("an app"), "The class of the node; its own name if left out."),
        "device": Key(Name("a device"), "The device that this driver node owns."),
        "trigger": Key(
            OneOrMore(TRIGGER), "What activates the node; any one of a list.", required=True
        ),
        "priority": Key(Integer(1, MAX_LEVELS), "1 (least urgent) to 15 (most)."),
        "deadline": Key(Period(), "Latest end of an activation after its release."),
        "budget": Key(Period(), "The most execution time of one activation."),
        "inputs": Key(Table(INPUT, "an input"), "Input ports and the topics they read."),
        "outputs": Key(
            Table(Name("a topic"), "an output"), "Output ports and the topics they publish."
        ),
        "params": Key(
            Table(Raw(), "a parameter"), "Values that differ from the interface's defaults."
        ),
    },
    reserved={"machine": _LATER},
)

TOPIC = Struct(
    {
        "log": Key(Text(what="all, none or a rate"), "all, none, or a rate such as 50 Hz."),
        "depth": Key(Integer(1, DEPTHS[-1]), "Samples kept for queue readers: 1, 2, 4, 8 or 16."),
        "publishers": Key(Choice(("one", "many")), "Whether several nodes may publish at a time."),
    },
    reserved={"machine": _LATER, "link": _LATER},
)

GRAPH = Struct(
    {
        "doc": Key(Text(), "What this graph is."),
        "board": Key(Name("a board"), "What the graph runs on.", required=True),
        "include": Key(Listing(INCLUDE), "Files whose content this one builds on."),
        "topics": Key(Table(TOPIC, "a topic"), "Topics that differ from the defaults."),
        "nodes": Key(Table(NODE, "a node"), "The nodes.", required=True),
        "modes": Key(
            Struct(
                {
                    "initial": Key(Name("a mode"), "The mode at the start.", required=True),
                    "sets": Key(
                        Table(Listing(Name("a node")), "a mode"),
                        "The nodes that run in each mode. Nodes in no set always run.",
                        required=True,
                    ),
                }
            ),
            "Sets of nodes that are exchanged in flight.",
        ),
        "chains": Key(
            Table(
                Struct(
                    {
                        "path": Key(
                            Listing(Name("a node"), least=2),
                            "The nodes, first to last.",
                            required=True,
                        ),
                        "deadline": Key(
                            Period(), "Latest end after the first node's release.", required=True
                        ),
                    }
                ),
                "a chain",
            ),
            "Paths of nodes with an end-to-end deadline.",
        ),
    },
    reserved={"machines": _LATER, "machine": _LATER, "link": _LATER},
)

FIELD = Struct(
    {
        "type": Key(
            Text(what="a type"),
            'bool, float, double, int8 to int64, uint8 to uint64; arrays as "float[3]".',
            required=True,
        ),
        "unit": Key(UNIT, "Unit of the value."),
        "frame": Key(Choice(("B", "N")), "Body or local north-east-down."),
        "values": Key(
            Table(Integer(0, 255), "a value", key_pattern=NAME_PATTERN),
            "Names of an enumeration's values.",
        ),
        "doc": Key(Text(), "What it is.", required=True),
    }
)
MESSAGE = Struct(
    {
        "doc": Key(Text(), "What one sample is.", required=True),
        "fields": Key(
            Table(FIELD, "a field"),
            "The fields; `timestamp` comes in front by itself.",
            required=True,
        ),
    }
)

_MESSAGE = Key(MESSAGE_NAME, "The message type.", required=True)
_PORT_DOC = Key(Text(), "What it is for.", required=True)
INPUT_PORT = Struct(
    {
        "message": _MESSAGE,
        "optional": Key(Boolean(), "An input that a graph need not wire."),
        "doc": _PORT_DOC,
    }
)
OUTPUT_PORT = Struct(
    {
        "message": _MESSAGE,
        "burst": Key(
            Integer(1, DEPTHS[-1]),
            "Most publications of one activation: the depth that readers need which do not outrank "
            "the node.",
        ),
        "doc": _PORT_DOC,
    }
)
PARAM = Struct(
    {
        "type": Key(Choice(("float", "int32", "bool")), "Type of the value.", required=True),
        "unit": Key(UNIT, 'Unit of the value; "1" for none.'),
        "range": Key(Listing(Raw(), least=2, most=2), "Least and most."),
        "default": Key(Raw(), "The value if the graph says nothing.", required=True),
        "fixed": Key(Boolean(), "It cannot be changed while the graph runs."),
        "doc": Key(Text(), "What it does.", required=True),
    }
)
INTERFACE = Struct(
    {
        "doc": Key(Text(), "The node's place in the vehicle.", required=True),
        "lines": Key(
            Table(Struct({"doc": Key(Text(), "When it comes.", required=True)}), "a line"),
            "Events of the device (device classes only).",
        ),
        "inputs": Key(Table(INPUT_PORT, "an input"), "Input ports."),
        "outputs": Key(Table(OUTPUT_PORT, "an output"), "Output ports."),
        "params": Key(Table(PARAM, "a parameter"), "Parameters."),
        "failsafe": Key(
            Text(rf"{NAME_PATTERN}\.yaml", "a YAML file beside this one"),
            "The file of a failsafe table, which becomes failsafe_table.hpp.",
        ),
        "reads_log": Key(Boolean(), "The node reads every logged topic through a generated table."),
        "publishes_params": Key(
            Boolean(), "The node changes and publishes the parameters of all nodes."
        ),
        "needs_timer": Key(Boolean(), "One of the node's triggers must be `every`."),
    }
)

PIN = "P[A-K](1[0-5]|[0-9])"
DEVICE = Struct(
    {
        "driver": Key(
            Text(
                "none|[a-z][a-z0-9_]{0,40}/[a-z][a-z0-9_]{0,40}",
                "a driver",
                hint="write CLASS/PART as in the folder drivers/, or none",
            ),
            "The driver's folder below drivers/, or none.",
            required=True,
        ),
        "class": Key(Name("a device class"), "The device class, where driver is none."),
        "bus": Key(Name("a bus"), "The bus it is on."),
        "pins": Key(
            Table(Text(PIN, "a pin", hint="write port and number, such as PC2"), "a pin"),
            "Its pins.",
        ),
        "lines": Key(
            Table(OneOrMore(Text("[A-Za-z0-9_]{1,40}", "a pin or a peripheral")), "a line"),
            "The pin or peripheral of each line; a list if several raise it.",
        ),
        "bytes_per_s": Key(
            Integer(1, 2**31 - 1), "Of a storage: what it takes in the long run, in a second."
        ),
    }
)
MEMORY = Struct(
    {
        "at": Key(
            Text("0x[0-9A-Fa-f]{1,8}", "an address", hint='write it as "0x20000000"'),
            "Where it begins.",
            required=True,
        ),
        "bytes": Key(Integer(1, 2**32 - 1), "How large it is.", required=True),
    }
)
UPLOAD = Struct(
    {
        "board_id": Key(
            Integer(1, 65535), "What its bootloader and ground stations know it as.", required=True
        ),
        "pyocd_target": Key(
            Text("[a-z0-9]{1,40}", "a target of pyOCD"), "What pyOCD calls its chip."
        ),
    }
)
BOARD = Struct(
    {
        "doc": Key(Text(), "What the board is."),
        "executor": Key(
            Choice(("cortex_m", "pthread", "virtual")), "Which runtime.", required=True
        ),
        "chip": Key(
            Text(rf"{_PATH_PART}(/{_PATH_PART}){{0,3}}", "a chip file such as stm32f4/stm32f427"),
            "The chip's file below boards/, without .yaml.",
        ),
        "reserved_vectors": Key(
            Listing(Text("[a-z0-9_]{1,40}", "a vector")),
            "Vectors the board itself needs; no task gets them.",
        ),
        "interrupts": Key(
            Listing(Text("[a-z0-9_]{1,40}", "a vector")),
            "Vectors whose handlers are the board's own code; no task gets them.",
        ),
        "memory": Key(
            Table(MEMORY, "a memory"),
            "Memories that differ from the chip's, such as a flash that begins with a bootloader.",
        ),
        "upload": Key(UPLOAD, "How firmware gets onto it, for `build` and `flash`."),
        "devices": Key(
            Table(DEVICE, "a device"), "The devices and what drives them.", required=True
        ),
    }
)
CHIP = Struct(
    {
        "doc": Key(Text(), "The chip, and the manual behind this file."),
        "core": Key(Text(), "The core.", required=True),
        "clock": Key(
            Text(
                "[1-9][0-9]{0,3} MHz",
                "a frequency in MHz",
                hint="write whole megahertz, such as 168 MHz",
            ),
            "Core clock.",
            required=True,
        ),
        "priority_bits": Key(Integer(2, 8), "Bits of an NVIC priority.", required=True),
        "memory": Key(Table(MEMORY, "a memory"), "Name: {at, bytes}; flash, ram and ccm."),
        "vectors": Key(
            Table(Integer(0, 239), "a vector", key_pattern=NAME_PATTERN),
            "Interrupt lines the chip really has.",
            required=True,
        ),
    }
)
# graph/budgets/BOARD.yaml: the most execution time of each node, as measured on that board.
BUDGETS = Table(Period(), "a node")
