"""CAN buses and what stands for them: messages in bulk, without ever waiting."""

from skinfield.sources.buses.adapters import open_bus as open_bus
from skinfield.sources.buses.bus import PORT as PORT
from skinfield.sources.buses.bus import Bus as Bus
from skinfield.sources.buses.bus import BusSettings as BusSettings
