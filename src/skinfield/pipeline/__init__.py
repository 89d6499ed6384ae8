"""One patch from readings to contacts, prepared once."""

from skinfield.pipeline.conditioned import Conditioned as Conditioned
from skinfield.pipeline.conditioned import Conditioning as Conditioning
from skinfield.pipeline.conditioned import condition as condition
from skinfield.pipeline.conditioned import without_empty as without_empty
from skinfield.pipeline.reconstructor import Reconstructor as Reconstructor
