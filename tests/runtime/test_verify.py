"""Verifying: what is right passes, and everything that can be wrong is caught and named."""

from __future__ import annotations

import shutil
import sys
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
import pytest

from kousoku.codegen import emit as emission
from kousoku.codegen.generate import generate_kind, write_tree
from kousoku.model.errors import VerifyError
from kousoku.model.files.manifest import Manifest
from kousoku.runtime import evaluate as evaluation
from kousoku.runtime import load, verify
from kousoku.runtime.reference import Reference, read_references
from kousoku.runtime.report import LIMIT
from kousoku.runtime.sources import read_files
from tests.runtime.conftest import SAID, unlist, write_tiny

if TYPE_CHECKING:
    from collections.abc import Callable

pytestmark = pytest.mark.usefixtures("warm_cache")

ALL_WAYS = {"C", "C batch", "C lanes", "NumPy", "NumPy batch"}
TARGETS: tuple[Literal["c", "numpy"], ...] = ("c", "numpy")
KINDS = sorted(path.parent for path in (Path(__file__).parents[2] / "generated").glob("kinds/*/m*"))
#: Kinds that are compiled with all other tests, and every one for a release: one with few
#: operations, with angles, with quotients and roots, and with a matrix.
ALWAYS = ("n1", "link", "spring_damper", "rigid_body")


def ways(report: Any) -> set[str]:
    return {row.way for row in report.rows}


@pytest.mark.usefixtures("compiler")
def test_a_right_package_is_verified_in_every_way(tiny: Path) -> None:
    report = verify(tiny)
    assert report.ok
    assert report.problems == report.notes == ()
    assert ways(report) == ALL_WAYS
    assert len(report.rows) == 10
    report.check()
    assert report.worst is not None
    assert 0.0 < report.worst.worst < 1.0


@pytest.mark.usefixtures("compiler")
@pytest.mark.parametrize("target", ["c", "numpy"])
def test_one_target_can_be_verified(
    tiny: Path, target: Literal["c", "numpy"], backend_compiler: None
) -> None:
    report = verify(tiny, target=target)
    assert report.ok, backend_compiler
    assert ways(report) == {way for way in ALL_WAYS if way.startswith("C") == (target == "c")}


@pytest.fixture
def backend_compiler(request: pytest.FixtureRequest) -> None:
    """Skip the target C where there is no compiler."""
    if request.node.callspec.params["target"] == "c":
        request.getfixturevalue("compiler")


@pytest.mark.usefixtures("compiler")
def test_a_loaded_library_can_be_verified(tiny: Path) -> None:
    assert ways(verify(load(tiny))) == ALL_WAYS
    assert ways(verify(load(tiny, target="numpy"), target="numpy")) == {"NumPy", "NumPy batch"}


