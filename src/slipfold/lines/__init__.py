"""Branches and loci as smooth lines, cut where what they mean changes."""
