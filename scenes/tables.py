"""Table of the starts, domains and engines that a scene may name: each import is one entry.

Messages list the entries in this order. What they import at the top is imported with every scene.
"""

# isort: off
from longwave.scenes.starts.start_entries import computed_soliton as computed_soliton
from longwave.scenes.starts.start_entries import perturbed_plane as perturbed_plane
from longwave.scenes.description.numerics import window as window
from longwave.scenes.description.numerics import ring as ring
from longwave.scenes.description.numerics import closed_ring as closed_ring
from longwave.scenes.description.numerics import stencil as stencil
from longwave.scenes.description.numerics import spectral as spectral
