"""Free parameters: which there are, and what their values mean."""

import numpy as np
import pytest

from sstl_cli.diagnosis.free import LINE, Free, as_effects, free_parameters


def test_a_width_is_the_range_in_which_a_parameter_is_looked_for_first():
    assert [Free(LINE, p).width for p in LINE.parameters] == pytest.approx([0.98, 0.98])


def test_free_parameters_are_those_that_a_recorded_system_can_show():
    assert [f.parameter.name for f in free_parameters(("gain_error",), ("act",))] == ["g_act"]
    names = [f.parameter.name for f in free_parameters(("presliding", "const_friction"), ("sstl",))]
    # effects along the line need its load
    assert names == ["breakaway_mm", "spread", "bristle_mm", "dahl_mm", "tail", "load_mm_per_n", "w_l_n", "w_bend_n", "w_in_n", "w_end_n"]


def test_values_become_effects_within_their_meaning():
    free = [*free_parameters(("gain_error",), ("act", "sstl")), *free_parameters(("const_friction",), ("act",))]
    assert [f.width for f in free] == pytest.approx([0.3, 0.3, 0.5, 1.0, 0.5, 0.5])
    assert as_effects(free, np.array([1.02, 99.0, -1.0, 0.1, 0.0, 0.2])) == {
        "gain_error": {"g_act": 1.02, "g_sstl": pytest.approx(11.5)},
        "const_friction": {"w_l_n": 0.0, "w_bend_n": 0.1, "w_in_n": 0.0, "w_end_n": 0.2},
    }
