"""Sources of a live skin: settings that open streams, which are polled and never wait."""

from skinfield.sources.live.boards import CySkinCan as CySkinCan
from skinfield.sources.live.boards import CySkinSharedMemory as CySkinSharedMemory
from skinfield.sources.live.boards import ICubCan as ICubCan
from skinfield.sources.live.factory import matched as matched
from skinfield.sources.live.factory import skin_for as skin_for
from skinfield.sources.live.factory import source_from_options as source_from_options
from skinfield.sources.live.factory import third_parties as third_parties
from skinfield.sources.live.packets import PacketSerial as PacketSerial
from skinfield.sources.live.packets import PacketTcp as PacketTcp
from skinfield.sources.live.packets import PacketUdp as PacketUdp
from skinfield.sources.live.replay import ReplaySource as ReplaySource
from skinfield.sources.live.replay import SimulationSource as SimulationSource
from skinfield.sources.live.replay import pressed as pressed
from skinfield.sources.live.streams import NoReadingError as NoReadingError
from skinfield.sources.live.streams import StreamReader as StreamReader
from skinfield.sources.live.streams import read as read
from skinfield.sources.live.streams import read_latest as read_latest
from skinfield.sources.live.yarp import YarpPort as YarpPort
from skinfield.sources.live.yarp import YarpText as YarpText
