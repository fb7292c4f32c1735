"""The command line: `graben check`, `repair`, `run`, `demo`, `init`, `info` and `schema`."""

from __future__ import annotations

import os
import signal
import sys
import traceback
import warnings
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from types import FrameType

# The same input gives the same bytes only with one thread; to be said before numpy is loaded.
for _library in ("OMP", "OPENBLAS", "MKL"):
    os.environ.setdefault(f"{_library}_NUM_THREADS", "1")

import click  # noqa: E402

from graben.errors import GrabenError, InputError, OutputError  # noqa: E402
from graben.terminal import console, encoded, progress, put  # noqa: E402

_INTERRUPTED = 130
_STDERR = 2


def _common(command: Callable[..., None]) -> Callable[..., None]:
    """Add the options that every command has."""
    for option in (
        click.option("--debug", is_flag=True, help="Show the traceback of an error."),
        click.option("-q", "--quiet", is_flag=True, help="Print errors only."),
        click.option("-v", "--verbose", is_flag=True, help="Print more."),
    ):
        command = option(command)
    return command


@click.group(context_settings={"help_option_names": ["-h", "--help"]}, no_args_is_help=False)
@click.version_option(package_name="graben")
def app() -> None:
    """Check, repair and model geological faults and horizons."""


#: The files that a check can write, by option.
_REPORTS = {
    "json": "Findings as JSON; `graben schema` prints its schema.",
    "junit": "Findings as JUnit XML, for CI.",
    "sarif": "Findings as SARIF 2.1.0, with the lines of the files.",
    "html": "Report in one HTML file, with maps.",
    "geojson": "Places of the findings as GeoJSON, for a GIS.",
}


def _report_options(command: Callable[..., None]) -> Callable[..., None]:
    """Add an option for each file that a check can write."""
    for name, meaning in reversed(_REPORTS.items()):
        kind = click.Path(path_type=Path, allow_dash=True)
        command = click.option(f"--{name}", type=kind, metavar="F", help=meaning)(command)
    return command


@app.command()
@click.argument("model", type=click.Path(path_type=Path))
@_report_options
@click.option("--profile", type=click.Choice(["paper", "extended"]), default="extended", show_default=True)
@_common
def check(model: Path, profile: str, verbose: bool, quiet: bool, debug: bool, **reports: Path | None) -> None:
    """Check MODEL, a model.toml, and say what is wrong, where, and what to do; nothing is changed.

    A file F may be - for stdout, which then holds nothing else. A file that is there already is replaced only
    where graben wrote it as such a report.

    Exit code 0: no check fails; 1: some check fails; 2: the input cannot be read or the command is wrong.
    """
    from graben.pipeline import examine
    from graben.reading import read_model
    from graben.reports.check_files import STDOUT, require_targets, write_reports
    from graben.reports.check_table import check_table

    targets = {kind: target for kind, target in reports.items() if target is not None}
    require_targets(targets, model)
    with progress(quiet) as say:
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
        table = check_table(examination, verbose=verbose, console=console(stream))
        files = [str(target) for target in targets.values() if target != STDOUT]
        told = f"{table}\nWritten: {', '.join(files)}\n" if files else f"{table}\n"
        put(encoded(told, stream), stream)
    sys.exit(0 if examination.result.passed else 1)


