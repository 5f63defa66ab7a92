"""Kernels run by several of XLA's own threads.

The thread that XLA gives a call to asks XLA's pool for helpers, and all of them run the kernel's one function, with
loops whose iterations they share (`share_loop`): what OpenMP calls a team, and worksharing loops with a barrier at
the end. Threads of our own would have to be woken, for 20 to 50 us, while XLA's own are mostly still awake; and there
would be more of them than cores.

XLA promises neither when a helper begins nor that it does. So nobody waits for one that has not: an iteration is
waited for only once somebody has taken it, and a helper that comes too late finds the team closed. Whoever waits
long sleeps (`words`), and where other programs run so that helpers cost more than they bring, none are asked
(`account`).

A core begins with its own part of each loop, the same one in every call, and then takes what others have left of
theirs: what a kernel wrote is mostly still in the cache of the core that reads it in the next one.
"""

# pyright: reportCallIssue=false, reportGeneralTypeIssues=false, reportPrivateImportUsage=false, reportAttributeAccessIssue=false

from __future__ import annotations

import sys

from llvmlite import ir
from numba import njit, types
from numba.core import cgutils
from numba.extending import intrinsic

from physagent_jax.kernels import account, ffi
from physagent_jax.kernels.numbers import BODY, INLINE, OPTIONS, split_range
from physagent_jax.kernels.words import (
    add_word,
    pause,
    read_clock,
    read_own_clock,
    read_shared,
    sleep_while,
    wake_all,
)

_WORD, _BYTE = ir.IntType(64), ir.IntType(8)

# A team is a block of memory of which these are the words. What different threads write lies in lines of its own.
# Kernels get the address of a seat, which says where the block is: the leader's, which lies first, or the helpers'.
_LINE = 8  # words
_LEADS, _HELPS = 0, 1
_FRAME, _SIZE, _REFERENCES, _WAITED = 2, 3, 4, 5  # the last: by the leader [ns]
_INSIDE, _ASLEEP = _LINE, _LINE + 1  # threads that may look at operands, and those that may have to be woken
_DONE = 2 * _LINE  # a line for each loop: iterations that are done
_MOST_LOOPS = 3
_TAKEN = _DONE + _MOST_LOOPS * _LINE  # a line for each part of each loop: iterations that somebody has begun
_CLOSED = 1 << 32  # added to the number of threads inside
_PATIENCE = 400  # looks at a word before a thread goes to sleep: as long as it takes to wake it


@njit(**BODY)
def run_in_team(frame, number, kernel):
    """Handle a call: ``kernel(frame, number, team)`` by as many threads as the call's attribute says.

    Args:
        frame: The call's frame.
        number: Passed on: a NumPy class.
        kernel: Compiled by Numba; decodes operands and results, and does its work in up to three `share_loop`.

    Returns:
        0, for success.
    """
    if ffi.answer_query(frame):
        return 0
    team = _make_team(frame, ffi.get_attribute(frame, 0))
    helpers = 0 if account.is_resting() else team_size(team) - 1
    for _ in range(helpers):
        add_word(team, _REFERENCES, 1)
        if not _schedule(frame, team, number, kernel):
            _release(team)
    kernel(frame, number, team)
    add_word(team, _INSIDE, _CLOSED - 1)
    # Helpers have nothing left to do, but may still look at the operands.
    _wait_until(team, _INSIDE, _CLOSED, False)
    if helpers > 0:
        account.note_wait(ffi.read_word(team, _WAITED))
    _release(team)
    return 0


@njit(**OPTIONS)
def _make_team(frame, size):
    """A team of its leader alone."""
    team = _allocate(_TAKEN + _MOST_LOOPS * size * _LINE)
    ffi.write_word(team, _LEADS, team)
    ffi.write_word(team, _HELPS, team)
    ffi.write_word(team, _FRAME, frame)
    ffi.write_word(team, _SIZE, size)
    ffi.write_word(team, _REFERENCES, 1)
    ffi.write_word(team, _INSIDE, 1)
    return team


@njit(**INLINE)
def team_size(seat):
    """The largest number of threads in the team."""
    return ffi.read_word(ffi.read_word(seat, 0), _SIZE)


@njit(**OPTIONS)
def share_loop(seat, loop, count):
    """Those of 0..``count`` - 1 that fall to this thread; goes on when all of them are done, by whomever.

    Between two loops, and after the last one, a kernel must not look at what operands and results hold: by then the
    call may be over, for a helper that slept.

    Args:
        seat: The team, as a kernel gets it.
        loop: Number of the loop within the kernel, from 0.
        count: Iterations. Each is done once; the caller must not leave the loop within one.
    """
    team = ffi.read_word(seat, 0)
    parts, core, done = team_size(seat), _find_core(), _DONE + loop * _LINE
    for turn in range(parts):
        part = (core + turn) % parts
        taken = _TAKEN + (loop * parts + part) * _LINE
        first, last = split_range(count, part, parts)
        i = first + add_word(team, taken, 1)
        while i < last:
            yield i
            if add_word(team, done, 1) == count - 1:
                _wake_sleepers(team, done)
            i = first + add_word(team, taken, 1)
    _wait_until(seat, done, count, True)


