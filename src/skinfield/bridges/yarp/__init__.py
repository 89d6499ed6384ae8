"""YARP: contacts of a live skin, as skinDynLib's programs expect them."""

from skinfield.bridges.yarp.contacts import ContactList as ContactList
from skinfield.bridges.yarp.publisher import YarpSettings as YarpSettings
