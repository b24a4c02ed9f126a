"""A worker is ready soon, however long the first diagram of a user's own model takes."""

from helpers.dry_friction import two_masses
from slipfold.interface.explorer.answering import Answering
from slipfold.interface.explorer.catalogue import Catalogue
from slipfold.interface.explorer.settings import PAGE


def test_a_first_diagram_that_takes_long_is_not_waited_for_least_of_all_by_a_request(monkeypatch):
    def endless(self, request, check, observer, show=None):
        while True:
            check()

    monkeypatch.setattr(Answering, "_diagram", endless)
    monkeypatch.setattr(Answering, "_moved", lambda self, request: None)
    for warming, is_wanted in (0.1, False), (1e9, True):
        monkeypatch.setattr(PAGE, "warming", warming)
        Answering(Catalogue(two_masses(), None)).warm_up(lambda wanted=is_wanted: wanted)
