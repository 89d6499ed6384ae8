"""Sources of a live skin: settings that open streams, which are polled and never wait."""

from skinfield.sources.live.cyskin import CySkinCan as CySkinCan
from skinfield.sources.live.cyskin import CySkinSharedMemory as CySkinSharedMemory
from skinfield.sources.live.icub import ICubCan as ICubCan
from skinfield.sources.live.matching import matched as matched
from skinfield.sources.live.packet_serial import PacketSerial as PacketSerial
from skinfield.sources.live.packet_tcp import PacketTcp as PacketTcp
from skinfield.sources.live.packet_udp import PacketUdp as PacketUdp
from skinfield.sources.live.reading import NoReadingError as NoReadingError
from skinfield.sources.live.reading import StreamReader as StreamReader
from skinfield.sources.live.reading import read as read
from skinfield.sources.live.reading import read_latest as read_latest
from skinfield.sources.live.replay import ReplaySource as ReplaySource
from skinfield.sources.live.simulation import SimulationSource as SimulationSource
from skinfield.sources.live.simulation import pressed as pressed
from skinfield.sources.live.spec import skin_for as skin_for
from skinfield.sources.live.spec import source_from_options as source_from_options
from skinfield.sources.live.spec import third_parties as third_parties
from skinfield.sources.live.yarp_text import YarpPort as YarpPort
from skinfield.sources.live.yarp_text import YarpText as YarpText
