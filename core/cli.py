"""The command line: `graben check`, `repair`, `run`, `view`, `demo`, `init`, `info` and `schema`."""

from __future__ import annotations

import os
import signal
import sys
import time
import warnings
from pathlib import Path

# The same input gives the same bytes only with one thread; to be said before numpy is loaded.
for _library in ("OMP", "OPENBLAS", "MKL"):
    os.environ.setdefault(f"{_library}_NUM_THREADS", "1")

import click  # noqa: E402

from graben.ending import ended, interrupted  # noqa: E402
from graben.errors import InputError  # noqa: E402
from graben.options import Commands, common, into, profile, report_options  # noqa: E402
from graben.terminal import console, encoded, progress, put  # noqa: E402


@click.group(
    cls=Commands,
    context_settings={"help_option_names": ["-h", "--help"]},
    no_args_is_help=False,
    epilog="-v, -q and --debug may stand before the command or after it.",
)
@click.version_option(package_name="graben")
def app() -> None:
    """Check, repair and model geological faults and horizons."""


@app.command()
@click.argument("model", type=click.Path(path_type=Path))
@report_options
@profile
@click.option(
    "--fail-on",
    type=click.Choice(["fail", "warn"]),
    default="fail",
    show_default=True,
    help="What ends with 1: a check that fails, or one that warns as well.",
)
@common
@click.pass_obj
def check(
    began: float,
    /,
    model: Path,
    profile: str,
    fail_on: str,
    verbose: bool,
    quiet: bool,
    debug: bool,
    **reports: Path | None,
) -> None:
    """Check MODEL, a model.toml, and say what is wrong, where, and what to do; nothing is changed.

    A file F may be - for stdout, which then holds nothing else. Its folder is made. A file that is there
    already is replaced only where graben wrote it as such a report.

    Exit code 0: no check fails; 1: some check fails; 2: the input cannot be read or the command is wrong.
    Where the input cannot be read, the files of --json, --junit and --sarif say so as an error, and reports
    of an earlier check in the places of --html and --geojson are removed. A command that is wrong touches no
    file.
    """
    from graben.pipeline import examine
    from graben.reading import read_model
    from graben.reports.check_failed import failing_reports
    from graben.reports.check_files import STDOUT, require_targets, write_reports
    from graben.reports.check_table import check_table

    targets = {kind: target for kind, target in reports.items() if target is not None}
    require_targets(targets, model)
    plan = ("read", "check", *(("write",) if targets else ()))
    with (
        progress(plan, began, quiet=quiet, verbose=verbose) as say,
        failing_reports(targets, model, profile),
    ):
        say("read", str(model))
        read = read_model(model)
        say("check", read.name)
        examination = examine(read, profile, say)
        if targets:
            say("write", ", ".join(targets))
        piped = write_reports(examination, targets)
    if piped:
        put(piped, sys.stdout)
    if not quiet and (verbose or not piped):
        stream = sys.stderr if piped else sys.stdout
        spent = time.perf_counter() - began
        table = check_table(examination, verbose=verbose, console=console(stream), seconds=spent)
        files = [str(target) for target in targets.values() if target != STDOUT]
        told = f"{table}\nWritten: {', '.join(files)}\n" if files else f"{table}\n"
        put(encoded(told, stream), stream)
    result = examination.result
    sys.exit(0 if result.passed and not (fail_on == "warn" and result.warned) else 1)


