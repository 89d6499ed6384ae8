"""Sources of a live skin: settings that open streams, which are polled and never wait."""

from skinfield.wire.sources.boards import CySkinCan as CySkinCan
from skinfield.wire.sources.boards import CySkinSharedMemory as CySkinSharedMemory
from skinfield.wire.sources.boards import ICubCan as ICubCan
from skinfield.wire.sources.packets import PacketSerial as PacketSerial
from skinfield.wire.sources.packets import PacketTcp as PacketTcp
from skinfield.wire.sources.packets import PacketUdp as PacketUdp
from skinfield.wire.sources.streams import NoReadingError as NoReadingError
from skinfield.wire.sources.streams import StreamReader as StreamReader
from skinfield.wire.sources.yarp import YarpPort as YarpPort
from skinfield.wire.sources.yarp import YarpText as YarpText
