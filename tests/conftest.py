"""Settings of the tests; the environment that they run in is set in the conftest above."""

import hypothesis

hypothesis.settings.register_profile(
    "slipfold",
    # The same examples in every run; the first one of a test may compile a flow.
    derandomize=True,
    deadline=None,
    suppress_health_check=[hypothesis.HealthCheck.too_slow],
)
hypothesis.settings.load_profile("slipfold")
