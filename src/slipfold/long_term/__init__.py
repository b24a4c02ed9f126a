"""What trajectories converge to: spectra, and what their contacts do."""
