"""A manifest survives its own text."""

from dataclasses import replace

import pytest

from kousoku.model.errors import LoadError
from kousoku.model.files.manifest import ABI, MANIFEST_FORMAT, KernelManifest, Manifest
from kousoku.model.files.quantity import Quantity


@pytest.fixture
def manifest() -> Manifest:
    point = Quantity("r_i", (3,), "m", "origin of body i in frame O")
    jacobian = Quantity("C_q", (2, 12), "-", "Jacobian")
    kernel = KernelManifest(
        name="constraint",
        title="two parallel vectors",
        formula="C = ã d = 0",
        source="lecture 8.2, (8.16)",
        inputs=(point,),
        outputs=(jacobian,),
        nonzero=((0, 1, 5),),
        is_exact=True,
        operations=(("mul", 3), ("add", 2)),
    )
    return Manifest(
        package="p2_z",
        title="parallel vectors",
        regenerate="kousoku generate p2",
        version="0.1.0",
        digest="0" * 64,
        inputs=(("derivation", "2" * 16), ("templates", "3" * 16)),
        files=(("kernels.c", "1" * 64),),
        kernels=(kernel,),
    )


def test_manifest_reads_back_equal(manifest: Manifest) -> None:
    assert Manifest.from_json(manifest.to_json()) == manifest


def test_another_format_is_refused(manifest: Manifest) -> None:
    text = manifest.to_json().replace(f'"format": {MANIFEST_FORMAT}', '"format": 99')
    with pytest.raises(ValueError, match="format"):
        Manifest.from_json(text)


def test_digest_is_over_all_that_is_said_but_the_files(manifest: Manifest) -> None:
    """Files have digests of their own, and ``generate --target c`` leaves some out."""
    known = manifest.stated()
    assert replace(manifest, digest=known, files=()).stated() == known
    (kernel,) = manifest.kernels
    (jacobian,) = kernel.outputs
    turned = replace(kernel, outputs=(replace(jacobian, meaning="Jacobian, transposed"),))
    others = [
        replace(manifest, inputs=(("derivation", "4" * 16),)),
        replace(manifest, kernels=(turned,)),
    ]
    assert known not in {other.stated() for other in others}


@pytest.mark.parametrize(("there", "shown"), [('"abi": 99, ', "ABI 99"), ("", "ABI 0")])
def test_another_abi_is_refused_in_one_line(manifest: Manifest, there: str, shown: str) -> None:
    text = manifest.to_json()
    assert f'"abi": {ABI}, ' in text
    with pytest.raises(LoadError, match=f"p2_z was generated .*{shown}.*: kousoku generate p2$"):
        Manifest.from_json(text.replace(f'"abi": {ABI}, ', there))


def test_sizes_are_products_of_shapes(manifest: Manifest) -> None:
    kernel = manifest.kernels[0]
    assert kernel.inputs[0].size == 3
    assert kernel.outputs[0].size == 24
    assert Quantity("length", (), "m", "design length").size == 1
