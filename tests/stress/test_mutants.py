"""Mutants of the stress suite: what no mistake is made in, and what is answered of those made."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests import mutants
from tests.stress.kit import ROOT
from tests.stress.mutants import SORTS, title_of
from tests.stress.mutants_answered import ANSWERED

#: What they look at is no part of kousoku.
pytestmark = pytest.mark.release

#: A comment of C that a template begins, and another one goes on with and ends.
MARGIN = """{# 1 * 2 #}
/* what 3 * 4 is */
{% block order %}
 *
 * inputs, 5 - 1 of them
 *     {{ nodes | join(", ") | wordwrap(92) }}
 */
{%- endblock %}
const double six = a * b;
"""


def test_no_mistake_is_made_in_a_comment(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(mutants, "ROOT", tmp_path)
    (tmp_path / "solver.h.jinja").write_text(MARGIN, encoding="utf-8")
    made = [*mutants.mutants_of(Path("solver.h.jinja"))]
    assert [(one.line, one.old, one.new) for one in made] == [(9, " * ", " / ")]


def test_each_answer_is_of_a_mistake_that_is_made() -> None:
    titles = {
        title_of(mutant)
        for sort in SORTS
        for path in sort.files()
        for mutant in mutants.candidates_of(path)
    }
    assert not [one for one in ANSWERED if not any(title.startswith(one) for title in titles)]


def test_each_sort_of_sources_has_files_and_tests() -> None:
    for sort in SORTS:
        assert sort.files(), sort.name
        assert all((ROOT / tests).is_dir() for tests in sort.tested), sort.name