@app.command()
@click.argument("model", type=click.Path(path_type=Path))
@into(required=True)
@profile
@click.option("--no-repair", is_flag=True, help="Model the input as it is.")
@click.option("--resume", is_flag=True, help="Go on from what a run that was broken off left in DIR.partial.")
@click.option(
    "--workers",
    type=click.IntRange(min=1),
    metavar="N",
    help="Most processes side by side; default all cores.",
)
@click.option("--scheduler", metavar="ADDRESS", help="Rebuild horizons on the cluster of a dask scheduler.")
@common
@click.pass_obj
def run(
    began: float,
    /,
    model: Path,
    output: Path,
    profile: str,
    no_repair: bool,
    resume: bool,
    workers: int | None,
    scheduler: str | None,
    verbose: bool,
    quiet: bool,
    debug: bool,
) -> None:
    """Check, repair, check, and model every horizon of MODEL, a model.toml.

    Work goes on in DIR.partial, which becomes DIR at the end. Where a run is broken off, --resume takes it
    up, if the input, the options and graben are the same, and does nothing again that is finished; without
    it such a folder is replaced.

    Exit code 0: the gate passes and every subdomain converged; 1: something is left, and the report says
    what; 2: the input cannot be read, or there is nothing to resume.
    """
    from graben.output import partial_folder, require_free, written
    from graben.resuming import KeptFolder, manifest, require_resumable

    require_free(output)
    inputs = manifest(model, profile, not no_repair)
    if resume:
        require_resumable(output, inputs)
    from graben.cluster import cluster
    from graben.memory import keep_freed
    from graben.pipeline import build
    from graben.reading import read_model
    from graben.reports.run_words import run_summary
    from graben.reports.summary import with_total
    from graben.reports.writing import write_run

    keep_freed()
    plan = ("read", "check", *(() if no_repair else ("repair",)), "model", "write")
    with progress(plan, began, quiet=quiet, verbose=verbose) as say, cluster(scheduler) as executor:
        say("read", str(model))
        read = read_model(model)
        with partial_folder(output, resume=resume) as folder:
            kept = KeptFolder(folder, inputs)
            result = build(
                read,
                profile,
                mend=not no_repair,
                progress=say,
                executor=executor,
                kept=kept,
                workers=workers,
            )
            say("write", str(output))
            with written(output):
                result = write_run(with_total(result, time.perf_counter() - began), folder, say)
    if not quiet:
        told = run_summary(result, verbose=verbose, seconds=time.perf_counter() - began)
        put(encoded(f"{told}\nreport: {output / 'report.html'}\n", sys.stdout), sys.stdout)
    sys.exit(0 if result.passed else 1)


@app.command()
@click.argument("model", type=click.Path(path_type=Path))
@into()
@click.option("--dry-run", is_flag=True, help="Print the plan and write nothing.")
@click.option("--blocks", is_flag=True, help="Add the closed fault blocks of the repaired model.")
@profile
@common
@click.pass_obj
def repair(
    began: float,
    /,
    model: Path,
    output: Path | None,
    dry_run: bool,
    blocks: bool,
    profile: str,
    verbose: bool,
    quiet: bool,
    debug: bool,
) -> None:
    """Repair what fails in MODEL, a model.toml: write the repaired model and a report; the input stays.

    Exit code 0: the repaired model passes; 1: something is left, and the report says what, where and what to
    do; 2: the input cannot be read or the command is wrong. Blocks that cannot be made change no exit code.
    """
    from graben.output import require_free, whole_folder
    from graben.reading import read_model
    from graben.repairs import repair as repaired
    from graben.reports.repair_words import repair_summary

    if output is None and not dry_run:
        raise InputError("Say where to: graben repair MODEL -o DIR; --dry-run writes nothing.")
    if output is not None:
        require_free(output)
    writes = output is not None and not dry_run
    plan = ("read", "check", "repair", *(("blocks",) if blocks else ()), *(("write",) if writes else ()))
    with progress(plan, began, quiet=quiet, verbose=verbose) as say:
        say("read", str(model))
        read = read_model(model)
        say("check", read.name)
        result = repaired(read, profile, say)
        made, said = None, ""
        if blocks:
            from graben.reports.repair_blocks import blocks_of, blocks_words

            say("blocks", result.model.name)
            made = blocks_of(result.model)
            said = blocks_words(made, result.model)
        if output is not None and writes:
            from graben.reports.repair_files import write_repair

            with whole_folder(output) as folder:
                say("write", str(output))
                write_repair(result, folder, made, began=began)
    if not quiet:
        spent = time.perf_counter() - began
        told = repair_summary(result, verbose=verbose, plan=dry_run, blocks=said, seconds=spent)
        told += "" if output is None or dry_run else f"\nreport: {output / 'report.html'}"
        put(encoded(f"{told}\n", sys.stdout), sys.stdout)
    sys.exit(0 if result.passed else 1)


