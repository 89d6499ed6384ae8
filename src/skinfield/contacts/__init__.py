"""Contacts from fields, whoever made the fields, and through time."""

from skinfield.contacts.finder import ContactFinder as ContactFinder
from skinfield.contacts.live import Habits as Habits
from skinfield.contacts.live import LiveContacts as LiveContacts
from skinfield.contacts.live import level_of as level_of
from skinfield.contacts.summary import ContactTable as ContactTable
from skinfield.contacts.summary import summarise as summarise
from skinfield.contacts.tracked import ContactEvent as ContactEvent
from skinfield.contacts.tracked import Gate as Gate
from skinfield.contacts.tracked import Motion as Motion
from skinfield.contacts.tracked import TrackedContact as TrackedContact
from skinfield.contacts.tracker import Tracker as Tracker