def test_without_a_compiler_numpy_is_verified_and_the_rest_noted(
    tiny: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("KOUSOKU_CC", "none")
    report = verify(tiny)
    assert report.ok
    assert ways(report) == {"NumPy", "NumPy batch"}
    assert report.notes == ("C is not checked: KOUSOKU_CC=none switches the C compiler off",)
    assert not verify(tiny, target="c").ok


@pytest.mark.usefixtures("compiler")
@pytest.mark.parametrize(
    ("file", "old", "new", "wrong"),
    [
        ("kernels.c", "r[0] + r[1] * r[1]", "r[0] - r[1] * r[1]", {"C", "C batch", "C lanes"}),
        ("kernels.c", "C_q[2] = t0", "C_q[2] = -t0", {"C", "C batch", "C lanes"}),
        ("kernels.c", "C_q[0] = t0", "C_q[0] = (C ? t0 : -t0)", {"C", "C batch", "C lanes"}),
        ("kernels.c", "C_q[3] = 0.0", "C_q[3] = 1e-300", {"C", "C batch", "C lanes"}),
        ("kernels.c", "length[0] + length[0]", "2.000000000000003 * length[0]", ...),
        ("kernels_batch.c", "k * stride[1]", "k * stride[0]", {"C batch"}),
        ("kernels_batch.c", "4 * k : NULL", "3 * k : NULL", {"C batch"}),
        ("kernels_batch.c", "(3 * b + k) * LANES", "(k) * LANES", {"C lanes"}),
        ("kernels.py", "x * x + y", "x * x - y", {"NumPy", "NumPy batch"}),
        ("kernels.py", "0, 3] = 0.0", "0, 3] = np.nan", {"NumPy", "NumPy batch"}),
        ("kernels.py", "t0 * component", "t0 * abs(component)", {"NumPy", "NumPy batch"}),
    ],
)
def test_a_wrong_number_is_caught_where_it_comes_from(
    tmp_path: Path, file: str, old: str, new: str, wrong: Any
) -> None:
    def edit(name: str, text: str) -> str:
        assert name != file or old in text
        return text.replace(old, new) if name == file else text

    report = verify(write_tiny(tmp_path / "wrong", edit=edit))
    assert not report.ok
    expected = {"C", "C batch", "C lanes"} if wrong is ... else wrong
    assert {row.way for row in report.rows if not row.ok} == expected
    with pytest.raises(VerifyError, match="tiny: sphere: "):
        report.check()


@pytest.mark.usefixtures("compiler")
def test_the_message_says_where_the_worst_error_is(tmp_path: Path) -> None:
    report = verify(
        write_tiny(tmp_path / "a", edit=lambda _, text: text.replace("t0 * r[1]", "-t0 * r[1]"))
    )
    problem = next(text for text in report.problems if " by C is " in text)
    assert problem.startswith("sphere: C_q[0, 1] by C is ")
    assert "units off (limit 4): got 7.819999999999999, wanted -7.819999999999999" in problem
    assert ", at point 0 (ordinary): " in problem
    assert "r=[0.1, -1.7, 0.3], length=2.3" in problem


@pytest.mark.usefixtures("compiler")
def test_other_bits_in_c_and_numpy_are_caught_within_the_limit(tmp_path: Path) -> None:
    """Another order of the operations is as accurate, but not the same."""
    old = "length[0] * (r[0] * r[0] + r[1] * r[1] + r[2] * r[2])"
    new = "length[0] * r[0] * r[0] + length[0] * r[1] * r[1] + length[0] * r[2] * r[2]"
    report = verify(write_tiny(tmp_path / "other", edit=lambda _, text: text.replace(old, new)))
    assert all(row.ok for row in report.rows)
    assert not report.ok
    assert "sphere: C element 0 has other bits by NumPy (0x1" in report.problems[0]
    assert "other compiler flags" in report.problems[0]


@pytest.mark.usefixtures("compiler")
def test_a_negative_zero_is_not_a_zero_but_any_nan_is_a_nan(tmp_path: Path) -> None:
    zero = write_tiny(tmp_path / "zero", edit=lambda n, t: t.replace("] = 0.0;", "] = -0.0;"))
    assert "C_q element 3 has other bits" in verify(zero).problems[0]
    nan = write_tiny(
        tmp_path / "nan", edit=lambda n, t: t.replace("= length + length", "= -(-length - length)")
    )
    assert verify(nan).ok


@pytest.mark.parametrize("name", ["kernels.c", "kernels.py", "kernels.h"])
def test_an_edited_file_is_named(tiny: Path, name: str) -> None:
    with (tiny / name).open("a", encoding="utf-8") as file:
        file.write(" ")
    report = verify(tiny)
    assert not report.ok
    assert f"{tiny / name} was edited" in report.problems[0]


@pytest.mark.usefixtures("compiler", "cache")
def test_a_truncated_library_is_named_once_and_built_again(tiny: Path) -> None:
    path = load(tiny).path
    assert path is not None
    half = path.read_bytes()[: path.stat().st_size // 2]
    path.unlink()  # this process has the file open, and may keep it
    path.write_bytes(half)
    report = verify(tiny)
    assert not report.ok
    assert report.problems == (
        f"{path} does not match its SHA-256: it was truncated or replaced; it was built again",
    )
    assert all(row.ok for row in report.rows)
    assert verify(tiny).ok


@pytest.mark.usefixtures("compiler", "cache")
def test_a_library_without_batches_is_named(tmp_path: Path) -> None:
    unlist(write_tiny(tmp_path / "tiny"), "kernels_batch.c")
    report = verify(tmp_path / "tiny")
    assert not report.ok
    assert "is not the library of the package 'tiny'" in report.problems[0]
    assert "_batch" in report.problems[0]


@pytest.mark.usefixtures("compiler", "cache")
def test_a_foreign_library_is_named(tiny: Path, tmp_path: Path) -> None:
    place = load(tiny).path
    other = replace(SAID, inputs=(("derivation", "0" * 16),))
    foreign = load(write_tiny(tmp_path / "b", said=other)).path
    assert place is not None
    assert foreign is not None
    shutil.rmtree(place.parent)
    shutil.copytree(foreign.parent, place.parent)
    report = verify(tiny)
    assert not report.ok
    assert (
        f"is not the library of the package 'tiny': it exports the digest {other.stated()}"
        in report.problems[0]
    )
    assert ways(report) == {"NumPy", "NumPy batch"}


@pytest.mark.usefixtures("compiler")
@pytest.mark.parametrize("flag", ["-ffast-math", "-Ofast"])
def test_a_build_with_fast_math_is_named(
    tiny: Path, monkeypatch: pytest.MonkeyPatch, flag: str
) -> None:
    monkeypatch.setenv("KOUSOKU_CFLAGS", flag)
    report = verify(tiny)
    assert not report.ok
    assert "must not be compiled with -ffast-math" in report.problems[0]
    assert flag in report.problems[0]


@pytest.mark.usefixtures("cache")
def test_the_compilers_refusal_is_shown_whole(
    tiny: Path, monkeypatch: pytest.MonkeyPatch, wrapper: Callable[[str], str]
) -> None:
    code = 'for a in "$@"; do [ "$a" = kernels.c ] && { echo one; echo two >&2; exit 1; }; done'
    monkeypatch.setenv("KOUSOKU_CC", wrapper(code))
    assert "it said:\none\ntwo\n" in verify(tiny).problems[0]


def test_a_package_without_reference_values_is_not_verified(tiny: Path) -> None:
    manifest = tiny / "manifest.json"
    found = Manifest.from_json(manifest.read_text(encoding="utf-8"))
    files = tuple(entry for entry in found.files if entry[0] != "reference.json.gz")
    manifest.write_text(replace(found, files=files).to_json(), encoding="utf-8")
    report = verify(tiny)
    assert not report.ok
    assert "lists no reference.json.gz: nothing to verify" in report.problems[0]


def test_what_is_known_to_be_off_has_a_row_and_a_limit_of_its_own(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    folder = next(folder for folder in KINDS if folder.name == "n1")
    report = verify(folder, target="numpy")
    known = [row for row in report.rows if row.limit > LIMIT]
    assert {(row.output, row.label) for row in known} == {("gamma", "known to be off")}
    assert all(LIMIT < row.worst <= row.limit for row in known)
    assert report.worst is not None
    assert report.worst.limit == LIMIT

    def stricter(*args: Any) -> dict[str, Reference]:
        found = read_references(*args)
        limits = tuple({k: x - 1 for k, x in known.items()} for known in found["rates"].limits)
        return found | {"rates": replace(found["rates"], limits=limits)}

    monkeypatch.setattr(sys.modules["kousoku.runtime.verify"], "read_references", stricter)
    report = verify(folder, target="numpy")
    assert not report.ok
    assert "gamma[0] by NumPy is 117.625 units off (limit 116.63)" in report.problems[0]


def test_a_manifest_that_knows_of_other_errors_is_refused() -> None:
    folder = next(folder for folder in KINDS if folder.name == "n1")
    manifest = Manifest.from_json((folder / "manifest.json").read_text(encoding="utf-8"))
    kernels = tuple(replace(kernel, known=()) for kernel in manifest.kernels)
    files = read_files(folder, manifest)
    with pytest.raises(VerifyError, match="rates: known errors"):
        read_references(folder, replace(manifest, kernels=kernels), files)


@pytest.mark.parametrize("folder", KINDS, ids=lambda folder: str(folder.name))
def test_committed_numpy_kernels_are_verified(folder: Path) -> None:
    report = verify(folder, target="numpy")
    assert report.ok, str(report)


@pytest.mark.usefixtures("shipped_flags")
@pytest.mark.usefixtures("compiler")
@pytest.mark.parametrize(
    "folder",
    [x if x.name in ALWAYS else pytest.param(x, marks=pytest.mark.release) for x in KINDS],
    ids=lambda folder: str(folder.name),
)
def test_each_output_alone_has_the_bits_that_it_has_beside_the_others(folder: Path) -> None:
    for target in TARGETS:
        library = load(folder, target=target)
        references = read_references(folder, library.manifest, read_files(folder, library.manifest))
        for name, kernel in library.kernels.items():
            for way in evaluation.ways(target):
                found = list(evaluation.evaluate(kernel, references[name], way))
                together = {one.output: one.values for one in found if not one.is_alone}
                for one in found:
                    a, b = one.values, together[one.output]
                    same = (a.view(np.int64) == b.view(np.int64)) | (np.isnan(a) & np.isnan(b))
                    assert same.all(), (name, one.output, way)


@pytest.mark.usefixtures("shipped_flags")
@pytest.mark.usefixtures("compiler")
@pytest.mark.parametrize(
    "folder",
    [x if x.name in ALWAYS else pytest.param(x, marks=pytest.mark.release) for x in KINDS],
    ids=lambda folder: str(folder.name),
)
def test_committed_kernels_are_verified_in_every_way(folder: Path) -> None:
    report = verify(folder)
    assert report.ok, str(report)
    assert ways(report) == ALL_WAYS


@pytest.mark.usefixtures("compiler")
@pytest.mark.parametrize(
    ("template", "old", "new", "wrong"),
    [
        ("c/_lines.jinja", "{{ line.text }};", "-({{ line.text }});", "C"),
        ("numpy/_body.jinja", "= {{ line.text }}", "= -({{ line.text }})", "NumPy"),
    ],
)
def test_a_flipped_sign_in_a_template_is_caught(
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    template: str,
    old: str,
    new: str,
    wrong: str,
) -> None:
    """The digests agree with the text in that case; only the reference values do not."""
    source = emission._TEMPLATES.get_source

    def flipped(environment: Any, name: str) -> Any:
        text, path, is_current = source(environment, name)
        assert name != template or old in text
        return (text.replace(old, new) if name == template else text), path, is_current

    right = generate_kind("norm")
    monkeypatch.setattr(emission._TEMPLATES, "get_source", flipped)
    monkeypatch.setattr(emission, "environment", emission.environment.__wrapped__)  # parses anew
    tree = generate_kind("norm")
    assert tree["reference.json.gz"] == right["reference.json.gz"]
    write_tree(tmp_path / "norm", tree)
    report = verify(tmp_path / "norm")
    assert not report.ok
    assert {row.way.split()[0] for row in report.rows if not row.ok} == {wrong}


def test_errors_are_told_in_units() -> None:
    from kousoku.runtime.reference import Expected

    expected = Expected(
        high=np.array([[1.0, 0.0, np.nan, 1e300, 5e-324]]),
        low=np.array([[1e-17, 0.0, 0.0, 0.0, 0.0]]),
        unit=np.array([[1e-16, 0.0, 5e-324, 1e284, 5e-324]]),
    )

    def errors(*values: float) -> list[float]:
        result: list[float] = expected.errors(np.array([values]))[0].tolist()
        return result

    assert errors(1.0, 0.0, np.nan, 1e300, 5e-324) == [0.1, 0.0, 0.0, 0.0, 0.0]
    assert errors(1.0, -0.0, np.inf, -1e300, 1e-323)[1:] == [0.0, 0.0, pytest.approx(2e16), 1.0]
    assert errors(np.nan, 5e-324, 1.0, np.inf, np.nan) == [np.inf] * 5
    assert expected.errors(np.ones((3, 5))).shape == (3, 5)
