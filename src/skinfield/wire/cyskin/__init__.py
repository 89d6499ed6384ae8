"""CySkin: its packets over CAN, its modules and channels, its shared memory."""

from skinfield.wire.cyskin.board import CySkinBoardState as CySkinBoardState
from skinfield.wire.cyskin.board import start_messages as start_messages
from skinfield.wire.cyskin.board import stop_messages as stop_messages
from skinfield.wire.cyskin.codec import CySkinDecoder as CySkinDecoder
from skinfield.wire.cyskin.codec import CySkinEncoder as CySkinEncoder
from skinfield.wire.cyskin.modules import Command as Command
from skinfield.wire.cyskin.modules import CySkinBoard as CySkinBoard
from skinfield.wire.cyskin.modules import CySkinModule as CySkinModule
from skinfield.wire.cyskin.modules import boards_from_uids as boards_from_uids
from skinfield.wire.cyskin.modules import on_boards as on_boards
from skinfield.wire.cyskin.modules import port_of as port_of
from skinfield.wire.cyskin.modules import skin_on_boards as skin_on_boards
from skinfield.wire.cyskin.modules import uids_of as uids_of
from skinfield.wire.cyskin.shared_memory import SharedMemoryReader as SharedMemoryReader
from skinfield.wire.cyskin.wire import Crc as Crc
from skinfield.wire.cyskin.wire import CySkinWire as CySkinWire
from skinfield.wire.cyskin.wire import Sum as Sum
from skinfield.wire.cyskin.wire import Unchecked as Unchecked
from skinfield.wire.cyskin.wire import matching_checksums as matching_checksums
