"""A thread that helps."""

from __future__ import annotations

import gc
import threading

import pytest

from cogmap_gym.helper import Helper


def test_a_helper_does_what_it_is_told_in_a_thread_of_its_own() -> None:
    done, names = threading.Event(), list[str]()
    helper = Helper()
    helper.tell(lambda name: names.append(name + threading.current_thread().name), "in ")
    helper.tell(done.set)
    assert done.wait(10.0)
    assert len(names) == 1
    assert names != ["in " + threading.current_thread().name]
    assert helper.alive


def test_a_helper_that_is_dropped_ends() -> None:
    helper = Helper()
    thread = helper._thread
    assert thread.is_alive()
    del helper
    gc.collect()
    thread.join(10.0)
    assert not thread.is_alive()


@pytest.mark.filterwarnings("ignore::pytest.PytestUnhandledThreadExceptionWarning")
def test_a_helper_whose_work_failed_is_not_alive() -> None:
    helper = Helper()
    helper.tell(int, "no number")
    helper._thread.join(10.0)
    assert not helper.alive
