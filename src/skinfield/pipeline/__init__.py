"""One patch from readings to contacts, prepared once."""

from skinfield.pipeline.reconstructor import Reconstructor as Reconstructor
