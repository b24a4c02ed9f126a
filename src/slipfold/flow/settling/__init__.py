"""Whether a motion has settled: on a periodic response, a cycle or an equilibrium."""
