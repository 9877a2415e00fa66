"""Starts, domains and engines that a scene may name: each imported object is one entry.

Messages list the entries in this order. Their files are imported with the first scene.
"""

# isort: off
from longwave.scenes.starts.start_entries import computed_soliton as computed_soliton
from longwave.scenes.starts.start_entries import perturbed_plane as perturbed_plane
from longwave.scenes.engines.engine_entries import window as window
from longwave.scenes.engines.engine_entries import ring as ring
from longwave.scenes.engines.engine_entries import closed_ring as closed_ring
from longwave.scenes.engines.engine_entries import stencil as stencil
from longwave.scenes.engines.engine_entries import spectral as spectral
