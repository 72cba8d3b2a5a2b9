"""``kousoku derive``: the steps of a derivation, each with the rule that justifies it."""

from typing import Annotated, Any

import typer

from kousoku.cli.console import AsJson, print_json
from kousoku.symbolic.derivation import Derivation


def derive(
    kind: Annotated[str, typer.Argument(help="A kind by any of its names: n2, p2_x, INLINE …")],
    latex: Annotated[bool, typer.Option("--latex", help="Print LaTeX.")] = False,
    as_json: AsJson = False,
) -> None:
    """Derive a kind and print the steps, each with its rule and equation number."""
    from kousoku.symbolic import derive as derived
    from kousoku.symbolic import packages_of

    packages_of(kind)  # an unknown name is refused before SymPy is imported
    from kousoku.symbolic.printing import print_steps

    derivation = derived(kind)
    if as_json:
        print_json(_as_dict(derivation))
    else:
        typer.echo(print_steps(derivation, "latex" if latex else "text"), nl=False)


def _as_dict(derivation: Derivation) -> dict[str, Any]:
    from kousoku.symbolic.printing import show

    return {
        "name": derivation.name,
        "kind": derivation.kind,
        "title": derivation.title,
        "source": derivation.source,
        "steps": [
            {
                "left": show(step.left),
                "right": show(step.right),
                "latex": f"{show(step.left, 'latex')} = {show(step.right, 'latex')}",
                "rule": step.rule,
                "equation": step.source,
            }
            for step in derivation.steps
        ],
        "functions": [
            {
                "name": function.name,
                "formula": function.formula,
                "source": function.source,
                "inputs": [quantity.name for quantity in function.inputs],
                "outputs": [output.quantity.name for output in function.outputs],
            }
            for function in derivation.functions
        ],
    }
