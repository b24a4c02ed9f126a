"""How large states are, and which of them nothing feeds."""
