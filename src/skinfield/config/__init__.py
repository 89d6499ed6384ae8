"""What settings in files and on command lines stand for."""

from skinfield.config.indenters import indenter_from_mapping as indenter_from_mapping
from skinfield.config.scenario import load_scenario as load_scenario
from skinfield.config.scenario import make_run as make_run
from skinfield.config.scenario import rig_tasks as rig_tasks
from skinfield.config.scenario import scenario_from_toml as scenario_from_toml
from skinfield.config.scenario import template as template
from skinfield.config.scenario import toml_from_scenario as toml_from_scenario
