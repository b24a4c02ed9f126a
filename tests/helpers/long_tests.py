"""Families of which some members are tested in every run, and the others with the long tests."""

import pytest


def long_except(members, often):
    """Mark the members of a family as long, except those that every run tests."""
    return [m if m in often else pytest.param(m, marks=pytest.mark.long) for m in members]
