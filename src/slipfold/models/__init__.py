"""Physics: states, parameters, symbolic equations, outputs and limits of validity."""
