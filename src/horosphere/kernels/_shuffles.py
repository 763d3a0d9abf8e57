"""Records in memory and lanes in registers: the shuffles between the two, as LLVM.

Shuffles are what a cheap kernel costs. Those within 128 bits (unpack) run on every vector unit, those across on half of
them, and those by a table of lanes want registers for the tables; so transposes are written in the first two kinds.
"""

from __future__ import annotations

from llvmlite import ir

_I32, _I64 = ir.IntType(32), ir.IntType(64)


def aligned(instruction, bits: int):
    """A load or store that may be at any multiple of the number's own size."""
    instruction.align = bits // 8
    return instruction


def shuffle(builder, a, b, mask):
    return builder.shuffle_vector(a, b, ir.Constant(ir.VectorType(_I32, len(mask)), mask))


def gather_lanes(builder, sources, wanted):
    """The vector whose lane l is lane wanted[l][1] of sources[wanted[l][0]]: a chain of two-source shuffles."""
    width = len(wanted)
    first, *others = sorted({s for s, _ in wanted})
    mask = [p if s == first else 0 for s, p in wanted]
    result = shuffle(builder, sources[first], ir.Constant(sources[first].type, ir.Undefined), mask)
    for other in others:
        mask = [width + p if s == other else lane for lane, (s, p) in enumerate(wanted)]
        result = shuffle(builder, result, sources[other], mask)
    return result


def pick(builder, a, b, unit, odd):
    """The even (odd) units of `unit` lanes of a, then those of b."""
    n = a.type.count
    lanes = [lane for lane in range(2 * n) if lane // unit % 2 == odd]
    return shuffle(builder, a, b, lanes)


def transpose(builder, rows):
    """W vectors of W lanes, transposed by W log2 W shuffles.

    First pairs of rows are interleaved within pairs of lanes, then pairs of lanes are sorted by column: all of it one
    instruction each with AVX-512, without a table of lanes.
    """
    n = len(rows)
    low = [lane if not lane & 1 else n + (lane ^ 1) for lane in range(n)]
    high = [(lane | 1) if not lane & 1 else n + lane for lane in range(n)]
    columns = {0: [shuffle(builder, rows[i], rows[i + 1], low) for i in range(0, n, 2)],
               1: [shuffle(builder, rows[i], rows[i + 1], high) for i in range(0, n, 2)]}  # fmt: skip
    step = 2
    while step < n:  # columns[c]: vectors that hold column c, c + step, ... for 2, 4, ... rows
        columns = {
            c + odd * step: [pick(builder, v[i], v[i + 1], 2, odd) for i in range(0, len(v), 2)]
            for c, v in columns.items()
            for odd in (0, 1)
        }
        step *= 2
    return [columns[c][0] for c in range(n)]


def deinterleave(builder, vectors, width):
    """K vectors that hold `width` records of K in order -> K vectors, one a component."""
    k = len(vectors)
    if k == 1:
        return vectors
    if k == width and k & (k - 1) == 0:
        return transpose(builder, vectors)
    if k % 2 == 0:
        even = [shuffle(builder, vectors[i], vectors[i + 1], list(range(0, 2 * width, 2))) for i in range(0, k, 2)]
        odd = [shuffle(builder, vectors[i], vectors[i + 1], list(range(1, 2 * width, 2))) for i in range(0, k, 2)]
        halves = deinterleave(builder, even, width), deinterleave(builder, odd, width)
        return [v for pair in zip(*halves) for v in pair]
    return [gather_lanes(builder, vectors, [divmod(r * k + c, width) for r in range(width)]) for c in range(k)]


def interleave(builder, vectors, width):
    """The inverse of `deinterleave`."""
    k = len(vectors)
    if k == 1:
        return vectors
    if width == 8 and k > 2:
        return interleave_by_units(builder, vectors)
    if k == width and k & (k - 1) == 0:
        return transpose(builder, vectors)
    if k % 2 == 0:
        result = []
        halves = interleave(builder, vectors[0::2], width), interleave(builder, vectors[1::2], width)
        for e, o in zip(*halves):
            for part in (range(width // 2), range(width // 2, width)):
                result.append(shuffle(builder, e, o, [x for lane in part for x in (lane, width + lane)]))
        return result
    place = [[((j * width + r) % k, (j * width + r) // k) for r in range(width)] for j in range(k)]
    return [gather_lanes(builder, vectors, wanted) for wanted in place]


def interleave_by_units(builder, vectors):
    """`interleave` of K vectors of 8 lanes by 3 K shuffles that need no table of lanes.

    Two records in a row are K units of two numbers. Unit j of all four pairs of records is one vector (a shuffle within
    units); the numbers in memory order are then units (j, pair) with j running faster, of which first every two
    neighbours and then every four are brought together.
    """
    k = len(vectors)
    units = []
    for j in range(k):
        (r0, c0), (r1, c1) = divmod(2 * j, k), divmod(2 * j + 1, k)
        lanes = [lane for pair in range(4) for lane in (2 * pair + r0, 8 + 2 * pair + r1)]
        units.append(shuffle(builder, vectors[c0], vectors[c1], lanes))

    def of_units(a, b, wanted):
        return shuffle(builder, a, b, [2 * unit + side for unit in wanted for side in (0, 1)])

    neighbours: dict[tuple[int, int], list[tuple[int, int, int]]] = {}  # of which vectors: (place, pair, pair)
    for place in range(2 * k):
        (p, i), (q, j) = divmod(2 * place, k), divmod(2 * place + 1, k)
        neighbours.setdefault((i, j), []).append((place, p, q))
    found = {}  # place -> a vector that holds the two units, and where
    for (i, j), places in neighbours.items():
        for (first, p, q), (second, s, t) in zip(places[0::2], places[1::2], strict=True):
            both = of_units(units[i], units[j], (p, s, 4 + q, 4 + t))
            found[first], found[second] = (both, 0), (both, 1)
    quads = [(found[2 * m], found[2 * m + 1]) for m in range(k)]
    return [of_units(a, b, (at, at + 2, 4 + to, 4 + to + 2)) for (a, at), (b, to) in quads]


def load_group(builder, start, count, column, bits):
    """Columns column .. column + 3 of eight records of `count` numbers.

    Loaded as halves of vectors, so that no shuffle has to bring rows r and r + 4 together.
    """
    element = start.type.pointee
    half = ir.VectorType(element, 4)

    def row(r):
        address = builder.gep(start, [_I64(r * count + column)])
        return aligned(builder.load(builder.bitcast(address, half.as_pointer())), bits)

    rows = [shuffle(builder, row(i), row(i + 2), list(range(8))) for i in (0, 1, 4, 5)]
    low, high = [0, 8, 2, 10, 4, 12, 6, 14], [1, 9, 3, 11, 5, 13, 7, 15]
    pairs = [[shuffle(builder, rows[i], rows[i + 1], m) for i in (0, 2)] for m in (low, high)]
    return [pick(builder, pairs[c % 2][0], pairs[c % 2][1], 2, c // 2) for c in range(4)]
