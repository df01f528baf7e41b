"""The command line. Each command imports what it needs when it runs, so `wearfem --help` answers at once."""

import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import click

from wearfem import __version__
from wearfem.errors import UserError, in_a_sentence, in_words

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


class InOrder(click.Group):
    """Commands in the order in which they are written, which is that of their use."""

    def list_commands(self, context: click.Context) -> list[str]:
        """Their names."""
        return list(self.commands)


@click.group(cls=InOrder, context_settings={"help_option_names": ["-h", "--help"], "max_content_width": 100})
@click.version_option(__version__, message="wearfem %(version)s")
def wearfem() -> None:
    """How a liner wears under a flow of particles, and how long it will last.

    A case is a folder with a case.py in it, like cases/pin_on_disc.
    """


@wearfem.command(short_help="Run a case: a flow, or the whole life of a liner.")
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


@wearfem.command(short_help="Go on with a life that was stopped or killed.")
@click.argument("run", type=Path)
@json_option
@click.option("--quiet", is_flag=True, help="Show no progress.")
def resume(run: Path, json_file: Path | None, quiet: bool) -> None:
    """Go on with a run in cycles that was stopped or killed, from its last cycle, to the same bits."""
    from wearfem.run import resume_run

    resume_run(run, json_file, quiet)


@wearfem.command(short_help="Before a run: time step, mesh, memory, time.")
@case_argument
@settings_option
@json_option
def check(case: Path, settings: tuple[str, ...], json_file: Path | None) -> None:
    """Check a case before it runs: time step, mesh, memory, time it will take."""
    from wearfem.check import check_case
    from wearfem.settings import parse_settings

    check_case(case, parse_settings(settings), json_file)


@wearfem.command(short_help="Run a case over values of its keywords.")
@case_argument
@click.argument("values", nargs=-1, required=True, metavar="KEYWORD=VALUES...")
@click.option(
    "--grid", "way", flag_value="grid", default="grid", help="Every combination of the values (the default)."
)
@click.option(
    "--list", "way", flag_value="list", help="The first values together, then the second, and so on."
)
@click.option("--sobol", type=int, metavar="N", help="N points of a Sobol sequence; N is a power of 2.")
@click.option("--latin", type=int, metavar="N", help="N points of a Latin hypercube.")
@click.option("--seed", type=int, default=0, show_default=True, help="Of the points of --sobol and --latin.")
@settings_option
@click.option(
    "--size",
    "sizes",
    multiple=True,
    metavar="K",
    help="A keyword that is a mesh size or the like: tell order and converged answer.",
)
@click.option(
    "--out",
    type=Path,
    metavar="DIR",
    help="The study folder, new or to go on with; runs/<case>-study if not given.",
)
@click.option(
    "--workers", type=int, metavar="N", help="Runs at a time; as many as there are cores if not given."
)
@click.option(
    "--scheduler", metavar="ADDRESS", help="Run on the workers of a Dask scheduler, like tcp://10.0.0.1:8786."
)
@click.option("--retry", is_flag=True, help="Run again what has failed.")
@json_option
@click.option("--quiet", is_flag=True, help="Show no progress.")
def study(
    case: Path,
    values: tuple[str, ...],
    way: str,
    sobol: int | None,
    latin: int | None,
    seed: int,
    settings: tuple[str, ...],
    sizes: tuple[str, ...],
    out: Path | None,
    workers: int | None,
    scheduler: str | None,
    retry: bool,
    json_file: Path | None,
    quiet: bool,
) -> int:
    """Run a case over values of its keywords: "mesh=8,6,4*mm" "smoothing=0,10,20*mm", or ranges "mesh=4..8*mm" for points.

    What is done is not run again. Exit code 1 if a run failed.
    """
    from contextlib import nullcontext

    from wearfem.settings import parse_settings
    from wearfem.study import dask_executor, planned, study

    plan = planned(case, values, parse_settings(settings), way == "list", sobol, latin, seed)
    with dask_executor(scheduler) if scheduler else nullcontext() as executor:
        rows = study(
            case,
            plan,
            out,
            executor=executor,
            workers=workers,
            sizes=sizes,
            retry=retry,
            json_file=json_file,
            quiet=quiet,
        )
    return int(any(row.status == "failed" for row in rows))


