"""Skinfield's own packets, for microcontrollers over UDP, TCP and serial."""

from skinfield.protocols.packet.codec import NO_ROOM as NO_ROOM
from skinfield.protocols.packet.codec import DeviceState as DeviceState
from skinfield.protocols.packet.codec import PacketDecoder as PacketDecoder
from skinfield.protocols.packet.codec import PacketDevice as PacketDevice
from skinfield.protocols.packet.codec import PacketEncoder as PacketEncoder
from skinfield.protocols.packet.codec import PacketScanner as PacketScanner
from skinfield.protocols.packet.packets import COMMANDS as COMMANDS
from skinfield.protocols.packet.packets import EVERY_DEVICE as EVERY_DEVICE
from skinfield.protocols.packet.packets import LONGEST as LONGEST
from skinfield.protocols.packet.packets import Answer as Answer
from skinfield.protocols.packet.packets import Hello as Hello
from skinfield.protocols.packet.packets import Packet as Packet
from skinfield.protocols.packet.packets import PacketFlag as PacketFlag
from skinfield.protocols.packet.packets import PacketKind as PacketKind
from skinfield.protocols.packet.packets import encode_command as encode_command
from skinfield.protocols.packet.packets import encode_counts as encode_counts
from skinfield.protocols.packet.packets import encode_packet as encode_packet
from skinfield.protocols.packet.packets import packet_from_bytes as packet_from_bytes
from skinfield.protocols.packet.packets import packets_of as packets_of
