"""What settings in files and on command lines stand for."""

from skinfield.config.indenters import indenter_from_mapping as indenter_from_mapping
