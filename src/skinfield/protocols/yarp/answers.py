"""What a port answers to people and tools, in the words of YARP 4.0.0.

From `src/libYARP_os/src/yarp/os/impl/PortCoreInputUnit.cpp` and `PortCore.cpp`, as far as tools
look at them; only commands that a port of ours knows are named.
"""

from skinfield.protocols.yarp.bottle import Value, Vocab

UNKNOWN = b"* Error. Protocol not found.\r\n* Try CONNECT and a name.\r\n"
NOT_UNDERSTOOD = (
    "Port command not understood.",
    "Type d to send data to the port's owner.",
    "Type ? for help.",
)
HELP = (
    "This is a YARP port.  Here are the commands it responds to:",
    "*       Gives a description of this port",
    "d       Signals the beginning of input for the port's owner",
    'do      The same as "d" except replies should be suppressed ("data-only")',
    "q       Disconnects",
    "r       Reverse connection type to be a reader",
    "/port   Requests to send output to /port",
    "!/port  Requests to stop sending output to /port",
    "~/port  Requests to stop receiving input from /port",
    "a       Signals the beginning of an administrative message",
    "?       Gives this help",
)
ADMIN_HELP = (
    "[help]                  # give this help",
    "[ver]                   # report protocol version information",
    "[add] $portname         # add an output connection",
    "[add] $portname $car    # add an output with a given protocol",
    "[del] $portname         # remove an input or output connection",
    "[list] [in]             # list input connections",
    "[list] [out]            # list output connections",
)
VERSION: tuple[Value, ...] = (Vocab("ver"), 1, 2, 3)  # of the administrative commands
