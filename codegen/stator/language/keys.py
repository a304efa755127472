"""The language: every key of a graph, a message, an interface, a board and a chip.

The checker, the JSON Schema for editors and the reference all come from this file.
"""

from __future__ import annotations

from stator.language.nested import Key, Listing, OneOrMore, Short, Struct, Table
from stator.language.period import Period
from stator.language.shapes import (
    NAME_PATTERN,
    Boolean,
    Choice,
    Integer,
    Name,
    Raw,
    RawOrNames,
    Text,
    UnitText,
)

MAX_LEVELS = 15
MAX_TASKS_OF_THREAD = 30  # the bits of a word, except two that the thread itself uses
DEPTHS = (1, 2, 4, 8, 16)
MAX_SLOTS = 32

# What a time rests on, the weakest first: a guess, instructions counted in the emulator times a
# stated time for each, or the cycle counter of the board itself.
PROVENANCES = ("guessed", "emulated", "hardware")

MAX_TIMERS = 32  # of one node: each has a bit in the word that says what woke the node
MAX_MODES = 255
MAX_LOGGED_BYTES = 1000  # of a message: the size of a block of the log
MAX_PARAMS = 512  # that one node publishes: Marks in apps/parameters/keeper.hpp
MAX_PARAM_NODES = 200  # nodes whose parameters one node publishes; each is a recorded port
MAX_PARAM_ID = 16  # MAVLink's limit
MAX_PARAM_NAME = 92  # bytes of NODE.PARAMETER in messages; DroneCAN's limit

MESSAGE_NAME = Text(
    "[A-Z][A-Za-z0-9]{0,62}",
    "a message name",
    "bad-name",
    "write it in UpperCamel, for example SensorGyro",
)
PARAM_ID = Text(
    r"[A-Z](?:[A-Z0-9_]|\{n\}){0,15}",
    "a parameter id",
    hint="use at most 16 upper case letters, digits and underscores; begin with a letter; {n} is "
    "the number of the node",
)
FORMER_NAME = Text(
    rf"({NAME_PATTERN}\.)?{NAME_PATTERN}",
    "a former name",
    hint="write PARAMETER, or NODE.PARAMETER",
)
_PATH_PART = "[A-Za-z0-9_][A-Za-z0-9_.-]{0,62}"
RELATIVE_PATH = Text(
    rf"(\.\./){{0,8}}({_PATH_PART}/){{0,8}}{_PATH_PART}\.yaml",
    "a relative path of a .yaml file",
    "include-path",
    "write a path relative to this file, for example parts/estimation.yaml",
)
PREFIX = Text(
    "[a-z][a-z0-9]*(_[a-z0-9]+)*_?",
    "a prefix",
    "bad-name",
    "use lower case letters, digits and single underscores, for example left_",
)
# Comments and the log's format hold it, on one line.
UNIT = UnitText(
    r"[!-\[\]-~°µ ]{1,32}",
    "a unit",
    hint='write one short line, for example m/s^2, or "1" for no unit',
)

INCLUDE = Struct(
    {
        "file": Key(
            RELATIVE_PATH,
            "The file to include: a path relative to this file, or one of Stator's own graphs.",
            required=True,
        ),
        "with": Key(
            Table(Raw(may_be_variable=True), "a variable"),
            "Values for the ${variables} of the included file.",
        ),
        "prefix": Key(
            PREFIX, "Text in front of its node names and of the topics that it publishes."
        ),
    }
)

TRIGGER = Struct(
    {
        "irq": Key(Name("a line"), "A line of the node's device."),
        "min_interarrival": Key(
            Period(),
            "The shortest time between two events of the line. The proof assumes it; the executor "
            "checks it at run time.",
        ),
        "topic": Key(Name("a topic"), "A topic that one of the node's inputs reads."),
        "min_interval": Key(Period(), "The shortest mean time between activations by this topic."),
        "every": Key(Period(), "The period of a timer."),
        "offset": Key(Period(least_us=0), "The time of the first release."),
        "max_interval": Key(
            Period(), "The longest time between two activations; the executor watches it."
        ),
    }
)

