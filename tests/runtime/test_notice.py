"""Messages to the user."""

from __future__ import annotations

import subprocess
import sys
from typing import TYPE_CHECKING

from kousoku.runtime.notice import say_once

if TYPE_CHECKING:
    import pytest


def test_a_message_is_said_once(caplog: pytest.LogCaptureFixture) -> None:
    for message in ("one", "two 100%", "one"):
        say_once(message)
    assert caplog.messages == ["one", "two 100%"]


def test_it_can_be_silenced() -> None:
    code = (
        "import logging; logging.getLogger('kousoku').setLevel('ERROR')\n"
        "from kousoku.runtime.notice import say_once; say_once('hello')"
    )
    run = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert run.stderr == ""
