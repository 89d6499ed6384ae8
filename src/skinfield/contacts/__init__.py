"""Contacts from fields, whoever made the fields."""

from skinfield.contacts.finder import ContactFinder as ContactFinder
