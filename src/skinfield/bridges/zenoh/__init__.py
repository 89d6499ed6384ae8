"""Estimates, contacts and health of live skins over zenoh, and feeds of skins elsewhere."""

from skinfield.bridges.zenoh.feed import ZenohFeed as ZenohFeed
from skinfield.bridges.zenoh.feeds import ZenohFeeds as ZenohFeeds
from skinfield.bridges.zenoh.feeds import connect as connect
from skinfield.bridges.zenoh.session import Access as Access
from skinfield.bridges.zenoh.session import Tls as Tls
from skinfield.bridges.zenoh.session import ZenohSettings as ZenohSettings
from skinfield.bridges.zenoh.session import open_session as open_session
