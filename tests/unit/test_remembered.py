"""A remembered function of position gives the same values, and is asked once for each point."""

import numpy as np

from staffa.properties.remembered import Remembered


def test_only_new_points_are_computed_and_values_are_the_same() -> None:
    asked: list[int] = []

    def function(x: np.ndarray) -> np.ndarray:
        asked.append(x.shape[1])
        return np.asarray(np.sin(9 * x[0]) + x[1] * x[2])

    remembered, random = Remembered(function), np.random.default_rng(1)
    first = random.random((3, 50))
    second = np.concatenate([first[:, 10:][:, ::-1], random.random((3, 7))], axis=1)
    for x in (first, second, second, np.zeros((3, 0)), second):
        expected = np.asarray(np.sin(9 * x[0]) + x[1] * x[2])
        assert np.array_equal(remembered(x), expected)
    assert asked == [50, 7, 47], "the points of the last mesh alone are kept"
