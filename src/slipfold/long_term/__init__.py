"""Long-term behavior: attractors, basins, exponents, regimes, sweeps, spectra."""
