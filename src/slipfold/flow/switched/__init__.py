"""Motions that switch: contacts slip, stick and open, each way with equations of its own."""
