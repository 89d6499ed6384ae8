"""Contacts from fields, whoever made the fields, and through time."""

from skinfield.contacts.finder import ContactFinder as ContactFinder
from skinfield.contacts.live import Habits as Habits
from skinfield.contacts.live import LiveContacts as LiveContacts
from skinfield.contacts.live import level_of as level_of
from skinfield.contacts.summary import ContactTable as ContactTable
from skinfield.contacts.summary import summarise as summarise
from skinfield.contacts.tracker import Tracker as Tracker
from skinfield.contacts.tracking.habits import Gate as Gate
from skinfield.contacts.tracking.motion import Motion as Motion
from skinfield.contacts.tracking.tracked import ContactEvent as ContactEvent
from skinfield.contacts.tracking.tracked import TrackedContact as TrackedContact
