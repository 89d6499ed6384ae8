"""The page: skins in the browser, alive."""

from skinfield.viewer.controller import Controller as Controller
from skinfield.viewer.controller import Press as Press
from skinfield.viewer.server import Page as Page
from skinfield.viewer.server import serve_page as serve_page
from skinfield.viewer.source import DataSource as DataSource
