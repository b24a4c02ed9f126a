"""Responses of many cases, followed side by side as far as nothing is out of the ordinary."""
