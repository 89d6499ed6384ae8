"""CAN buses and what stands for them: messages in bulk, without ever waiting."""

from skinfield.sources.buses.bus import Bus as Bus
from skinfield.sources.buses.bus import open_bus as open_bus
from skinfield.sources.buses.settings import BusSettings as BusSettings
