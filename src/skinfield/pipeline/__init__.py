"""One patch from readings to contacts, prepared once; `pipeline.conditioned` feeds recordings."""

from skinfield.pipeline.reconstructor import Reconstructor as Reconstructor
