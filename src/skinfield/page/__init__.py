"""Page: skins in the browser, alive."""

from skinfield.page.controller import Controller as Controller
from skinfield.page.presser import Press as Press
from skinfield.page.server import Page as Page
from skinfield.page.server import serve_page as serve_page
from skinfield.page.source import DataSource as DataSource
