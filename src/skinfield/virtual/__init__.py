"""The virtual skin: boards that do not exist, on a real bus, with bytes as real ones send."""

from skinfield.virtual.faults import Fault as Fault
from skinfield.virtual.faults import fault_from_text as fault_from_text
from skinfield.virtual.faults import fault_of as fault_of
from skinfield.virtual.settings import VirtualSettings as VirtualSettings
from skinfield.virtual.settings import Wires as Wires
from skinfield.virtual.skin import VirtualSkin as VirtualSkin
from skinfield.virtual.temperature import Temperature as Temperature
from skinfield.virtual.temperature import temperature_from_text as temperature_from_text
