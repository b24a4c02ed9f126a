"""What motions settle on: spectra, and what their contacts do."""

from slipfold.long_term.contacts import find_contacts as find_contacts
from slipfold.long_term.spectrum import Spectrum as Spectrum
from slipfold.long_term.spectrum import find_spectrum as find_spectrum