INPUT = Short(
    "topic",
    Struct(
        {
            "topic": Key(Name("a topic"), "The topic to read.", required=True),
            "max_age": Key(Period(), "The node sees a sample older than this as absent."),
            "read": Key(
                Choice(("latest", "queue")),
                "latest: the newest sample; queue: every sample, in order.",
            ),
        }
    ),
)

STANDBY = Short(
    "machine",
    Struct(
        {
            "machine": Key(Name("a machine"), "The machine that runs the copy.", required=True),
            "max_age": Key(
                Period(),
                "The selector gives up the node when an output is older than this; if left out, "
                "the smallest `max_age` of the output's readers.",
            ),
        }
    ),
)

# The wire between two machines.
LINK = Struct(
    {
        "to": Key(Name("a machine"), "The machine at the other end.", required=True),
        "here": Key(
            Name("a device"), "The serial line of this machine that the link uses.", required=True
        ),
        "there": Key(
            Name("a device"), "The serial line at the other end that the link uses.", required=True
        ),
        "baud": Key(Integer(9600, 12_000_000), "Bits per second; a byte takes ten.", required=True),
        "wake_up": Key(
            Period(),
            "The longest time from the end of a frame until this machine serves it. Required where "
            "levels are threads, as nothing bounds this time there.",
        ),
    }
)
MACHINE = Struct(
    {
        "board": Key(Name("a board"), "The board of the machine.", required=True),
        "link": Key(LINK, "The link to a machine that stands before this one."),
    }
)

NODE = Struct(
    {
        "app": Key(
            Name("an app"),
            "The class of the node. Default: the node's name. For a node of an included file, "
            "another app gets that node's connections; null removes those that it does not have.",
        ),
        "device": Key(
            Name("a device"), "The device that this node owns; the board says which driver it has."
        ),
        "trigger": Key(
            OneOrMore(TRIGGER),
            "What activates the node. Each trigger of a list activates it.",
            required=True,
        ),
        "priority": Key(Integer(1, MAX_LEVELS), "1 (least urgent) to 15 (most urgent)."),
        "deadline": Key(Period(), "The latest end of an activation, counted from its release."),
        "budget": Key(Period(), "The longest execution time of one activation."),
        "inputs": Key(
            Table(INPUT, "an input"), "The input ports, and the topic that each one reads."
        ),
        "outputs": Key(
            Table(Name("a topic"), "an output"),
            "The output ports, and the topic that each one publishes.",
        ),
        "params": Key(
            Table(RawOrNames(), "a parameter"),
            "Parameter values that differ from the defaults of the interface.",
        ),
        "machine": Key(
            Name("a machine"), "The machine that runs the node; the first one if left out."
        ),
        "standby": Key(
            STANDBY,
            "A second machine that runs a copy of the node. A generated selector takes the copy's "
            "outputs when those of the node are old, and stays with them until the vehicle is "
            "disarmed.",
        ),
    },
)

TOPIC = Struct(
    {
        "log": Key(Text(what="all, none or a rate"), "all, none, or a rate, for example 50 Hz."),
        "depth": Key(
            Integer(1, DEPTHS[-1]),
            "Number of samples that queue readers can fall behind: 1, 2, 4, 8 or 16.",
        ),
        "publishers": Key(
            Choice(("one", "many")), "many: several nodes may publish the topic at the same time."
        ),
        "link": Key(
            Struct(
                {
                    "every": Key(
                        Period(),
                        "The shortest mean time between two samples on a link. Readers on the "
                        "publisher's machine get all samples.",
                    ),
                    "priority": Key(
                        Integer(1, MAX_LEVELS),
                        "1 (least urgent) to 15 (most urgent) on the link; if left out, that of "
                        "the most urgent reader at its other end.",
                    ),
                }
            ),
            "How the topic travels to other machines.",
        ),
    },
)

