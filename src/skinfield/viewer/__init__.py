"""The page: skins in the browser, alive."""

from skinfield.viewer.desk import Desk as Desk
from skinfield.viewer.desk import Press as Press
from skinfield.viewer.feed import Feed as Feed
from skinfield.viewer.page import Page as Page
from skinfield.viewer.page import serve_page as serve_page
from skinfield.viewer.settings import PageSettings as PageSettings
