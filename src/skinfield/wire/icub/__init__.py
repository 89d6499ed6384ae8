"""Skin of iCub and ergoCub on CAN."""

from skinfield.wire.icub.codec import ICubDecoder as ICubDecoder
from skinfield.wire.icub.codec import ICubEncoder as ICubEncoder
from skinfield.wire.icub.codec import gains_of as gains_of
from skinfield.wire.icub.commands import BoardState as BoardState
from skinfield.wire.icub.commands import Firmware as Firmware
from skinfield.wire.icub.commands import MessageClass as MessageClass
from skinfield.wire.icub.commands import SetBoard as SetBoard
from skinfield.wire.icub.commands import SetTriangles as SetTriangles
from skinfield.wire.icub.commands import SkinType as SkinType
from skinfield.wire.icub.commands import Transmit as Transmit
from skinfield.wire.icub.commands import TriangleState as TriangleState
from skinfield.wire.icub.commands import addressed_board as addressed_board
from skinfield.wire.icub.commands import command_from as command_from
from skinfield.wire.icub.commands import host_message as host_message
from skinfield.wire.icub.commands import message_id as message_id
from skinfield.wire.icub.configuration import ICubBoardSettings as ICubBoardSettings
from skinfield.wire.icub.configuration import ICubConfiguration as ICubConfiguration
from skinfield.wire.icub.configuration import configuration_for as configuration_for
from skinfield.wire.icub.configuration import kind_for as kind_for
from skinfield.wire.icub.configuration import load_configuration as load_configuration
from skinfield.wire.icub.robot_files import PortRun as PortRun
