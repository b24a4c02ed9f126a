"""Who works on each part: name, script and arguments. One call of each is a round."""

Contenders = dict[str, tuple[str, ...]]

RESPONSES: Contenders = {
    "slipfold": ("ours.py", "--repeat", "3"),
    **{
        f"{name}, {settings}": (f"peers/{script}", "--repeat", "2", "--settings", settings)
        for name, script in (("AUTO-07p", "auto07p.py"), ("XPPAUT", "xppaut.py"))
        for settings in ("reliable", "largest", "fine")
    },
    "SciPy": ("peers/scipy_simulate.py", "--repeat", "1"),
}

LOCUS: Contenders = {
    "slipfold": ("ours_locus.py", "--repeat", "3"),
    **{
        f"AUTO-07p, {settings}": (
            "peers/auto07p_locus.py", "--repeat", "2", "--settings", settings
        )
        for settings in ("reliable", "largest", "fine")
    },
}  # fmt: skip

THRESHOLDS: Contenders = {
    "slipfold": ("threshold_map.py", "--repeat", "3"),
    "AUTO-07p, reliable": (
        "peers/auto07p_thresholds.py", "--repeat", "12", "--settings", "reliable"
    ),
}  # fmt: skip
"""AUTO-07p in a loop over as many points as repeats."""

SYSTEM_PEERS = {
    "AUTO-07p": "peers/auto07p_systems.py",
    "XPPAUT": "peers/xppaut_systems.py",
    "pyHarm": "peers/pyharm_systems.py",
}

REPEATS = {"duffing": "2", "vanderpol": "2", "chain": "1"}

SYSTEMS: dict[str, Contenders] = {
    system: {
        "slipfold": ("ours_systems.py", "--repeat", "3", "--system", system),
        **{
            f"{name}, {settings}": (
                script, "--repeat", repeat, "--settings", settings, "--system", system
            )
            for name, script in SYSTEM_PEERS.items()
            if name != "pyHarm" or system == "duffing"
            for settings in ("usual", "large", "fine")
        },
    }
    for system, repeat in REPEATS.items()
}  # fmt: skip
"""pyHarm has elements for the first only."""

CYCLES: dict[str, Contenders] = {
    name: {
        "slipfold": ("ours_cycles.py", "--repeat", "2", "--system", name),
        **{
            f"AUTO-07p, {settings}": (
                "peers/auto07p_cycles.py", "--repeat", "1", "--settings", settings, "--system", name
            )
            for settings in ("usual", "large", "fine")
        },
    }
    for name in ("canards", "relaxation", "beam")
}  # fmt: skip

STICK: Contenders = {
    "slipfold": ("peers/slipfold_stick.py", "--repeat", "3"),
    "SciPy": ("peers/scipy_stick.py", "--repeat", "1"),
    "solve-nivp": ("peers/nivp_stick.py", "--repeat", "1"),
}

BATCH: Contenders = {
    "slipfold": ("peers/slipfold_batch.py", "--repeat", "3"),
    "pynamicalsys": ("peers/pynamicalsys_batch.py", "--repeat", "1"),
    "SciPy": ("peers/scipy_batch.py", "--repeat", "1"),
}

ENSEMBLE: Contenders = {"slipfold": ("ensemble.py", "--repeat", "1")}

SIZE: Contenders = {"slipfold": ("size.py", "--repeat", "3")}

STRUCTURES: Contenders = {
    "slipfold": ("ours_structures.py", "--repeat", "3"),
    "harmonic balance": ("peers/balance_structures.py", "--repeat", "1"),
    "harmonic balance, fine": (
        "peers/balance_structures.py", "--repeat", "1", "--settings", "fine"
    ),
    "pyHarm": ("peers/pyharm_structures.py", "--repeat", "1"),
    "slipfold, dry": ("ours_structures.py", "--repeat", "3", "--settings", "dry"),
    "time stepping, dry": ("peers/stepping_structures.py", "--repeat", "1"),
    "time stepping, dry, fine": (
        "peers/stepping_structures.py", "--repeat", "1", "--settings", "fine"
    ),
}  # fmt: skip

STUDY = "many_cases/measure.py"

AFTER_THE_HOPF: Contenders = {"slipfold": ("many_cases/after_the_hopf.py", "--repeat", "1")}

LATENCY: Contenders = {"explorer": ("latency.py", "--moves", "20")}
"""Left out where there is no browser."""

ROUNDS = {"responses": 3, "locus": 3, "duffing": 2, "vanderpol": 2, "commands": 3}
"""Rounds of what takes seconds; all else has one, whose repeats follow one another."""

BUDGETS = {"beam": 40.0, "chain": 90.0}
"""Seconds that another program gets with each of its settings, where some are known not to end in a
quarter of an hour or to take minutes."""

BUDGET = 120.0
"""The same of all other parts."""
