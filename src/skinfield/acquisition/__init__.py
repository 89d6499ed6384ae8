"""From bytes of a source to the newest counts of all channels, losing nothing."""

from skinfield.acquisition.block import Block as Block
from skinfield.acquisition.block import Kind as Kind
from skinfield.acquisition.block import Status as Status
from skinfield.acquisition.block import blocks_of as blocks_of
from skinfield.acquisition.blocks import Blocks as Blocks
from skinfield.acquisition.blocks import Channels as Channels
from skinfield.acquisition.can import CanDecoder as CanDecoder
from skinfield.acquisition.can import CanMessages as CanMessages
from skinfield.acquisition.source import Count as Count
from skinfield.acquisition.source import Lasting as Lasting
from skinfield.acquisition.source import Port as Port
from skinfield.acquisition.source import Retry as Retry
from skinfield.acquisition.source import Source as Source
from skinfield.acquisition.source import Stream as Stream
from skinfield.acquisition.source import counters as counters
