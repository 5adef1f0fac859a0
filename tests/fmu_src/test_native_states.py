"""FMU states of the native FMUs: of another FMU, damaged, forged; and setters that are refused as a whole."""

import ctypes
import mmap
import struct
from ctypes import byref, c_bool, c_int, c_size_t, c_void_p
from pathlib import Path

import fmpy
import numpy as np
import pytest

from tests.fmu_src.native_session import ERROR, OK, SESSIONS, references

pytestmark = pytest.mark.slow

NAN, WORD, MASK, PROT_NONE = struct.pack("d", float("nan")), 8, 2**64 - 1, 0


def save(session) -> c_void_p:
    state = c_void_p()
    assert session.call(session.state_functions[0], byref(state)) == OK
    return state


def restore(session, state) -> int:
    return session.call(session.state_functions[1], state)


def free(session, state) -> int:
    return session.call(session.state_functions[2], byref(state))


def serialize(session, state) -> bytes:
    size = c_size_t()
    assert session.call(session.serialize_functions[0], state, byref(size)) == OK
    content = (ctypes.c_ubyte * size.value)()
    assert session.call(session.serialize_functions[1], state, content, size) == OK
    return bytes(content)


def deserialize(session, content: bytes) -> tuple[int, c_void_p]:
    state = c_void_p()
    return session.call(session.serialize_functions[2], content, c_size_t(len(content)), byref(state)), state


@pytest.fixture
def stepped(start):
    """An instance of the dynamics that has made a step, and its state."""
    session = start()
    session.step(0.0, 0.1)
    state = save(session)
    yield session, state
    assert free(session, state) == OK


def test_mode_comes_back_too(start):
    session = start(is_exited=False)
    state = save(session)
    session.call("ExitInitializationMode")
    session.step(0.0, 0.5)
    assert restore(session, state) == OK
    assert session.get_named("time") == [0.0]
    assert session.step(0.0, 0.1) == ERROR
    assert session.call("ExitInitializationMode") == OK
    assert free(session, state) == OK
    assert state.value is None
    assert free(session, state) == OK


def test_state_of_the_other_kind(start):
    stepping, continuous = start("cs"), start("me")
    state = save(stepping)
    assert restore(continuous, state) == ERROR
    assert free(stepping, state) == OK


def test_too_small_a_buffer(stepped):
    session, state = stepped
    small = (ctypes.c_ubyte * 8)()
    assert session.call(session.serialize_functions[1], state, small, c_size_t(8)) == ERROR


class TestForeignStates:
    def refuse(self, session, state) -> None:
        """No function takes the state, and nothing of the instance changes."""
        before, kept = session.get_named(*session.names_read), state.value
        size, content = c_size_t(), (ctypes.c_ubyte * 100_000)()
        assert restore(session, state) == ERROR
        assert session.texts() == ["The FMU state is not one of this FMU: give what GetFMUstate gave for it."]
        assert session.call(session.serialize_functions[0], state, byref(size)) == ERROR
        assert session.call(session.serialize_functions[1], state, content, c_size_t(len(content))) == ERROR
        assert session.call(session.state_functions[0], byref(state)) == ERROR
        assert free(session, state) == ERROR
        assert state.value == kept
        assert session.get_named(*session.names_read) == before

    def test_of_our_other_models(self, fmi, native_folders, envelope_folders):
        """A longer one and a shorter one."""
        with SESSIONS[fmi](native_folders[fmi], "cs") as one, SESSIONS[fmi](envelope_folders[fmi], "cs") as other:
            one.names_read, other.names_read = ["time", "air.tas"], ["time", "tas"]
            for session in (one, other):
                session.initialize()
            states = save(one), save(other)
            self.refuse(other, states[0])
            self.refuse(one, states[1])
            status, _ = deserialize(other, serialize(one, states[0]))
            assert status == ERROR
            assert free(one, states[0]) == free(other, states[1]) == OK

    @pytest.mark.parametrize("content", [b"x", bytes(16), b"{8c4e810f-3df3-4a00-8276-176fa3c9f000}"])
    def test_of_someone_else(self, stepped, content):
        """A short one before memory that must not be read."""
        session, _ = stepped
        session.names_read = ["time", "air.tas"]
        pages = mmap.mmap(-1, 2 * mmap.PAGESIZE)
        begin = ctypes.addressof(ctypes.c_char.from_buffer(pages))
        libc = ctypes.CDLL(None, use_errno=True)
        guard = c_void_p(begin + mmap.PAGESIZE), c_size_t(mmap.PAGESIZE)
        assert libc.mprotect(*guard, PROT_NONE) == 0
        pages[mmap.PAGESIZE - len(content) : mmap.PAGESIZE] = content
        self.refuse(session, c_void_p(begin + mmap.PAGESIZE - len(content)))
        assert libc.mprotect(*guard, mmap.PROT_READ | mmap.PROT_WRITE) == 0


