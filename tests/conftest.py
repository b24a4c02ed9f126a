"""Settings of the tests; the environment that they run in is set in the conftest above."""

import os
import shutil

import hypothesis
import pytest

hypothesis.settings.register_profile(
    "slipfold",
    # The same examples in every run; the first one of a test may compile a flow.
    derandomize=True,
    deadline=None,
    suppress_health_check=[hypothesis.HealthCheck.too_slow],
)
hypothesis.settings.load_profile("slipfold")


@pytest.fixture
def few_lines(monkeypatch):
    """A set is searched from one line each way across its window, not from 11 and 5."""
    monkeypatch.setattr("slipfold.bifurcations.loci.bifurcation_set.LINES", (1, 1))


@pytest.fixture(scope="session")
def browser():
    """Debian's Chromium, one in a process: Playwright cannot be started a second time beside it."""
    sync_api = pytest.importorskip(
        "playwright.sync_api", reason="the browser tests need playwright"
    )
    chromium = shutil.which("chromium") or shutil.which("chromium-browser")
    if chromium is None:
        pytest.skip("there is no chromium")
    # All tabs are one process, which compiles the page once: a tab takes a third of the time.
    options = ["--renderer-process-limit=1"]
    if hasattr(os, "geteuid") and os.geteuid() == 0:
        options.append("--no-sandbox")
    with sync_api.sync_playwright() as playwright:
        started = playwright.chromium.launch(
            executable_path=chromium, args=options, timeout=180_000
        )
        yield started
        started.close()