@app.command()
@click.argument("folder", metavar="DIR", type=click.Path(path_type=Path))
@common
def view(folder: Path, verbose: bool, quiet: bool, debug: bool) -> None:
    """Open the report in DIR, the folder of a run or repair; without a browser its address is told."""
    from graben.viewing import opened, report_of

    address = report_of(folder).as_uri()
    shown = opened(address)
    if not quiet or not shown:
        click.echo(f"report: {address}" if shown else f"No browser opens here. The report: {address}")


@app.command()
@click.argument("name", required=False)
@into()
@click.option("--list", "listed", is_flag=True, help="Say which models there are.")
@click.option("--step", type=float, help="Grid step of the horizon, m; default 100, a replica's is fixed.")
@click.option("--noise", type=float, default=0.0, show_default=True, help="Standard deviation of noise, m.")
@click.option(
    "--seed",
    type=int,
    default=0,
    show_default=True,
    help="Of the noise; of a replica also of places, strikes, dips, throws and relief.",
)
@common
def demo(
    name: str | None,
    output: Path | None,
    listed: bool,
    step: float | None,
    noise: float,
    seed: int,
    verbose: bool,
    quiet: bool,
    debug: bool,
) -> None:
    """Write the synthetic model NAME with its known answer."""
    from graben.demo_by_name import build, names, write
    from graben.output import whole_folder

    if listed:
        for key, sentence in names().items():
            click.echo(f"{key:<12} {sentence}")
        return
    if name is None or output is None:
        raise InputError("Say which model and where: graben demo NAME -o DIR; graben demo --list names them.")
    made = build(name, step=step, noise=noise, seed=seed)
    with whole_folder(output) as folder:
        write(made, folder)
    if not quiet:
        click.echo(f"model: {output / 'model.toml'}")


@app.command()
@click.argument("files", nargs=-1, required=True, type=click.Path(path_type=Path))
@click.option(
    "-o", "--output", type=click.Path(path_type=Path), default="model.toml", show_default=True, help="File."
)
@common
def init(files: tuple[Path, ...], output: Path, verbose: bool, quiet: bool, debug: bool) -> None:
    """Write a model.toml that names the surfaces in FILES, with guesses as comments.

    Of a folder, all files that can be read are taken; folders inside it are not. Horizons are grids, points
    and flat surfaces; faults are sticks and steep surfaces. Nothing is overwritten.
    """
    from graben.drafting import draft_model

    made = draft_model(files, output)
    if not quiet:
        counts = f"horizons {len(made.of('horizon'))}, faults {len(made.of('fault'))}"
        click.echo(f"model: {output}\n{counts}, not taken {len(made.left_out)}; look at its guesses")


@app.command()
@click.argument("file", type=click.Path(path_type=Path))
@common
def info(file: Path, verbose: bool, quiet: bool, debug: bool) -> None:
    """Say what a surface FILE holds."""
    from graben.info import describe

    click.echo(str(describe(file)))


@app.command()
@common
def schema(verbose: bool, quiet: bool, debug: bool) -> None:
    """Print the JSON Schemas of model.toml, report.json and the JSON of a check."""
    import json

    from graben.schema import schemas

    click.echo(json.dumps(schemas(), indent=2))


def main(arguments: list[str] | None = None) -> None:
    """Run the command line; every error is one sentence on stderr and an exit code."""
    began = time.perf_counter()
    arguments = sys.argv[1:] if arguments is None else arguments
    signal.signal(signal.SIGINT, interrupted)
    debug = "--debug" in arguments
    if not debug:
        # Those of libraries are for programmers; graben's own stand in its results.
        warnings.simplefilter("ignore")
    ended(lambda: app.main(arguments, prog_name="graben", standalone_mode=False, obj=began), debug)


if __name__ == "__main__":
    main()
