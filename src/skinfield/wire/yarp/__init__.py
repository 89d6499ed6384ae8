"""YARP: bottles, carriers, output ports, questions to a name server; YARP itself is not needed."""

from skinfield.wire.yarp.carriers import Carrier as Carrier
from skinfield.wire.yarp.carriers import bytes_from_bottle as bytes_from_bottle
from skinfield.wire.yarp.carriers import checked_name as checked_name
from skinfield.wire.yarp.carriers import envelope as envelope
from skinfield.wire.yarp.carriers import text_from_bottle as text_from_bottle
from skinfield.wire.yarp.carriers import values_from_text as values_from_text
from skinfield.wire.yarp.contact_log import ContactLog as ContactLog
from skinfield.wire.yarp.contact_log import is_contact_log as is_contact_log
from skinfield.wire.yarp.contact_log import open_contact_log as open_contact_log
from skinfield.wire.yarp.contacts import SkinContact as SkinContact
from skinfield.wire.yarp.contacts import SkinPart as SkinPart
from skinfield.wire.yarp.contacts import part_of as part_of
from skinfield.wire.yarp.contacts import parts_of as parts_of
from skinfield.wire.yarp.contacts import port_of as port_of
from skinfield.wire.yarp.port import PORT as PORT
from skinfield.wire.yarp.port import NameReply as NameReply
from skinfield.wire.yarp.port import NameServer as NameServer
from skinfield.wire.yarp.port import Port as Port
