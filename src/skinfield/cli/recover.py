"""`skinfield recover`: a whole file from what a crash left."""

from pathlib import Path

import click

from skinfield.cli.report import console, plural, progress


@click.command(
    short_help="Make a whole recording of a damaged one.",
    help="""Write what can be read of BAD into a new, whole file; BAD stays as it is.

A recorder that was killed, a battery that ran out, or a full disk leave a file without its end:
most programs refuse it. Everything up to the last flush, 0.2 s before, is in it. Chunks are
copied as they are once their checksum is found right; those that are damaged are left out and
named by their byte in the file.

\b
  skinfield recover crashed.mcap -o good.mcap
""",
)
@click.argument("bad", type=click.Path(path_type=Path))
@click.option(
    "-o", "--output", required=True, type=click.Path(path_type=Path), help="The new file."
)
@click.option("--overwrite", is_flag=True, help="Replace a file of that name.")
def recover(bad: Path, output: Path, overwrite: bool) -> None:
    """Run the command."""
    from skinfield.live.recorder_recover import recover as work

    with progress() as bar:
        task = bar.add_task("recovering", total=None)
        found = work(
            bad,
            output,
            overwrite=overwrite,
            progress=lambda done, total: bar.update(task, completed=done, total=total),
        )
    out = console()
    if found.was_whole:
        out.print(f"{bad} is whole: nothing was wrong with it; {output} is a copy", highlight=False)
    counts = ", ".join(f"{count} on {topic}" for topic, count in sorted(found.messages.items()))
    seconds = (found.last_ns - found.first_ns) * 1e-9
    out.print(
        f"saved {plural(found.messages.total(), 'message')} of {seconds:.3f} s"
        + (f": {counts}" if counts else ""),
        highlight=False,
    )
    if not found.was_whole and not found.dropped_bytes and not found.damage:
        out.print(f"{bad} had no end; nothing had to be left out", highlight=False)
    if found.dropped_bytes:
        what = ", the beginning of a chunk that was never finished" if found.chunk_was_cut else ""
        out.print(
            f"dropped {found.dropped_bytes} of {found.size} bytes at the end{what}",
            highlight=False,
        )
    for damage in found.damage:
        out.print(f"byte {damage.byte}: {damage.why}", highlight=False, markup=False)
