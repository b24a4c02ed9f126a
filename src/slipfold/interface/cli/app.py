"""The command-line application: its commands, error messages and exit statuses."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from typing import Annotated, Any, NoReturn

import typer
from typer.core import TyperGroup

from slipfold.errors import InputError
from slipfold.interface.cli import explore, locus, measured, models, plot, study, thresholds
from slipfold.interface.cli.commands import LOCUS_SETTINGS, PLANE, VALUES, Command
from slipfold.interface.cli.running import BAD_INPUT, DONE, INTERRUPTED, note, say

# The base class of typer's errors about arguments; its module depends on the version of typer.
UsageError: Any = typer.BadParameter.__mro__[1]


RESPONSE, LOCI, LONG_TERM, MEASURED, THRESHOLDS = (
    f"slipfold.computations.{name}"
    for name in ("response", "loci", "long_term", "measured", "thresholds")
)

COMMANDS = {
    "response": Command(
        f"{RESPONSE}:response",
        "Follow the periodic response over a parameter, with all bifurcations and doubled "
        "branches.",
    ),
    "locus": Command(
        "slipfold.interface.cli.locus:locus",
        "Find all bifurcations in a window of two parameters, and follow their loci.\n\n"
        "With a saved response, follow the loci through its special points, and those that start "
        "on these loci.",
        {"given": locus.GIVEN, "settings": LOCUS_SETTINGS},
    ),
    "backbone": Command(
        "slipfold.computations.backbone:backbone",
        "Follow a nonlinear mode: frequency and damping ratio of free vibration over its "
        "amplitude.",
    ),
    "simulate": Command(
        f"{LONG_TERM}:simulate",
        "Integrate from the model's start or a given state; report the steady state, if one is "
        "reached.",
    ),
    "lyapunov": Command(
        f"{LONG_TERM}:lyapunov",
        "Distinguish periodic, quasi-periodic and chaotic solutions by their Lyapunov exponents.",
    ),
    "attractors": Command(
        f"{LONG_TERM}:attractors",
        "Find the attractors that starts in a box converge to: responses, cycles, equilibria, "
        "tori and chaos.",
    ),
    "basins": Command(
        f"{LONG_TERM}:basins", "Compute the attractor that each start in a plane converges to."
    ),
    "basin-fractions": Command(
        f"{LONG_TERM}:basin_fractions",
        "Compute the fraction of starts that converge to each attractor, over a parameter.",
    ),
    "sweep": Command(
        f"{LONG_TERM}:sweep",
        "Sweep a parameter up and down, and start again at each value; store a state each period.",
    ),
    "regimes": Command(
        f"{LONG_TERM}:regimes",
        "Map the regimes over two parameters: periods, tori, chaos and stick-slip.",
        {"vary": PLANE},
    ),
    "study": Command(
        "slipfold.interface.cli.study:study",
        "Compute the same quantities for many cases, on all cores or on a cluster.\n\n"
        "Each finished case is stored at once. After Ctrl-C, a crash or a full disk --resume "
        "continues. A case that fails is stored with its reason; the others continue.",
        study.READERS,
    ),
    "uncertainty": Command(
        f"{THRESHOLDS}:uncertainty",
        "Compute the distribution of a threshold, by its gradients and by samples.",
        thresholds.POINT,
    ),
    "design": Command(
        f"{THRESHOLDS}:design",
        "Choose parameters that minimize the vibration while a threshold meets a bound.",
        thresholds.KEPT,
    ),
    "measure": Command(
        f"{MEASURED}:measure",
        "Simulate a test rig: sweep a parameter and measure the response, with jumps and noise.",
        {"vary": VALUES, "outputs": measured.MEASUREMENT_FILE},
        {"seed": 1},
    ),
    "fit": Command(
        f"{MEASURED}:fit",
        "Fit parameters to a measured response, with confidence intervals.",
        {"measurement": measured.MEASUREMENT},
    ),
    "plan": Command(
        f"{MEASURED}:plan_measurement",
        "Compute how accurately planned measurements determine parameters, and which of them are "
        "best.",
        {"vary": VALUES, "outputs": measured.PLAN_FILES},
    ),
    "paper": Command(
        "slipfold.interface.cli.study:paper",
        "Compute and draw the source paper's figures, thresholds and claims, and bifurcation sets.",
    ),
    "models": Command(
        "slipfold.interface.cli.models:models",
        "List the built-in models, or parameters, states, outputs and limits of one of them.",
        models.READERS,
    ),
    "shapes": Command(
        "slipfold.interface.cli.shapes:shapes",
        "Write the modes of a structure on its mesh, or draw one of them.",
    ),
    "plot": Command("slipfold.interface.cli.plot:plot", "Draw a saved result.", plot.READERS),
    "explore": Command(
        "slipfold.interface.cli.explore:explore",
        "Open the explorer in the browser, for this machine only; Ctrl-C ends it.",
        explore.READERS,
    ),
}
"""The commands in the order in which they are listed."""


HELP = {"help_option_names": ["-h", "--help"]}


class Commands(TyperGroup):
    """Commands that report errors in a sentence; a bug still shows its traceback."""

    def main(
        self,
        args: Sequence[str] | None = None,
        prog_name: str | None = None,
        complete_var: str | None = None,
        standalone_mode: bool = True,
        windows_expand_args: bool = True,
        **extra: Any,
    ) -> NoReturn:
        """Run and exit."""
        try:
            status = super().main(
                args,
                prog_name,
                complete_var,
                standalone_mode=False,
                windows_expand_args=windows_expand_args,
                **extra,
            )
        except InputError as error:
            status = _fail(str(error))
        except UsageError as error:
            status = _fail(_usage_sentence(error, self._requested(prog_name, args)))
        except KeyboardInterrupt:
            note("interrupted; nothing was written")
            status = INTERRUPTED
        sys.exit(status if isinstance(status, int) else DONE)

    def _requested(self, program: str | None, args: Sequence[str] | None) -> str:
        """Return the name of the program and of the requested command, if there is one."""
        given = sys.argv[1:] if args is None else list(args)
        named = [program or "slipfold", *(name for name in given[:1] if name in self.commands)]
        return " ".join(named)

    def resolve_command(self, ctx: Any, args: list[str]) -> tuple[str | None, Any, list[str]]:
        """Return the requested command with its options; import no other command."""
        name, listed, others = super().resolve_command(ctx, args)
        if name is None or listed is None:
            return name, listed, others
        alone = typer.Typer(add_completion=False, rich_markup_mode=None)
        alone.command(name, context_settings=HELP)(COMMANDS[name].program())
        return name, typer.main.get_command(alone), others

    def invoke(self, ctx: Any) -> Any:
        """Run the command."""
        try:
            return super().invoke(ctx)
        except KeyboardInterrupt:  # typer would exit without a message
            note("interrupted; nothing was written")
            raise typer.Exit(INTERRUPTED) from None


def _fail(sentence: str) -> int:
    note(sentence)
    return BAD_INPUT


def _usage_sentence(error: Any, command: str) -> str:
    message = " ".join(error.format_message().split()).rstrip(".?")
    hint = "put a text with spaces in quotes, or " if "unexpected extra" in message else ""
    return f"{message}; {hint}see {command} --help"


app = typer.Typer(
    name="slipfold",
    cls=Commands,
    add_completion=False,
    rich_markup_mode=None,
    pretty_exceptions_enable=False,
    context_settings=HELP,
)

Version = Annotated[bool, typer.Option("--version", help="Show the version and exit.")]


@app.callback(invoke_without_command=True)
def start(context: typer.Context, version: Version = False) -> None:
    """Vibration of sliding structures with friction, and how it loses stability."""
    if version:
        from slipfold.version import package_version

        say(f"slipfold {package_version()}")
        raise typer.Exit
    if context.invoked_subcommand is None:
        say(context.get_help())
        raise typer.Exit


for name, listed in COMMANDS.items():
    app.command(name, help=listed.help)(lambda: None)
