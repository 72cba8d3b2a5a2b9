"""The order of elimination."""

from __future__ import annotations

from kousoku.codegen.dynamics.operations.elimination_order import Pivot, minimum_degree


def test_a_chain_is_eliminated_from_both_ends_without_fill() -> None:
    order = minimum_degree(5, [(k, k + 1) for k in range(4)])
    ends = [Pivot(0, (1,)), Pivot(4, (3,)), Pivot(1, (2,)), Pivot(3, (2,)), Pivot(2, ())]
    assert order == tuple(ends)


def test_a_chain_is_eliminated_from_one_end_where_that_is_asked() -> None:
    order = minimum_degree(5, [(k, k + 1) for k in range(4)], at_once=False)
    assert order == tuple(Pivot(k, (k + 1,) if k < 4 else ()) for k in range(5))


def test_the_middle_of_a_star_comes_last() -> None:
    order = minimum_degree(5, [(0, k) for k in range(1, 5)])
    assert [pivot.joint for pivot in order] == [1, 2, 3, 4, 0]
    assert [pivot.neighbours for pivot in order] == [(0,), (0,), (0,), (0,), ()]


def test_fill_is_counted_as_a_neighbour() -> None:
    order = minimum_degree(4, [(0, 1), (1, 2), (2, 3), (3, 0)])
    assert order[0] == Pivot(0, (1, 3))
    assert order[1] == Pivot(2, (1, 3))
    assert order[2] == Pivot(1, (3,))


def test_neighbours_stand_in_the_order_in_which_they_are_eliminated() -> None:
    order = minimum_degree(6, [(0, 5), (0, 3), (5, 1), (5, 2), (5, 4), (3, 1), (3, 2), (1, 2)])
    place = {pivot.joint: k for k, pivot in enumerate(order)}
    for k, pivot in enumerate(order):
        places = [place[joint] for joint in pivot.neighbours]
        assert places == sorted(places)
        assert all(other > k for other in places)


def test_what_is_not_coupled_has_no_neighbours() -> None:
    assert minimum_degree(2, []) == (Pivot(0, ()), Pivot(1, ()))
