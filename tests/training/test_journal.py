"""A memory of evaluations on disk."""

import numpy as np
import pytest

from fsel.training.journal import Journal


class Counting:
    """An evaluator that fails at its n-th call, as a kill would."""

    def __init__(self, stop: int = 10**9) -> None:
        self.calls, self.stop = 0, stop

    def __call__(self, subset: np.ndarray) -> np.ndarray:
        self.calls += 1
        if self.calls == self.stop:
            raise KeyboardInterrupt
        return np.array([subset.sum() / 3, 1 / 7, 0.1])


def test_a_journal_answers_what_a_killed_job_had_evaluated(tmp_path):
    output = tmp_path / "out.parquet"
    subsets = [np.array([i, i + 1]) for i in range(6)]

    def run(counting: Counting) -> list[np.ndarray]:
        with Journal(output, "key") as journal:
            remembered = journal.remember("p", counting)
            return [remembered(subset) for subset in subsets]

    with pytest.raises(KeyboardInterrupt):
        run(Counting(stop=4))
    (path,) = tmp_path.iterdir()
    path.write_text(path.read_text() + '["p:9,10", [1.0, 2')  # cut short by the kill
    second = Counting()
    values = run(second)
    assert second.calls == 3
    np.testing.assert_array_equal(values, [Counting()(s) for s in subsets])
    assert list(tmp_path.iterdir()) == []


def test_a_journal_of_other_inputs_is_not_read(tmp_path):
    other = Journal(tmp_path / "o", "one").path
    other.write_text('["p:1", [1.0, 2.0, 3.0]]\n')
    counting = Counting()
    with Journal(tmp_path / "o", "two") as journal:
        journal.remember("p", counting)(np.array([1]))
    assert counting.calls == 1
