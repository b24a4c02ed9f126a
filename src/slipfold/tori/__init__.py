"""Quasi-periodic tori: invariant circles of the stroboscopic map, born at Neimark-Sacker points."""
