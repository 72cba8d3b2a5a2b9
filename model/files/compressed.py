"""Files of a generated folder that are kept compressed, such as the reference values.

Manifests and comparisons of folders use the decompressed content: the compressed bytes depend on
the version of zlib.
"""

from __future__ import annotations

import zlib

#: Suffix of the name of a compressed file.
ENDING = ".gz"
#: The format of gzip, without a date, for :mod:`zlib`.
_GZIP = 31


def stored(name: str, text: str) -> bytes:
    """Bytes of a file: its text, compressed where its name ends in ``.gz``."""
    data = text.encode()
    return zlib.compress(data, 9, _GZIP) if name.endswith(ENDING) else data


def content(name: str, data: bytes) -> bytes:
    """Content of a file, given its bytes.

    Raises
    ------
    ValueError
        Its name ends in ``.gz``, and it cannot be decompressed.
    """
    if not name.endswith(ENDING):
        return data
    stream = zlib.decompressobj(_GZIP)
    try:
        decompressed = stream.decompress(data)
    except zlib.error as error:
        raise ValueError(f"{name} cannot be decompressed: {error}") from error
    if not stream.eof or stream.unused_data:
        problem = "something follows its end" if stream.eof else "it is cut off"
        raise ValueError(f"{name} cannot be decompressed: {problem}")
    return decompressed
