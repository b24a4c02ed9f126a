"""How perturbations of an orbit grow: multipliers, eigenvalues, and functions of them."""
