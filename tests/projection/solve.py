"""Solves the stored programs with CVXOPT and writes the optimum into each file.

minimise 1/2 x'Px + q'x subject to Ax + s = b, s in the product of the blocks' cones.
Needs cvxopt (checked with 1.3.3). Run in this folder: python3 solve.py
"""
import glob
import json

import cvxopt
from cvxopt import matrix, solvers, spmatrix

solvers.options.update(show_progress=False, maxiters=300)
solvers.options["refinement"] = 3


def rows_of(blocks, cone):
    """Numbers of the rows of one kind of cone, block by block."""
    found, first = [], 0
    for block in blocks:
        if block["cone"] == cone:
            found.append(list(range(first, first + block["rows"])))
        first += block["rows"]
    return found


def sparse(entries, order, columns):
    """The rows of a list of entries, in the given order."""
    place = {row: i for i, row in enumerate(order)}
    kept = [(place[r], c, v) for r, c, v in entries if r in place]
    i, j, v = zip(*kept) if kept else ((), (), ())
    return spmatrix(list(v), list(i), list(j), (len(order), columns))


for name in sorted(glob.glob("*.json")):
    with open(name) as file:
        stored = json.load(file)
    p = stored["problem"]
    n, blocks = p["variables"], p["blocks"]
    full = [(r, c, v) for r, c, v in p["quadratic"]]
    full += [(c, r, v) for r, c, v in p["quadratic"] if r != c]
    flat = lambda lists: [row for rows in lists for row in rows]
    equal = flat(rows_of(blocks, "Zero"))
    linear, cones = flat(rows_of(blocks, "Nonnegative")), rows_of(blocks, "SecondOrder")
    order = linear + flat(cones)
    b = lambda rows: matrix([float(p["offset"][r]) for r in rows])
    arguments = (
        sparse(full, range(n), n),
        matrix([float(v) for v in p["linear"]]),
        sparse(p["matrix"], order, n),
        b(order),
        {"l": len(linear), "q": [len(c) for c in cones], "s": []},
        sparse(p["matrix"], equal, n),
        b(equal),
    )
    # As accurate as the arithmetic allows: beyond that the iteration breaks down.
    for tolerance in (1e-12, 1e-11, 1e-10, 1e-9, 1e-8):
        solvers.options.update(abstol=tolerance, reltol=tolerance, feastol=tolerance)
        try:
            found = solvers.coneqp(*arguments, kktsolver="ldl")
        except (ValueError, ArithmeticError):
            continue
        if found["status"] == "optimal":
            break
    print(tolerance, end=" ")
    print(name, found["status"], found["primal objective"], "gap", found["gap"], "iterations", found["iterations"])
    stored["solver"] = f"CVXOPT {cvxopt.__version__} coneqp"
    stored["objective"] = found["primal objective"]
    stored["x"] = list(found["x"])
    with open(name, "w") as file:
        json.dump(stored, file)
        file.write("\n")
