"""The skin of iCub and ergoCub on CAN, and inside the Ethernet of their boards."""

from skinfield.protocols.icub.decoder import ICubDecoder as ICubDecoder
from skinfield.protocols.icub.decoder import port_of as port_of
from skinfield.protocols.icub.encoder import ICubEncoder as ICubEncoder
from skinfield.protocols.icub.encoder import gains_of as gains_of
from skinfield.protocols.icub.encoder import triangle_payloads as triangle_payloads
from skinfield.protocols.icub.numbers import BOARD_CHANNELS as BOARD_CHANNELS
from skinfield.protocols.icub.numbers import BOARDS as BOARDS
from skinfield.protocols.icub.numbers import TAXELS as TAXELS
from skinfield.protocols.icub.numbers import TRIANGLES as TRIANGLES
from skinfield.protocols.icub.numbers import Firmware as Firmware
from skinfield.protocols.icub.numbers import MessageClass as MessageClass
from skinfield.protocols.icub.numbers import SkinType as SkinType
from skinfield.protocols.icub.numbers import message_id as message_id
from skinfield.protocols.icub.numbers import skin_type as skin_type
