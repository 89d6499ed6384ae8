"""CAN buses and what stands for them: messages in bulk, without ever waiting."""

from skinfield.wire.can.adapters import open_bus as open_bus
from skinfield.wire.can.bus import PORT as PORT
from skinfield.wire.can.bus import Bus as Bus
from skinfield.wire.can.bus import BusSettings as BusSettings
from skinfield.wire.can.messages import CanMessages as CanMessages