survey_argument = click.argument("survey", type=Path)
progress_option = click.option(
    "--progress", default="", metavar="COLUMN", help="The column that counts service."
)
exposure_option = click.option(
    "--exposure", type=Path, metavar="CSV", help="Baseline wear by point, with features of the state."
)
run_option = click.option(
    "--run", "run_folder", type=Path, metavar="RUN", help="The run that the readings belong to."
)


def forecast_options(command: Callable[..., None]) -> Callable[..., None]:
    """The options of a forecast, for every command that makes one; they come as keywords."""
    options = [
        click.option("--limit", default="", metavar="LENGTH", help="Thickness, or wear read, at which a liner is changed, like 8*mm."),
        click.option("--stress-limit", default="", metavar="STRESS", help="Largest von Mises stress allowed, like 250*MPa."),
        click.option("--next-stop", default="", metavar="WHEN", help="Service time or throughput since new, like 600*hour or 60*kt."),
        click.option("--coefficient-error", default="", metavar="PART", help="Doubt of the wear coefficient, one deviation, like 0.1."),
        click.option("--calibration", type=Path, metavar="FILE", help="The same from what wearfem calibrate --json wrote."),
        click.option("--study", type=Path, metavar="DIR", help="Mesh error from a study of the case over a mesh size."),
        click.option("--frozen", type=Path, metavar="RUN", help="A run of the case with frozen geometry, to be shown beside."),
        click.option("--price", type=float, metavar="MONEY", help="Of a new liner, fitted; needed for costs."),
        click.option("--unplanned-price", type=float, metavar="MONEY", help="Of a stop that nobody planned, beside standing."),
        click.option("--hour-price", type=float, metavar="MONEY", help="Of an hour in which the plant stands."),
        click.option("--planned-hours", type=float, metavar="HOURS", help="That the plant stands for a planned change."),
        click.option("--unplanned-hours", type=float, metavar="HOURS", help="That it stands when the liner fails."),
        click.option("--currency", default="", metavar="WORD", help="Of the prices, like EUR."),
    ]  # fmt: skip
    for option in reversed(options):
        command = option(command)
    return command


@wearfem.command(short_help="How long a run or the liner of a survey will last.")
@click.argument("path", type=Path)
@forecast_options
@progress_option
@exposure_option
@run_option
@click.option("--out", type=Path, metavar="FILE", help="Also write what is printed to FILE.")
@json_option
def forecast(
    path: Path,
    progress: str,
    exposure: Path | None,
    run_folder: Path | None,
    out: Path | None,
    json_file: Path | None,
    **asked: Any,
) -> None:
    """Foretell the life of a run by zone, or of a survey by point, with its interval, beside the straight line.

    PATH is the folder of a life that has run for two cycles or more, or a survey (CSV). Of a survey --limit and --next-stop are
    told, with --progress, --exposure and --run as in diagnose.
    """
    if path.suffix.lower() == ".csv":
        from wearfem.measured import forecast_survey

        forecast_survey(path, asked, progress, exposure, run_folder, out, json_file)
        return
    if beside := [
        name for name, given in (("progress", progress), ("exposure", exposure), ("run", run_folder)) if given
    ]:
        words = in_words([f"--{name}" for name in beside])
        raise UserError(
            f"{path} is taken for the folder of a run, and {words} is for surveys; give a survey that ends in .csv"
        )
    from wearfem.foretell import asked_for, forecast_run

    forecast_run(path, asked_for(**asked), out, json_file)


@wearfem.command(short_help="One page on a life, for the planner of maintenance.")
@click.argument("run", type=Path)
@click.option("--out", type=Path, metavar="FILE", help="The page to write; report.html in RUN if not given.")
@forecast_options
@json_option
def report(run: Path, out: Path | None, json_file: Path | None, **asked: Any) -> None:
    """Write one page on a life, for the planner of maintenance; it needs no network and prints well."""
    from wearfem.foretell import asked_for
    from wearfem.report_page import write_report

    write_report(run, out, json_file, asked_for(**asked))