GRAPH = Struct(
    {
        "doc": Key(Text(), "What this graph is for."),
        "board": Key(Name("a board"), "The board that the graph runs on.", required=True),
        "vehicle": Key(
            Name("a vehicle"),
            "The vehicle that flies: a file of vehicles/ beside the graph, or one of Stator's own; "
            "iris if left out.",
        ),
        "include": Key(
            Listing(INCLUDE),
            "Files to build on. The keys of this file replace the same keys of the included files; "
            "null removes one: a node, an input, a parameter.",
        ),
        "topics": Key(Table(TOPIC, "a topic"), "Settings of topics that differ from the defaults."),
        "machines": Key(
            Table(MACHINE, "a machine"),
            "The machines that the nodes run on, if there are several. The clock of the first one "
            "is the clock of the graph.",
        ),
        "nodes": Key(Table(NODE, "a node"), "The nodes of the graph.", required=True),
        "modes": Key(
            Struct(
                {
                    "initial": Key(Name("a mode"), "The mode after the start.", required=True),
                    "sets": Key(
                        Table(Listing(Name("a node")), "a mode"),
                        "The nodes that run in each mode. A node that is in no set always runs.",
                        required=True,
                    ),
                }
            ),
            "Sets of nodes that the vehicle exchanges in flight.",
        ),
        "chains": Key(
            Table(
                Struct(
                    {
                        "path": Key(
                            Listing(Name("a node"), least=2),
                            "The nodes, from first to last.",
                            required=True,
                        ),
                        "deadline": Key(
                            Period(),
                            "The latest end of the last node, counted from the first release.",
                            required=True,
                        ),
                    }
                ),
                "a chain",
            ),
            "Paths through nodes that have an end-to-end deadline.",
        ),
    },
)

FIELD = Struct(
    {
        "type": Key(
            Text(what="a type"),
            'bool, float, double, int8 to int64, uint8 to uint64, or an array such as "float[3]".',
            required=True,
        ),
        "unit": Key(UNIT, "The unit of the value."),
        "frame": Key(Choice(("B", "N")), "The frame: B for body, N for local north-east-down."),
        "values": Key(
            Table(Integer(0, 255), "a value", key_pattern=NAME_PATTERN),
            "The names and values of an enumeration.",
        ),
        "doc": Key(Text(), "What the field is.", required=True),
    }
)
MESSAGE = Struct(
    {
        "doc": Key(Text(), "What one sample holds.", required=True),
        "fields": Key(
            Table(FIELD, "a field"),
            "The fields. The compiler adds `timestamp` in front.",
            required=True,
        ),
    }
)

