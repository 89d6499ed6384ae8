"""Estimates: values on a grid at one instant, the contacts in them, and their tracks."""

from skinfield.estimate.contact import Contact as Contact
from skinfield.estimate.contact_list import ContactList as ContactList
from skinfield.estimate.contact_list import ListedContact as ListedContact
from skinfield.estimate.estimate import Estimate as Estimate
from skinfield.estimate.finder import ContactFinder as ContactFinder
from skinfield.estimate.finder import level_of as level_of
from skinfield.estimate.live_contacts import LiveContacts as LiveContacts
from skinfield.estimate.tracked import ContactEvent as ContactEvent
from skinfield.estimate.tracked import Gate as Gate
from skinfield.estimate.tracked import Motion as Motion
from skinfield.estimate.tracked import TrackedContact as TrackedContact
from skinfield.estimate.tracker import Tracker as Tracker
from skinfield.estimate.uncertainty import ModelError as ModelError
from skinfield.estimate.uncertainty import PressureError as PressureError
from skinfield.estimate.uncertainty import PressureNoise as PressureNoise
from skinfield.estimate.uncertainty import PressurePosterior as PressurePosterior
from skinfield.estimate.wrench import Wrench as Wrench