@app.command()
@click.argument("model", type=click.Path(path_type=Path))
@click.option(
    "-o", "--output", type=click.Path(path_type=Path), required=True, help="Folder to make: absent or empty."
)
@click.option("--profile", type=click.Choice(["paper", "extended"]), default="extended", show_default=True)
@click.option("--no-repair", is_flag=True, help="Model the input as it is.")
@click.option("--resume", is_flag=True, help="Go on from what a run that was broken off left in DIR.partial.")
@click.option(
    "--workers",
    type=click.IntRange(min=1),
    metavar="N",
    help="Most processes side by side; default all cores.",
)
@click.option("--scheduler", metavar="ADDRESS", help="Rebuild horizons on the cluster of a dask scheduler.")
@_common
def run(
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
    from graben.reports.summary import summary
    from graben.reports.writing import write_run

    keep_freed()
    with progress(quiet) as say, cluster(scheduler) as executor:
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
                write_run(result, folder)
    if not quiet:
        click.echo(summary(result, verbose=verbose))
        click.echo(f"report: {output / 'report.html'}")
    sys.exit(0 if result.passed else 1)


@app.command()
@click.argument("model", type=click.Path(path_type=Path))
@click.option("-o", "--output", type=click.Path(path_type=Path), help="Folder to make: absent or empty.")
@click.option("--dry-run", is_flag=True, help="Print the plan and write nothing.")
@click.option("--blocks", is_flag=True, help="Add the closed fault blocks of the repaired model.")
@click.option("--profile", type=click.Choice(["paper", "extended"]), default="extended", show_default=True)
@_common
def repair(
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
    with progress(quiet) as say:
        say("read", str(model))
        result = repaired(read_model(model), profile, say)
        made, said = None, ""
        if blocks:
            from graben.reports.repair_blocks import blocks_of, blocks_words

            say("blocks", result.model.name)
            made = blocks_of(result.model)
            said = blocks_words(made, result.model)
        if output is not None and not dry_run:
            from graben.reports.repair_files import write_repair

            with whole_folder(output) as folder:
                say("write", str(output))
                write_repair(result, folder, made)
    if not quiet:
        told = repair_summary(result, verbose=verbose, plan=dry_run, blocks=said)
        told += "" if output is None or dry_run else f"\nreport: {output / 'report.html'}"
        put(encoded(f"{told}\n", sys.stdout), sys.stdout)
    sys.exit(0 if result.passed else 1)


@app.command()
@click.argument("name", required=False)
@click.option("-o", "--output", type=click.Path(path_type=Path), help="Folder to make: absent or empty.")
@click.option("--list", "listed", is_flag=True, help="Say which models there are.")
@click.option("--step", type=float, default=100.0, show_default=True, help="Grid step of the horizon, m.")
@click.option("--noise", type=float, default=0.0, show_default=True, help="Standard deviation of noise, m.")
@click.option("--seed", type=int, default=0, show_default=True, help="Of the noise.")
@_common
def demo(
    name: str | None,
    output: Path | None,
    listed: bool,
    step: float,
    noise: float,
    seed: int,
    verbose: bool,
    quiet: bool,
    debug: bool,
) -> None:
    """Write the synthetic model NAME with its known answer."""
    from graben.demo import build, names, write
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
@_common
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
@_common
def info(file: Path, verbose: bool, quiet: bool, debug: bool) -> None:
    """Say what a surface FILE holds."""
    from graben.info import describe

    click.echo(str(describe(file)))


@app.command()
@_common
def schema(verbose: bool, quiet: bool, debug: bool) -> None:
    """Print the JSON Schemas of model.toml, report.json and the JSON of a check."""
    import json

    from graben.schema import schemas

    click.echo(json.dumps(schemas(), indent=2))


def main(arguments: list[str] | None = None) -> None:
    """Run the command line; every error is one sentence on stderr and an exit code."""
    arguments = sys.argv[1:] if arguments is None else arguments
    signal.signal(signal.SIGINT, _interrupted)
    if "--debug" not in arguments:
        # Those of libraries are for programmers; graben's own stand in its results.
        warnings.simplefilter("ignore")
    try:
        sys.exit(app.main(arguments, prog_name="graben", standalone_mode=False) or 0)
    except click.ClickException as error:
        _fail(error.format_message(), 2)
    except (GrabenError, OutputError) as error:
        _fail(str(error), 2, "--debug" in arguments)
    except (OSError, MemoryError) as error:
        _fail(f"{type(error).__name__}: {error}", 2, "--debug" in arguments)
    except Exception as error:
        text = f"graben met an error of its own ({type(error).__name__}: {error}); --debug shows where."
        _fail(text, 2, "--debug" in arguments)


def _interrupted(number: int, frame: FrameType | None) -> None:
    """End at once: an exception raised inside a compiled library could crash instead."""
    # Only a module that is loaded can have opened a folder; to import it here could meet it half loaded.
    drop_partial = getattr(sys.modules.get("graben.output"), "drop_partial", None)
    left = drop_partial is not None and drop_partial()
    said = b"; --resume goes on from what is finished" if left else b""
    with suppress(OSError):
        os.write(_STDERR, b"graben: interrupted" + said + b".\n")
    os._exit(_INTERRUPTED)


def _fail(sentence: str, code: int, show_traceback: bool = False) -> None:
    if show_traceback:
        traceback.print_exc()
    click.echo("graben: " + " ".join(sentence.split()), err=True)
    sys.exit(code)


if __name__ == "__main__":
    main()