def with_checksum(content: bytes) -> bytes:
    """Serialised bytes with the checksum of what lies before it, the last word."""
    total = 0xCBF29CE484222325
    for (word,) in struct.iter_unpack("Q", content[:-WORD]):
        total = (total ^ word) * 0x9E3779B97F4A7C15 & MASK
        total ^= total >> 32
    return content[:-WORD] + struct.pack("Q", total)


class TestDamagedStates:
    def test_bytes(self, stepped):
        """Each byte altered, in the header and at a sample of places; too few, too many."""
        session, state = stepped
        content = serialize(session, state)
        rng = np.random.default_rng(3)
        places = [*range(64), *rng.integers(64, len(content), 300), len(content) - 1]
        for place in places:
            damaged = bytearray(content)
            damaged[place] ^= int(rng.integers(1, 256))
            status, copy = deserialize(session, bytes(damaged))
            assert (status, copy.value) == (ERROR, None), place
        for size in (0, 1, len(content) - 1, len(content) + 1):
            assert deserialize(session, (content + b"\0")[:size])[0] == ERROR
        status, copy = deserialize(session, content)
        assert status == restore(session, copy) == free(session, copy) == OK

    def test_in_memory(self, stepped):
        session, state = stepped
        size = len(serialize(session, state))
        memory = (ctypes.c_ubyte * size).from_address(state.value)
        before = session.get_named("state.u")
        place = bytes(memory).index(struct.pack("d", before[0]))
        memory[place : place + WORD] = NAN
        assert restore(session, state) == ERROR
        assert session.texts() == ["The FMU state is damaged."]
        assert session.call(session.serialize_functions[1], state, (ctypes.c_ubyte * size)(), c_size_t(size)) == ERROR
        assert session.get_named("state.u") == before

    @pytest.mark.parametrize("number", [float("nan"), float("inf")])
    def test_forged_with_the_right_checksum(self, stepped, number):
        """What is not finite is no value of an instance."""
        session, state = stepped
        content = serialize(session, state)
        assert with_checksum(content) == content
        place = content.index(struct.pack("d", session.get_named("state.u")[0]))
        forged = content[:place] + struct.pack("d", number) + content[place + WORD :]
        assert deserialize(session, with_checksum(forged))[0] == ERROR
        assert session.texts() == ["The FMU state is damaged."]


@pytest.mark.parametrize("name", ["aircraft-native", "aircraft-native3"])
def test_setter_that_is_refused_sets_nothing(name, built, tmp_path):
    """The first variable can be set, the second is computed, of another type, or does not exist."""
    folder = Path(fmpy.extract(built(name), tmp_path))
    fmi = 3 if name.endswith("3") else 2
    with SESSIONS[fmi](folder, "cs") as session:
        session.initialize(is_exited=False)
        real, computed = session.names["state.u"], session.names["air.tas"]
        switch = next(
            v for v in session.description.modelVariables if v.type == "Boolean" and v.causality == "parameter"
        )
        before = session.get_flags(switch.name) + session.get_named("state.u")
        flags = ((c_int if fmi == 2 else c_bool) * 2)(not before[0], True)

        def set_flags(*asked):
            n = c_size_t(len(asked))
            return session.call("SetBoolean", references(asked), n, flags, *(() if fmi == 2 else (n,)))

        for other in (real, 2**31, 2**32 - 1):
            assert set_flags(switch.valueReference, other) == ERROR
            assert "There is no Boolean variable" in session.texts()[0]
        for other in (computed, switch.valueReference, 2**32 - 1):
            assert session.set([real, other], [before[1] + 1, 1.0]) == ERROR
        assert session.get_flags(switch.name) + session.get_named("state.u") == before
        assert set_flags(switch.valueReference) == OK
        assert session.get_flags(switch.name) != before[:1]
