"""Warp functions that find the units of a world's rows, and the order in which they may be visited."""

# Code of Warp kernels is not Python to a type checker.
# pyright: reportArgumentType=false, reportCallIssue=false, reportGeneralTypeIssues=false, reportIndexIssue=false, reportOperatorIssue=false

# ruff: noqa: UP018, RUF046

import warp as wp

from usdsdg_physics.solver.sweep_arrays import (
    DENSE_CLAMP,
    DENSE_FRICTION,
    DENSE_LIMIT,
    DENSE_ROW,
    DRIVE,
    FREE_CONTACT,
    FREE_FRICTION,
    FREE_LIMIT,
    FRICTION,
    VELOCITY_LIMIT,
    Islands,
    Rows,
)


@wp.func
def find_units(rows: Rows, clamps: int, islands: Islands):
    """Find the units in the order of the solver's sweep; return how many there are."""
    dense_count = wp.min(rows.count[0], rows.type.shape[1])
    free_count = wp.min(rows.free_count[0], rows.free_type.shape[1])
    free_end = wp.min(rows.free_contact_end[0], free_count)
    found = int(0)
    for i in range(dense_count):
        type = rows.type[0, i]
        other = int(i)
        if type == FRICTION:
            other = rows.parent[0, i] + 2
        islands.blocks[i] = nonzero_blocks(rows, islands, i, other)
        if type == FRICTION:
            # The first row of a pair solves the second.
            if i == rows.parent[0, i] + 1:
                islands.found[found] = dense_unit(islands, DENSE_FRICTION, i)
                found += 1
        elif type != VELOCITY_LIMIT and rows.diagonal[0, i] > 0.0:
            islands.found[found] = dense_unit(islands, DENSE_ROW, i)
            found += 1
    i = int(0)
    while i < free_end:
        row = int(i)
        i += 1
        kind = int(FREE_CONTACT)
        if rows.free_type[0, row] == FRICTION:
            if row != rows.free_parent[0, row] + 1:
                continue
            kind = int(FREE_FRICTION)
            i += 1
        elif not rows.free_inverse_diagonal[0, row] > 0.0:
            continue
        dof_a = rows.free_dof_a[0, row]
        dof_b = rows.free_dof_b[0, row]
        if dof_a >= 0 and dof_b >= 0:
            islands.found[found] = wp.vec4i(kind + 1, row, islands.node[dof_a], islands.node[dof_b])
            found += 1
        elif dof_a >= 0 or dof_b >= 0:
            node = islands.node[wp.max(dof_a, dof_b)]
            islands.found[found] = wp.vec4i(kind, row, node, node)
            found += 1
    for i in range(dense_count):
        if rows.type[0, i] == VELOCITY_LIMIT and rows.diagonal[0, i] > 0.0:
            islands.found[found] = dense_unit(islands, DENSE_LIMIT, i)
            found += 1
    if clamps != 0:
        for i in range(dense_count):
            if rows.type[0, i] == DRIVE and rows.diagonal[0, i] > 0.0:
                islands.found[found] = dense_unit(islands, DENSE_CLAMP, i)
                found += 1
    for i in range(free_end, free_count):
        dof = wp.max(rows.free_dof_a[0, i], rows.free_dof_b[0, i])
        if rows.free_type[0, i] == VELOCITY_LIMIT and rows.free_inverse_diagonal[0, i] > 0.0 and dof >= 0:
            islands.found[found] = wp.vec4i(FREE_LIMIT, i, islands.node[dof], islands.node[dof])
            found += 1
    return found


@wp.func
def nonzero_blocks(rows: Rows, islands: Islands, row: int, other: int):
    """Return a range of dofs of one node and one of others, outside of which two dense rows and responses are zero."""
    begin0 = int(0)
    end0 = int(0)
    begin1 = int(0)
    end1 = int(0)
    for d in range(islands.node.shape[0]):
        if is_nonzero(rows, row, d) or is_nonzero(rows, other, d):
            if end0 == 0:
                begin0 = d
            if end0 == 0 or (end1 == 0 and islands.node[d] == islands.node[begin0]):
                end0 = d + 1
            else:
                if end1 == 0:
                    begin1 = d
                end1 = d + 1
    if end1 == 0:
        begin1 = begin0
        end1 = begin0
    return wp.vec4i(begin0, end0, begin1, end1)


@wp.func
def is_nonzero(rows: Rows, row: int, dof: int):
    """Return whether a row moves a degree of freedom, or is moved by it."""
    return rows.jacobian[0, row, dof] != 0.0 or rows.response[0, row, dof] != 0.0


@wp.func
def dense_unit(islands: Islands, kind: int, row: int):
    """Return the unit of a row of joints: its kind, its row, and the nodes of its blocks."""
    blocks = islands.blocks[row]
    return wp.vec4i(kind, row, islands.node[blocks[0]], islands.node[blocks[2]])


@wp.func
def visit(islands: Islands, unit: wp.vec4i):
    """Return how many units follow each other, of those visited so far, up to this one; visit it."""
    latest = islands.latest[unit[2]]
    last = last_node(islands, unit)
    for n in range(unit[3], last + 1):
        latest = wp.max(latest, islands.latest[n])
    islands.latest[unit[2]] = latest + 1
    for n in range(unit[3], last + 1):
        islands.latest[n] = latest + 1
    return latest


@wp.func
def last_node(islands: Islands, unit: wp.vec4i):
    """Return the last node of a unit, whose second node is not that where a row connects more than two trees."""
    if unit[0] < DENSE_ROW:
        return unit[3]
    blocks = islands.blocks[unit[1]]
    return wp.max(unit[3], islands.node[wp.max(blocks[3] - 1, 0)])


@wp.func
def join(root: wp.array[int], node: int, other: int):
    """Let two nodes have the same root, the lower one."""
    a = find_root(root, node)
    b = find_root(root, other)
    root[wp.max(a, b)] = wp.min(a, b)


@wp.func
def find_root(root: wp.array[int], node: int):
    """Return the root of a node, and shorten the way to it."""
    i = int(node)
    while root[i] != i:
        root[i] = root[root[i]]
        i = root[i]
    return i
