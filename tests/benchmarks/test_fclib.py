"""Frictional contact problems of a folder: written in every form, read back the same, solved, left out."""

import numpy as np
import pytest
from scipy import sparse

from benchmarks import fclib, siconos_peer
from benchmarks.fclib import FrictionProblem, merit, read_hdf5, read_text
from benchmarks.friction_problems import solve_friction_problem


def problem(n: int = 3) -> FrictionProblem:
    rng = np.random.default_rng(0)
    root = rng.normal(size=(3 * n, 3 * n))
    q = rng.normal(size=3 * n)
    q[::3] = -np.abs(q[::3])
    return FrictionProblem(root @ root.T, q, rng.uniform(0.2, 0.8, n))


def put(group, matrix, how: str) -> None:
    made = {"rows": sparse.csr_array, "columns": sparse.csc_array, "triplets": sparse.coo_array}[how](matrix)
    if how == "triplets":
        i, p, count = made.row, made.col, made.nnz
    else:
        i, p, count = made.indices, made.indptr, -2 if how == "rows" else -1
    for key, value in {"m": matrix.shape[0], "n": matrix.shape[1], "nz": count}.items():
        group[key] = [value]
    group["i"], group["p"], group["x"] = i, p, made.data


@pytest.mark.parametrize("how", ["rows", "columns", "triplets"])
def test_local_problems_are_read(tmp_path, how):
    h5py, given = pytest.importorskip("h5py"), problem()
    with h5py.File(tmp_path / "local.hdf5", "w") as file:
        put(file.create_group("fclib_local/W"), given.W, how)
        file["fclib_local/spacedim"] = [3]
        file["fclib_local/vectors/q"], file["fclib_local/vectors/mu"] = given.q, given.mu
    for one, other in zip(read_hdf5(tmp_path / "local.hdf5"), given, strict=True):
        np.testing.assert_array_equal(one, other)


def test_unknowns_of_global_problems_are_eliminated(tmp_path):
    h5py = pytest.importorskip("h5py")
    rng = np.random.default_rng(1)
    M, H = np.diag(rng.uniform(1, 2, 8)), rng.normal(size=(8, 6))
    f, w = rng.normal(size=8), rng.normal(size=6)
    with h5py.File(tmp_path / "global.hdf5", "w") as file:
        for key, matrix in (("M", M), ("H", H)):
            put(file.create_group(f"fclib_global/{key}"), matrix, "triplets")
        file["fclib_global/spacedim"] = [3]
        for key, values in {"f": f, "w": w, "mu": [0.3, 0.4]}.items():
            file[f"fclib_global/vectors/{key}"] = values
    found = read_hdf5(tmp_path / "global.hdf5")
    r = rng.normal(size=6)
    v = np.linalg.solve(M, H @ r + f)
    np.testing.assert_allclose(found.W @ r + found.q, H.T @ v + w)


def text(given: FrictionProblem) -> str:
    """Siconos' text, W by blocks of a contact each."""
    n = len(given.mu)
    words = [
        3,
        n,
        1,
        3 * n,
        3 * n,
        n * n,
        n,
        n,
        *range(3, 3 * n + 1, 3),
        *range(3, 3 * n + 1, 3),
        n + 1,
        n * n,
    ]
    words += [*range(0, n * n + 1, n), *(column for _ in range(n) for column in range(n))]
    for k in range(n * n):
        row, column = divmod(k, n)
        block = given.W[3 * row : 3 * row + 3, 3 * column : 3 * column + 3]
        words += [k, *block.T.ravel()]
    return " ".join(map(repr, map(float, [*given.q, *given.mu]))).join(
        [" ".join(map(str, words)) + "\n", "\n"]
    )


def test_texts_are_read(tmp_path):
    given = problem()
    (tmp_path / "text.dat").write_text(text(given))
    for one, other in zip(read_text(tmp_path / "text.dat"), given, strict=True):
        np.testing.assert_allclose(one, other, rtol=1e-15)


def test_the_merit_is_nothing_at_a_solution_only():
    given = problem()
    r = solve_friction_problem(*given).r
    assert merit(given, r) < 1e-9
    assert merit(given, 1.1 * r) > 1e-2


def test_a_folder_is_solved_and_what_is_absent_left_out(tmp_path, capsys, monkeypatch):
    monkeypatch.setattr(siconos_peer, "is_here", lambda: False)
    monkeypatch.setattr(fclib, "find_spec", lambda name: None)
    monkeypatch.setattr("benchmarks.timing.LEAST", 0.0)
    (tmp_path / "text.dat").write_text(text(problem()))
    (tmp_path / "other.hdf5").write_bytes(b"")
    assert fclib.main(["--folder", str(tmp_path)]) == 0
    said = capsys.readouterr().out
    assert "text.dat" in said
    assert "yes" in said
    assert f"other.hdf5: {fclib.NO_HDF5}" in said
    assert siconos_peer.ABSENT in said
    with pytest.raises(SystemExit):
        fclib.main(["--folder", str(tmp_path / "nothing")])
