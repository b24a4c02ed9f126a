"""A worker is ready soon, however long the first diagram of a user's own model takes."""

from helpers.dry_friction import two_masses
from slipfold.interface.explorer.answering import Answering
from slipfold.interface.explorer.catalogue import Catalogue
from slipfold.interface.explorer.settings import PAGE


def test_a_first_diagram_that_takes_long_is_not_waited_for(monkeypatch):
    def endless(self, request, check, observer, show=None):
        while True:
            check()

    monkeypatch.setattr(PAGE, "warming", 0.1)
    monkeypatch.setattr(Answering, "_diagram", endless)
    monkeypatch.setattr(Answering, "_moved", lambda self, request: None)
    Answering(Catalogue(two_masses(), None)).warm_up()
