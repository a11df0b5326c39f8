"""The cheapest pairing of rows with columns."""

import numpy as np
from numpy.typing import NDArray


def cheapest_pairs(
    cost: NDArray[np.float64],
) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """Pair rows with columns, each once, at the least total cost.

    Parameters
    ----------
    cost : (n_rows, n_columns) array
        Finite.

    Returns
    -------
    rows, columns : (min(n_rows, n_columns),) int arrays
        Pairs, in order of the rows.

    References
    ----------
    Crouse (2016), doi:10.1109/TAES.2016.140952 (shortest augmenting paths, with prices that keep
    all reduced costs at least 0); SciPy has the same behind a package of 10 MB.
    """
    if cost.shape[0] > cost.shape[1]:
        columns, rows = cheapest_pairs(cost.T)
        order = np.argsort(rows)
        return rows[order], columns[order]
    n_rows, n_columns = cost.shape
    row_price, column_price = np.zeros(n_rows), np.zeros(n_columns)
    column_of, row_of = np.full(n_rows, -1), np.full(n_columns, -1)
    for start in range(n_rows):
        _augment(cost, start, row_price, column_price, column_of, row_of)
    return np.arange(n_rows), column_of


def _augment(
    cost: NDArray[np.float64],
    start: int,
    row_price: NDArray[np.float64],
    column_price: NDArray[np.float64],
    column_of: NDArray[np.intp],
    row_of: NDArray[np.intp],
) -> None:
    """Pair one more row along the shortest path to a free column; prices follow."""
    n_columns = cost.shape[1]
    distance, before = np.full(n_columns, np.inf), np.full(n_columns, -1)
    done = np.zeros(n_columns, dtype=bool)
    visited, row, lowest = [start], start, 0.0
    while True:
        reduced = lowest + cost[row] - row_price[row] - column_price
        nearer = ~done & (reduced < distance)
        distance[nearer], before[nearer] = reduced[nearer], row
        open_distance = np.where(done, np.inf, distance)
        lowest = float(open_distance.min())
        # Of equal ones a free column, which ends the path.
        nearest = np.flatnonzero(open_distance == lowest)
        free = nearest[row_of[nearest] < 0]
        column = int(free[0] if len(free) else nearest[0])
        done[column] = True
        if row_of[column] < 0:
            break
        row = int(row_of[column])
        visited.append(row)
    row_price[start] += lowest
    for other in visited[1:]:
        row_price[other] += lowest - distance[column_of[other]]
    column_price[done] -= lowest - distance[done]
    while True:
        row = int(before[column])
        row_of[column], column_of[row], column = row, column, int(column_of[row])
        if row == start:
            return
