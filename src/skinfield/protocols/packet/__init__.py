"""Skinfield's own packets, for microcontrollers over UDP, TCP and serial."""

from skinfield.protocols.packet.decoder import NO_ROOM as NO_ROOM
from skinfield.protocols.packet.decoder import DeviceState as DeviceState
from skinfield.protocols.packet.decoder import PacketDecoder as PacketDecoder
from skinfield.protocols.packet.decoder import PacketDevice as PacketDevice
from skinfield.protocols.packet.decoder import PacketScanner as PacketScanner
from skinfield.protocols.packet.encode import Answer as Answer
from skinfield.protocols.packet.encode import Hello as Hello
from skinfield.protocols.packet.encode import encode_command as encode_command
from skinfield.protocols.packet.encode import encode_counts as encode_counts
from skinfield.protocols.packet.encode import encode_packet as encode_packet
from skinfield.protocols.packet.encoder import PacketEncoder as PacketEncoder
from skinfield.protocols.packet.layout import COMMANDS as COMMANDS
from skinfield.protocols.packet.layout import EVERY_DEVICE as EVERY_DEVICE
from skinfield.protocols.packet.layout import LONGEST as LONGEST
from skinfield.protocols.packet.layout import Packet as Packet
from skinfield.protocols.packet.layout import PacketFlag as PacketFlag
from skinfield.protocols.packet.layout import PacketKind as PacketKind
from skinfield.protocols.packet.layout import packet_from_bytes as packet_from_bytes
from skinfield.protocols.packet.layout import packets_of as packets_of
