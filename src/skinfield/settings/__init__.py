"""Settings of a live skin: one tree for files, the command line and recordings."""

from skinfield.settings.profiles import PROFILES as PROFILES
from skinfield.settings.profiles import Profile as Profile
from skinfield.settings.profiles import load_profile as load_profile
from skinfield.settings.profiles import profile_of as profile_of
from skinfield.settings.text import changed as changed
from skinfield.settings.text import from_plain as from_plain
from skinfield.settings.text import json_from_value as json_from_value
from skinfield.settings.text import load_settings as load_settings
from skinfield.settings.text import settings_from_toml as settings_from_toml
from skinfield.settings.text import toml_from_settings as toml_from_settings
from skinfield.settings.text import value_from_json as value_from_json
from skinfield.settings.tree import PORT as PORT
from skinfield.settings.tree import BridgeSettings as BridgeSettings
from skinfield.settings.tree import Elastomer as Elastomer
from skinfield.settings.tree import LiveModelSettings as LiveModelSettings
from skinfield.settings.tree import LoopSettings as LoopSettings
from skinfield.settings.tree import ModelSettings as ModelSettings
from skinfield.settings.tree import PageSettings as PageSettings
from skinfield.settings.tree import RecordSettings as RecordSettings
from skinfield.settings.tree import SettingError as SettingError
from skinfield.settings.tree import Settings as Settings
from skinfield.settings.tree import SkinSettings as SkinSettings
from skinfield.settings.tree import SourceSettings as SourceSettings
from skinfield.settings.tree import ZenohAddresses as ZenohAddresses