@njit(**OPTIONS)
def _wait_until(seat, index, value, at_least):
    """Return when a word of the team is ``value``, or more if ``at_least``."""
    team = ffi.read_word(seat, 0)
    if not _is_reached(team, index, value, at_least):
        begun = read_clock()
        looks = 0
        while looks < _PATIENCE and not _is_reached(team, index, value, at_least):
            looks += 1
            pause()
        if looks == _PATIENCE:
            _sleep_until(seat, team, index, value, at_least)
        if seat == team:
            ffi.write_word(team, _WAITED, ffi.read_word(team, _WAITED) + read_clock() - begun)


@njit(**OPTIONS)
def _sleep_until(seat, team, index, value, at_least):
    """`_wait_until`, asleep. A helper is not inside meanwhile: the call may end without it."""
    if seat != team:
        _leave(team)
    add_word(team, _ASLEEP, 1)
    while not _is_reached(team, index, value, at_least):
        word = read_shared(team, index)
        if (word < value) if at_least else (word != value):
            sleep_while(team, index, word)
    add_word(team, _ASLEEP, -1)
    if seat != team:
        add_word(team, _INSIDE, 1)


@njit(**INLINE)
def _is_reached(team, index, value, at_least):
    word = read_shared(team, index)
    return (word >= value) if at_least else (word == value)


@njit(**INLINE)
def _wake_sleepers(team, index):
    """Wakes those who wait for what a word is now."""
    if read_shared(team, _ASLEEP) > 0:
        wake_all(team, index)


@njit(**OPTIONS)
def _leave(team):
    """Count a helper out; the last one wakes the leader, which waits for that."""
    if add_word(team, _INSIDE, -1) == _CLOSED + 1:
        _wake_sleepers(team, _INSIDE)


@njit(**OPTIONS)
def _help(team, number, kernel):
    """Do a helper's part."""
    if add_word(team, _INSIDE, 1) < _CLOSED:
        begun = read_own_clock()
        kernel(ffi.read_word(team, _FRAME), number, team + 8 * _HELPS)
        account.note_work(read_own_clock() - begun)
    _leave(team)
    _release(team)


@njit(**OPTIONS)
def _release(team):
    """The last one who knows of a team frees it."""
    if add_word(team, _REFERENCES, -1) == 1:
        _free(team)


@intrinsic
def _schedule(typing, frame, team, number, kernel):
    """Ask XLA's pool for a helper; whether it has taken the task."""
    task = typing.resolve_value_type(_help)
    signature = task.get_call_type(typing, (types.int64, number, kernel), {})

    def generate(context, builder, call, arguments):
        made = _help.overloads[signature.args]
        context.add_linking_libs([made.library])
        function = ir.Function(
            builder.module,
            ir.FunctionType(ir.VoidType(), [_WORD]),
            name=builder.module.get_unique_name(f"{builder.function.name}_task"),
        )
        function.linkage = "internal"
        body = ir.IRBuilder(function.append_basic_block())
        passed = [function.args[0], context.get_dummy_value(), context.get_dummy_value()]
        context.call_internal_no_propagate(body, made.fndesc, signature, passed)
        body.ret_void()

        frame, team = arguments[:2]
        api = ffi.load_word(builder, frame, ffi.FRAME_API)
        words = [_WORD(40), _WORD(0), ffi.load_word(builder, frame, ffi.FRAME_CONTEXT)]
        words += [builder.ptrtoint(function, _WORD), team]
        error, _ = ffi.call_api(builder, api, ffi.SCHEDULE_TASK, words)
        failed = builder.icmp_unsigned("!=", error, _WORD(0))
        with builder.if_then(failed, likely=False):
            ffi.call_api(builder, api, ffi.DESTROY_ERROR, [_WORD(24), _WORD(0), error])
        return builder.not_(failed)

    return types.boolean(frame, team, number, kernel), generate


@intrinsic
def _allocate(typing, words):
    """A team's block, all zero."""

    def generate(context, builder, signature, arguments):
        kind = ir.FunctionType(_BYTE.as_pointer(), [_WORD, _WORD])
        function = cgutils.get_or_insert_function(builder.module, kind, "calloc")
        return builder.ptrtoint(builder.call(function, [arguments[0], _WORD(8)]), _WORD)

    return types.int64(types.int64), generate


@intrinsic
def _free(typing, team):
    def generate(context, builder, signature, arguments):
        kind = ir.FunctionType(ir.VoidType(), [_BYTE.as_pointer()])
        function = cgutils.get_or_insert_function(builder.module, kind, "free")
        builder.call(function, [builder.inttoptr(arguments[0], _BYTE.as_pointer())])
        return context.get_dummy_value()

    return types.void(types.int64), generate


@intrinsic
def _find_core(typing):
    """The number of the core on which this thread is; 0 where the system does not tell."""

    def generate(context, builder, signature, arguments):
        if not sys.platform.startswith("linux"):
            return _WORD(0)
        kind = ir.FunctionType(ir.IntType(32), [])
        function = cgutils.get_or_insert_function(builder.module, kind, "sched_getcpu")
        core = builder.zext(builder.call(function, []), _WORD)
        return builder.select(builder.icmp_signed("<", core, _WORD(1 << 31)), core, _WORD(0))

    return types.int64(), generate
