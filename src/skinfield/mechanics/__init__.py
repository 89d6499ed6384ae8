"""Green's functions of the elastomer. Arrays in, arrays out; no state, no sensors."""

from skinfield.mechanics.elastomer import Layer as Layer