@wearfem.command(short_help="Prove on this machine what is claimed.")
@click.argument("names", nargs=-1)
@json_option
def verify(names: tuple[str, ...], json_file: Path | None) -> int:
    """Prove on this machine what is claimed; all proofs, or those named. Exit code 1 if one fails."""
    from wearfem.verify import verify

    return 0 if verify(names, json_file) else 1


@wearfem.command(short_help="Measure the speed on this machine.")
@click.argument("names", nargs=-1)
@json_option
@click.option("--quick", is_flag=True, help="One short round; the two small benchmarks if none is named.")
def bench(names: tuple[str, ...], json_file: Path | None, quick: bool) -> None:
    """Measure the speed on this machine; all benchmarks, or those named."""
    from wearfem.bench import bench

    bench(names, json_file, quick)


@wearfem.command(short_help="The coefficient of wear from a survey.")
@survey_argument
@progress_option
@exposure_option
@run_option
@json_option
def calibrate(
    survey: Path, progress: str, exposure: Path | None, run_folder: Path | None, json_file: Path | None
) -> None:
    """The coefficient of wear from a SURVEY (CSV), with its interval."""
    from wearfem.measured import calibrate_survey

    calibrate_survey(survey, progress, exposure, run_folder, json_file)


@wearfem.command(short_help="What a survey says that the model lacks.")
@survey_argument
@progress_option
@exposure_option
@run_option
@click.option(
    "--limit",
    metavar="VALUE",
    help='What must be left of a plate, or may be lost, as in "8*mm": tell its life.',
)
@click.option("--next-stop", metavar="VALUE", help='Service until the next stop, as in "1200*kt".')
@click.option("--out", type=Path, metavar="DIR", help="A folder for report.html and the figures as JSON.")
@json_option
def diagnose(
    survey: Path,
    progress: str,
    exposure: Path | None,
    run_folder: Path | None,
    limit: str,
    next_stop: str,
    out: Path | None,
    json_file: Path | None,
) -> None:
    """Say what the model of a SURVEY (CSV) lacks, how sure that is, and what to measure next."""
    from wearfem.measured import diagnose_survey

    diagnose_survey(survey, progress, exposure, run_folder, out, json_file, limit, next_stop)


@wearfem.command(short_help="Put what it lacks into the case, and run again.")
@survey_argument
@click.option(
    "--run",
    "run_folder",
    type=Path,
    metavar="RUN",
    required=True,
    help="The run that the readings belong to.",
)
@click.option("--out", type=Path, metavar="DIR", required=True, help="A folder for the improved case.")
@progress_option
@click.option(
    "--rounds",
    type=int,
    default=6,
    show_default=True,
    metavar="N",
    help="Coupled runs at most, of each kind.",
)
@json_option
@click.option("--quiet", is_flag=True, help="Show no progress.")
def improve(
    survey: Path,
    run_folder: Path,
    out: Path,
    progress: str,
    rounds: int,
    json_file: Path | None,
    quiet: bool,
) -> None:
    """Add to the case of RUN what a SURVEY (CSV) asks for, and repeat the run until both agree.

    DIR/improved is the improved case, for wearfem run. The same command goes on with what DIR holds.
    """
    from wearfem.measured import improve_with_survey

    improve_with_survey(survey, progress, run_folder, out, rounds, json_file, quiet)


def main() -> None:
    """Run a command; a user's mistake becomes one sentence and exit code 2."""
    with in_a_sentence("wearfem"):
        try:
            status = wearfem.main(sys.argv[1:] or ["--help"], prog_name="wearfem", standalone_mode=False)
        except click.ClickException as error:
            raise UserError(f"{error.format_message().rstrip('.?')}; see wearfem --help") from error
        except click.Abort:
            raise KeyboardInterrupt from None
    sys.exit(status or 0)


if __name__ == "__main__":
    main()
