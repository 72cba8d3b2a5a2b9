"""``kousoku ledger``: every equation of the documents, its verdict, and the proof."""

from collections.abc import Sequence
from typing import TYPE_CHECKING, Annotated

import typer

from kousoku.cli.console import DISAGREEMENT, AsJson, print_json, print_table, progress
from kousoku.model.errors import LedgerError

if TYPE_CHECKING:
    from kousoku.ledger.entry import Entry
    from kousoku.ledger.proof import Proof


def ledger(
    key: Annotated[
        str, typer.Argument(help="An equation by its number or slug: 8.11, 15; all when left out.")
    ] = "",
    latex: Annotated[bool, typer.Option("--latex", help="Print a LaTeX document.")] = False,
    markdown: Annotated[bool, typer.Option("--markdown", help="Print a Markdown page.")] = False,
    as_json: AsJson = False,
) -> None:
    """List the documents' equations and what is true of each, or prove one of them, or all.

    The table runs no proof. With a key or an option the proofs run now; one that fails is named,
    and the exit code is 1.
    """
    from kousoku.ledger import entries, find

    chosen = [find(key)] if key else list(entries())
    if not (key or latex or markdown or as_json):
        _print_all(chosen)
        return
    proofs, failures = _prove(chosen)
    if as_json:
        from kousoku.ledger.printing import as_data

        print_json({"entries": [as_data(entry, proofs.get(entry.equation)) for entry in chosen]})
    elif latex or markdown:
        from kousoku.ledger.page import latex_page, markdown_page

        typer.echo((latex_page if latex else markdown_page)(chosen, proofs), nl=False)
    else:
        from kousoku.ledger.printing import as_text

        typer.echo(as_text(chosen[0], proofs.get(chosen[0].equation)))
    for failure in failures:
        typer.echo(f"kousoku: {failure}", err=True)
    if failures:
        raise typer.Exit(DISAGREEMENT)


def _print_all(entries: Sequence["Entry"]) -> None:
    from kousoku.ledger.printing import COLUMNS, count_lines, row

    print_table(COLUMNS, [row(entry) for entry in entries])
    typer.echo()
    for line in count_lines(entries):
        typer.echo(line)


def _prove(entries: Sequence["Entry"]) -> tuple[dict[str, "Proof"], list[str]]:
    """Run the proofs of entries; return them by key, and the messages of those that failed."""
    from kousoku.ledger import prove

    proofs, failures = {}, []
    with progress() as bar:
        for entry in bar.track(entries, description="prove"):
            try:
                proofs[entry.equation] = prove(entry)
            except LedgerError as error:
                failures.append(str(error))
    return proofs, failures
