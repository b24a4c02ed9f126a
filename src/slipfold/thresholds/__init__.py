"""Maps of thresholds over a grid of two parameters, in SIMD batches."""
