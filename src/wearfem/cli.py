"""The command line. Each command imports what it needs when it runs, so `wearfem --help` answers at once."""

import os
import sys
from pathlib import Path
from typing import NoReturn

import click

from wearfem import __version__
from wearfem.errors import UserError

settings_option = click.option(
    "--set",
    "settings",
    multiple=True,
    metavar="K=V",
    help='A keyword of the case, with units: --set "throughput=900*tonne/hour". May be repeated.',
)
json_option = click.option(
    "--json", "json_file", type=Path, metavar="FILE", help="Also write the figures to FILE."
)
case_argument = click.argument("case", type=Path)


@click.group(context_settings={"help_option_names": ["-h", "--help"], "max_content_width": 100})
@click.version_option(__version__, message="wearfem %(version)s")
def wearfem() -> None:
    """How a liner wears under a flow of particles, and how long it will last.

    A case is a folder with a case.py in it, like cases/pin_on_disc.
    """


@wearfem.command()
@case_argument
@settings_option
@click.option("--out", type=Path, metavar="DIR", help="The run folder to make; runs/<case> if not given.")
@json_option
@click.option("--quiet", is_flag=True, help="Show no progress.")
def run(case: Path, settings: tuple[str, ...], out: Path | None, json_file: Path | None, quiet: bool) -> None:
    """Run a case: its figures on the screen, everything else in the run folder."""
    from wearfem.run import run_case
    from wearfem.settings import parse_settings

    run_case(case, parse_settings(settings), out, json_file, quiet)


@wearfem.command()
@click.argument("run", type=Path)
@json_option
@click.option("--quiet", is_flag=True, help="Show no progress.")
def resume(run: Path, json_file: Path | None, quiet: bool) -> None:
    """Go on with a run in cycles that was stopped or killed, from its last cycle, to the same bits."""
    from wearfem.run import resume_run

    resume_run(run, json_file, quiet)


@wearfem.command()
@case_argument
@settings_option
@json_option
def check(case: Path, settings: tuple[str, ...], json_file: Path | None) -> None:
    """Check a case before it runs: time step, mesh, memory, time it will take."""
    from wearfem.check import check_case
    from wearfem.settings import parse_settings

    check_case(case, parse_settings(settings), json_file)


@wearfem.command()
@click.argument("run", type=Path)
@click.option("--out", type=Path, metavar="FILE", help="The page to write; report.html in RUN if not given.")
@json_option
def report(run: Path, out: Path | None, json_file: Path | None) -> None:
    """Write one page on a life, for the planner of maintenance; it needs no network and prints well."""
    from wearfem.report_page import write_report

    write_report(run, out, json_file)


@wearfem.command()
@click.argument("names", nargs=-1)
@json_option
def verify(names: tuple[str, ...], json_file: Path | None) -> int:
    """Prove on this machine what is claimed; all proofs, or those named. Exit code 1 if one fails."""
    from wearfem.verify import verify

    return 0 if verify(names, json_file) else 1


@wearfem.command()
@click.argument("names", nargs=-1)
@json_option
@click.option("--quick", is_flag=True, help="One short round; the two small benchmarks if none is named.")
def bench(names: tuple[str, ...], json_file: Path | None, quick: bool) -> None:
    """Measure the speed on this machine; all benchmarks, or those named."""
    from wearfem.bench import bench

    bench(names, json_file, quick)


def main() -> None:
    """Run a command; a user's mistake becomes one sentence and exit code 2."""
    try:
        status = wearfem.main(sys.argv[1:] or ["--help"], prog_name="wearfem", standalone_mode=False)
    except UserError as error:
        stop(str(error), 2)
    except click.ClickException as error:
        stop(f"{error.format_message().rstrip('.?')}; see wearfem --help", 2)
    except (KeyboardInterrupt, click.Abort):
        stop("interrupted; what was written so far is whole", 130)
    except BrokenPipeError:  # the reader of a pipe has seen enough
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        sys.exit(1)
    sys.exit(status or 0)


def stop(sentence: str, code: int) -> NoReturn:
    """Print the sentence on the error stream and end."""
    print(f"wearfem: {sentence.rstrip('.')}.", file=sys.stderr)
    sys.exit(code)


if __name__ == "__main__":
    main()
