import subprocess
import sys

import numba
import numpy as np

from graben.compiled import compiled


def total(values):
    result = 0.0
    for n in range(len(values)):
        result += 1.0 / values[n]
    return result


def test_a_compiled_loop_adds_as_the_loop_does():
    values = np.random.default_rng(1).random(1000)
    assert compiled(total)(values) == total(values)


def test_division_by_zero_is_ieee_s():
    assert compiled(total)(np.array([0.0, 1.0])) == np.inf


def test_code_that_cannot_be_kept_is_compiled_all_the_same(monkeypatch):
    asked, real = [], numba.njit

    def njit(**options):
        asked.append(options)
        if options.get("cache"):
            raise RuntimeError("cannot cache function 'total': no locator available")
        return real(**options)

    monkeypatch.setattr(numba, "njit", njit)
    values = np.arange(1.0, 4.0)
    assert compiled(total)(values) == total(values)
    assert [options.get("cache", False) for options in asked] == [True, False]


def test_the_program_runs_machine_code():
    code = "import graben.cli, numba; print(numba.config.DISABLE_JIT)"
    answer = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert answer.stdout.strip() == "0"
