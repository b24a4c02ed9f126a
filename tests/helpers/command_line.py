"""Commands run in this process."""

from typer.testing import CliRunner

from slipfold.interface.cli.app import app


def run(*arguments):
    """Run one command; return its exit code, standard output and standard error."""
    result = CliRunner().invoke(app, list(arguments), prog_name="slipfold")
    if result.exception is not None and not isinstance(result.exception, SystemExit):
        raise result.exception
    return result
