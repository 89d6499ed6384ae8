"""Virtual skin: boards that do not exist, on a real bus, with bytes as real ones send."""

from skinfield.virtual.settings import Fault as Fault
from skinfield.virtual.settings import Temperature as Temperature
from skinfield.virtual.settings import VirtualSettings as VirtualSettings
from skinfield.virtual.settings import Wires as Wires
from skinfield.virtual.settings import fault_from_text as fault_from_text
from skinfield.virtual.settings import fault_of as fault_of
from skinfield.virtual.settings import temperature_from_text as temperature_from_text
from skinfield.virtual.skin import VirtualSkin as VirtualSkin
