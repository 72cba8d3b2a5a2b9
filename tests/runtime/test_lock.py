"""The lock between processes."""

from __future__ import annotations

import threading
from typing import TYPE_CHECKING

import pytest

from kousoku.runtime import lock
from kousoku.runtime.lock import locked

if TYPE_CHECKING:
    from pathlib import Path


def never() -> bool:
    return False


def test_two_holders_take_turns(tmp_path: Path) -> None:
    path, order = tmp_path / "lock", []
    inside = threading.Event()

    def second() -> None:
        inside.wait()
        with locked(path, until=never):
            order.append("second")

    thread = threading.Thread(target=second)
    thread.start()
    with locked(path, until=never):
        inside.set()
        thread.join(timeout=0.2)
        order.append("first")
    thread.join()
    assert order == ["first", "second"]


def test_who_waits_stops_waiting_when_the_work_is_done(tmp_path: Path) -> None:
    done = iter([False, False, True])
    with (
        locked(tmp_path / "lock", until=never),
        locked(tmp_path / "lock", until=lambda: next(done)),
    ):
        pass
    assert next(done, None) is None


def test_a_holder_that_hangs_is_not_waited_for(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(lock, "PATIENCE", 0.0)
    with locked(tmp_path / "lock", until=never), locked(tmp_path / "lock", until=never):
        pass


def test_a_lock_is_free_after_an_error(tmp_path: Path) -> None:
    with pytest.raises(RuntimeError, match="inside"), locked(tmp_path / "lock", until=never):
        raise RuntimeError("inside")
    with locked(tmp_path / "lock", until=never):
        pass


def test_a_lock_file_that_cannot_be_made_is_an_error(tmp_path: Path) -> None:
    with pytest.raises(OSError, match="nowhere"), locked(tmp_path / "nowhere" / "x", until=never):
        pass