_MESSAGE = Key(MESSAGE_NAME, "The message type.", required=True)
_PORT_DOC = Key(Text(), "What the port is for.", required=True)
INPUT_PORT = Struct(
    {
        "message": _MESSAGE,
        "optional": Key(Boolean(), "true: a graph may leave this input unconnected."),
        "doc": _PORT_DOC,
    }
)
OUTPUT_PORT = Struct(
    {
        "message": _MESSAGE,
        "burst": Key(
            Integer(1, DEPTHS[-1]),
            "The highest number of publications in one activation; 1 if left out. Any more are "
            "refused and counted. Readers of the same or a lower priority need this depth.",
        ),
        "min_interval": Key(
            Period(),
            "Of an output that is published seldom: the shortest usual mean time between two "
            "publications. The rate of a recording that `fly` shows is computed with it; nothing "
            "in flight depends on it.",
        ),
        "doc": _PORT_DOC,
    }
)
_MAX_FLAGS = 31  # of an int32 that is not negative
PARAM = Struct(
    {
        "type": Key(Choice(("float", "int32", "bool")), "The type of the value.", required=True),
        "unit": Key(UNIT, 'The unit of the value; "1" for no unit.'),
        "range": Key(Listing(Raw(), least=2, most=2), "[lowest, highest] value."),
        "values": Key(
            Table(Integer(-(2**31), 2**31 - 1), "a value", key_pattern=NAME_PATTERN),
            "Names of values of an int32. A graph writes the name or the number.",
        ),
        "flags": Key(
            Listing(Name("a flag"), least=1, most=_MAX_FLAGS),
            "Names of the bits of an int32, the lowest first. A graph writes a list of names, or "
            "the number.",
        ),
        "default": Key(
            RawOrNames(), "The value if the graph gives none; required without `vehicle`."
        ),
        "vehicle": Key(
            Name("a value of a vehicle"),
            "What of the graph's vehicle is the value if the graph gives none, such as "
            "hover_thrust or rotor0_x; in place of `default`.",
        ),
        "fixed": Key(Boolean(), "true: the value cannot change while the graph runs."),
        "in_flight": Key(Boolean(), "false: the value cannot change while the vehicle is armed."),
        "id": Key(
            PARAM_ID,
            "The name for ground stations. Use a name of PX4 only if unit and meaning are the "
            "same. If left out, it follows from NODE.PARAMETER. {n} is the number at the end of "
            "the node's name.",
        ),
        "was": Key(
            OneOrMore(FORMER_NAME),
            "Former names: PARAMETER of the same node, or NODE.PARAMETER. A value that was kept "
            "under one of them counts.",
        ),
        "doc": Key(Text(), "What the parameter does.", required=True),
    }
)
INTERFACE = Struct(
    {
        "doc": Key(Text(), "What the node does in the vehicle.", required=True),
        "lines": Key(
            Table(Struct({"doc": Key(Text(), "When the event occurs.", required=True)}), "a line"),
            "Events of the device. Only device classes have lines.",
        ),
        "inputs": Key(Table(INPUT_PORT, "an input"), "The input ports."),
        "outputs": Key(Table(OUTPUT_PORT, "an output"), "The output ports."),
        "params": Key(Table(PARAM, "a parameter"), "The parameters."),
        "failsafe": Key(
            Text(rf"{NAME_PATTERN}\.yaml", "a YAML file beside this one"),
            "The file of a failsafe table; failsafe_table.hpp is generated from it.",
        ),
        "reads_log": Key(
            Boolean(), "true: the node reads every logged topic through a generated table."
        ),
        "reads_graph": Key(
            Boolean(),
            "true: the node reads what tasks have counted and the newest samples of all topics "
            "through a generated table. It must be at the lowest level. A replay repeats its "
            "outputs and does not run it.",
        ),
        "publishes_params": Key(
            Boolean(), "true: the node changes and publishes the parameters of all nodes."
        ),
        "reads_metadata": Key(
            Boolean(),
            "true: the node has the files that describe all parameters of the graph, as ground "
            "stations read them.",
        ),
        "needs_timer": Key(Boolean(), "true: one of the node's triggers must be `every`."),
        "double_precision": Key(
            Text(r"\S[\s\S]*", "a reason", hint="write why float is not precise enough"),
            "The reason why the node computes in double precision. Chips without double precision "
            "instructions then compute it in software; without this key, the build refuses it.",
        ),
    }
)

PIN = "P[A-K](1[0-5]|[0-9])"
DEVICE = Struct(
    {
        "driver": Key(
            Text(
                "none|[a-z][a-z0-9_]{0,40}/[a-z][a-z0-9_]{0,40}",
                "a driver",
                hint="write CLASS/PART, as in the folder drivers/, or none",
            ),
            "The folder of the driver below drivers/, or none.",
            required=True,
        ),
        "class": Key(Name("a device class"), "The device class; required if `driver` is none."),
        "bus": Key(Name("a bus"), "The bus of the device."),
        "pins": Key(
            Table(Text(PIN, "a pin", hint="write port and number, for example PC2"), "a pin"),
            "The pins of the device.",
        ),
        "lines": Key(
            Table(OneOrMore(Text("[A-Za-z0-9_]{1,40}", "a pin or a peripheral")), "a line"),
            "The pin or peripheral that raises each line; a list if there are several.",
        ),
        "bytes_per_s": Key(
            Integer(1, 2**31 - 1), "The write speed that a storage sustains, in bytes per second."
        ),
    }
)
MEMORY = Struct(
    {
        "at": Key(
            Text(
                "0x[0-9A-Fa-f]{1,8}",
                "an address",
                hint='write it in hexadecimal, for example "0x20000000"',
            ),
            "The first address.",
            required=True,
        ),
        "bytes": Key(Integer(1, 2**32 - 1), "The size in bytes.", required=True),
    }
)
UPLOAD = Struct(
    {
        "board_id": Key(
            Integer(1, 65535),
            "The number that the bootloader and ground stations know this board by.",
            required=True,
        ),
        "pyocd_target": Key(
            Text("[a-z0-9]{1,40}", "a target of pyOCD"), "The name of the chip in pyOCD."
        ),
    }
)
_FROM = Key(Choice(PROVENANCES), "What these times rest on; guessed if left out.")
_MAX_NS = 1_000_000_000


