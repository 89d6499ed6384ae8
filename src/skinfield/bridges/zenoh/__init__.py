"""Estimates, contacts and health of live skins over zenoh, and sources of skins elsewhere."""

from skinfield.bridges.zenoh.discovery import ZenohSources as ZenohSources
from skinfield.bridges.zenoh.discovery import connect as connect
from skinfield.bridges.zenoh.session import ZenohSettings as ZenohSettings
from skinfield.bridges.zenoh.session import open_session as open_session
from skinfield.bridges.zenoh.source import ZenohSource as ZenohSource
