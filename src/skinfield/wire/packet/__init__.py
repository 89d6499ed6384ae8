"""Skinfield's own packets, for microcontrollers over UDP, TCP and serial."""

from skinfield.wire.packet.codec import PacketDecoder as PacketDecoder
from skinfield.wire.packet.codec import PacketDevice as PacketDevice
from skinfield.wire.packet.codec import PacketEncoder as PacketEncoder
from skinfield.wire.packet.codec import PacketScanner as PacketScanner
from skinfield.wire.packet.packets import COMMANDS as COMMANDS
from skinfield.wire.packet.packets import EVERY_DEVICE as EVERY_DEVICE
from skinfield.wire.packet.packets import LONGEST as LONGEST
from skinfield.wire.packet.packets import CommandReply as CommandReply
from skinfield.wire.packet.packets import Hello as Hello
from skinfield.wire.packet.packets import Packet as Packet
from skinfield.wire.packet.packets import PacketFlag as PacketFlag
from skinfield.wire.packet.packets import PacketKind as PacketKind
from skinfield.wire.packet.packets import encode_command as encode_command
from skinfield.wire.packet.packets import encode_counts as encode_counts
from skinfield.wire.packet.packets import encode_packet as encode_packet
from skinfield.wire.packet.packets import packet_from_bytes as packet_from_bytes
