"""Work that a process does once is done once, and no forked process waits for threads that it lacks."""

import os
import threading

import pytest

from physagent_jax.core.once import call_in_forked, make_lock, once
from physagent_jax.core.recent import Recent

THREADS = 12
ENOUGH = 60  # [s] for what takes no time unless somebody waits for ever
needs_fork = pytest.mark.skipif(not hasattr(os, "fork"), reason="the system has no fork")


def call_from_threads(function):
    """The results of ``function`` in `THREADS` threads that call it at the same time."""
    results, together = [], threading.Barrier(THREADS)

    def ask(number):
        together.wait()
        results.append(function(number))

    threads = [threading.Thread(target=ask, args=(number,)) for number in range(THREADS)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join(ENOUGH)
    assert not any(thread.is_alive() for thread in threads)
    return results


def run_forked(function):
    """The exit code of a forked process that calls ``function``; one that hangs fails the test."""
    child = os.fork()
    if child == 0:
        code = 1
        try:
            threading.Timer(ENOUGH, os._exit, (2,)).start()
            function()
            code = 0
        finally:
            os._exit(code)
    return os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])


def test_a_function_runs_once_for_each_argument_while_others_wait():
    """The first call goes on until all threads have asked: with `functools.cache`, each of them would run it."""
    asked, calls = threading.Semaphore(0), []

    @once
    def make(key):
        calls.append(key)
        for _ in range(THREADS):
            assert asked.acquire(timeout=ENOUGH)
        return object()

    def ask(_):
        asked.release()
        return make("a")

    made = call_from_threads(ask)
    assert calls == ["a"] and len(made) == THREADS and len(set(made)) == 1
    for _ in range(THREADS):
        asked.release()
    assert make("b") is not made[0] and calls == ["a", "b"]


def test_what_fails_is_tried_again_by_whoever_waits():
    calls = []

    @once
    def make():
        calls.append(0)
        if len(calls) == 1:
            raise OSError("not yet")
        return "made"

    def ask(_):
        try:
            return make()
        except OSError:
            return "failed"

    assert sorted(call_from_threads(ask)) == ["failed"] + ["made"] * (THREADS - 1)
    assert len(calls) == 2


def test_results_can_be_forgotten():
    values = iter("ab")
    make = once(lambda: next(values))
    assert make() == make() == "a"
    make.cache_clear()
    assert make() == "b"


@needs_fork
@pytest.mark.filterwarnings("ignore:os.fork")
def test_a_forked_process_makes_what_another_thread_was_making():
    """The thread is not there any more: whoever waited for it would do so for ever."""
    begun, go_on = threading.Event(), threading.Event()

    @once
    def make():
        if not go_on.is_set():
            begun.set()
            go_on.wait(ENOUGH)
        return "made"

    thread = threading.Thread(target=make)
    thread.start()
    assert begun.wait(ENOUGH)

    def ask_again():
        go_on.set()
        assert make() == "made"

    try:
        assert run_forked(ask_again) == 0
    finally:
        go_on.set()
        thread.join(ENOUGH)


@needs_fork
@pytest.mark.filterwarnings("ignore:os.fork")
@pytest.mark.parametrize("awaited", [False, True])
def test_a_lock_is_free_in_a_forked_process(awaited):
    """And what an awaited one guards is whole there: forking waits for the thread that has it."""
    lock, taken, whole = make_lock(awaited=awaited), threading.Event(), []

    def work():
        with lock:
            taken.set()
            if awaited:
                thread_forks.wait(ENOUGH)
            else:
                done.wait(ENOUGH)
            whole.append(True)

    thread_forks, done = threading.Event(), threading.Event()
    os.register_at_fork(before=thread_forks.set)  # called before forking waits
    thread = threading.Thread(target=work)
    thread.start()
    assert taken.wait(ENOUGH)

    def take():
        assert lock.acquire(timeout=ENOUGH)
        assert whole == ([True] if awaited else [])

    try:
        assert run_forked(take) == 0
    finally:
        done.set()
        thread.join(ENOUGH)


@needs_fork
@pytest.mark.filterwarnings("ignore:os.fork")
def test_what_a_forked_process_does_first_is_done_there_alone():
    where = []
    call_in_forked(lambda: where.append(os.getpid()))

    def look():
        assert where == [os.getpid()]

    assert run_forked(look) == 0 and not where


def test_recent_results_belong_to_the_thing_and_its_settings():
    """A thread gets what it measured, even if others measure so much meanwhile that it is not kept."""
    recent = Recent(2)
    things = [object() for _ in range(THREADS)]

    def ask(number):
        def measure():
            for other in range(5):
                recent.find(object(), other, lambda: "another's")
            return number

        return number, recent.find(things[number], "settings", measure)

    assert all(number == found for number, found in call_from_threads(ask))
    kept = recent.find(things[0], 1, lambda: "first")
    assert recent.find(things[0], 1, lambda: "again") is kept
    assert recent.find(things[0], 2, lambda: "other settings") == "other settings"
    assert recent.find(things[1], 1, lambda: "another thing") == "another thing"
    assert recent.find(things[0], 1, lambda: "forgotten") == "forgotten"
