"""Formulas as text: their words, grammar, trees and values; the functions they may use."""
