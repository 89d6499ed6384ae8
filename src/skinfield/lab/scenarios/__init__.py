"""Scenarios: what settings of the rig and of its bodies in files stand for."""

from skinfield.lab.scenarios.indenters import indenter_from_mapping as indenter_from_mapping
from skinfield.lab.scenarios.scenario import load_scenario as load_scenario
from skinfield.lab.scenarios.scenario import rig_tasks as rig_tasks
from skinfield.lab.scenarios.scenario import scenario_from_toml as scenario_from_toml
from skinfield.lab.scenarios.scenario import template as template
