"""What motions settle on: spectra."""

from slipfold.attractors.spectrum import Spectrum as Spectrum
from slipfold.attractors.spectrum import find_spectrum as find_spectrum
