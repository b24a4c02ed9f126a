"""What motions settle on: spectra, and what their contacts do."""
