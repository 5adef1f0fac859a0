"""Many instances of the native FMUs at once, and one after the other."""

import threading
from pathlib import Path

import fmpy
import numpy as np
import pytest

from tests.fmu_src.native_flight import fly
from tests.fmu_src.native_session import SESSIONS

pytestmark = pytest.mark.slow


def in_threads(work, results) -> None:
    threads = [threading.Thread(target=work, args=(results, place)) for place in range(len(results))]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()


class TestInstances:
    def test_threads_give_the_same_bits(self, fmi, native_folders):
        """Eight threads with an instance each (ctypes lets go of the interpreter during a call)."""

        def flight(results, place):
            with SESSIONS[fmi](native_folders[fmi], "cs") as session:
                session.initialize()
                results[place] = fly(session, 500)

        alone, results = [None], [None] * 8
        flight(alone, 0)
        in_threads(flight, results)
        for result in results:
            np.testing.assert_array_equal(result, alone[0])

    def test_threads_give_the_same_envelopes(self, envelope_folders):
        """The search for V_min and V_max keeps nothing outside its instance."""

        def envelopes(results, place):
            with SESSIONS[2](envelope_folders[2], "cs") as session:
                session.initialize()
                for step in range(4):
                    session.set([0, 1, 2, 3], [1000.0 + 2000 * step, -0.02 * step, -0.1, 0.1 * (step - 1)])
                    results[place].append(session.get([5, 6]))

        alone, results = [[]], [[] for _ in range(8)]
        envelopes(alone, 0)
        assert all(0 < v_min < v_max for _, (v_min, v_max) in alone[0])
        in_threads(envelopes, results)
        assert all(result == alone[0] for result in results)

    def test_ten_thousand_instances_do_not_grow(self, fmi, native_folders):
        folder = native_folders[fmi]
        description = fmpy.read_model_description(folder, validate=False)
        library = SESSIONS[fmi](folder, "cs").library

        def resident_kb():
            for line in Path("/proc/self/status").read_text().splitlines():
                if line.startswith("VmRSS"):
                    return float(line.split()[1])
            pytest.skip("the system does not tell the resident memory")

        session = SESSIONS[fmi](folder, "cs")
        token = description.guid.encode()

        def cycle(count):
            for _ in range(count):
                session.free()
                session.component.value = session.instantiate("cs", token, b"one", True)
                session.enter_initialization()
                session.get([12])

        cycle(500)
        before = resident_kb()
        cycle(10_000)
        assert resident_kb() - before < 1000
        session.free()
        assert library is not None