def _ns(doc: str, *, required: bool = True) -> Key:
    return Key(Integer(0, _MAX_NS), doc, required)


COSTS = Struct(
    {
        "from": _FROM,
        "task_ns": _ns(
            "An activation beside its budget: entry and exit of the interrupt, and the generated "
            "code that its budget does not cover."
        ),
        "release_ns": _ns("The handler of the timer for periods, without its timers."),
        "timer_ns": _ns("The same handler, for each timer of the graph."),
        "dispatch_ns": _ns("The handler of an interrupt that several lines share, without these."),
        "line_ns": _ns("The same handler, for each of its lines."),
        "section_ns": _ns("The longest section in which topic operations mask levels."),
        "clock_ns": _ns("The resolution of the clock."),
        "instruction_ns": _ns(
            "The longest mean time of an instruction; `measure` multiplies counts of the emulator "
            "by it.",
            required=False,
        ),
        "interrupts": Key(
            Table(
                Struct(
                    {
                        "min_interarrival": Key(
                            Period(), "The shortest time between two.", required=True
                        ),
                        "budget_ns": _ns("The longest execution time, with entry and exit."),
                    }
                ),
                "a vector",
            ),
            "What the handlers in the board's own code take, above every level. One that is the "
            "`bus` of devices counts only in graphs that have such a device.",
        ),
    }
)
BOARD = Struct(
    {
        "doc": Key(Text(), "What the board is."),
        "executor": Key(Choice(("cortex_m", "pthread", "virtual")), "The runtime.", required=True),
        "chip": Key(
            Text(rf"{_PATH_PART}(/{_PATH_PART}){{0,3}}", "a chip, for example stm32f4/stm32f427"),
            "The file of the chip below boards/, without .yaml.",
        ),
        "reserved_vectors": Key(
            Listing(Text("[a-z0-9_]{1,40}", "a vector")),
            "Vectors that the board itself needs. No task gets one of them.",
        ),
        "interrupts": Key(
            Listing(Text("[a-z0-9_]{1,40}", "a vector")),
            "Vectors with handlers in the board's own code. No task gets one of them.",
        ),
        "memory": Key(
            Table(MEMORY, "a memory"),
            "Memories that differ from the chip's, for example a flash that a bootloader shares.",
        ),
        "costs": Key(COSTS, "What the executor takes beside the nodes, for `prove`."),
        "upload": Key(UPLOAD, "How `build` and `flash` make and load firmware for this board."),
        "devices": Key(
            Table(DEVICE, "a device"),
            "The devices of the board, and the driver of each one.",
            required=True,
        ),
    }
)
CHIP = Struct(
    {
        "doc": Key(Text(), "What the chip is, and the manual that this file comes from."),
        "core": Key(Text(), "The processor core.", required=True),
        "clock": Key(
            Text(
                "[1-9][0-9]{0,3} MHz",
                "a frequency in MHz",
                hint="write whole megahertz, for example 168 MHz",
            ),
            "The frequency of the core's clock.",
            required=True,
        ),
        "priority_bits": Key(
            Integer(2, 8), "The number of bits of an NVIC priority.", required=True
        ),
        "memory": Key(Table(MEMORY, "a memory"), "The memories: flash, ram and ccm."),
        "vectors": Key(
            Table(Integer(0, 239), "a vector", key_pattern=NAME_PATTERN),
            "The interrupt lines that the chip has, and their numbers.",
            required=True,
        ),
    }
)
# graph/budgets/BOARD.yaml: the longest execution time of each node, measured on that board.
BUDGETS = Table(
    Short(
        "budget",
        Struct(
            {
                "budget": Key(
                    Period(), "The longest execution time of one activation.", required=True
                ),
                "from": _FROM,
                "instructions": Key(
                    Integer(1), "The most that `measure` counted in one activation."
                ),
            }
        ),
    ),
    "a node, as NODE, or as GRAPH.NODE where it is for one graph",
    rf"(?:[^.]+\.)?{NAME_PATTERN}",
)
