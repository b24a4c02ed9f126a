"""What motions settle on: spectra, and what their contacts do."""

from slipfold.attractors.contacts import find_contacts as find_contacts
from slipfold.attractors.spectrum import Spectrum as Spectrum
from slipfold.attractors.spectrum import find_spectrum as find_spectrum
