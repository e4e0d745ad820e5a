"""A delta arm and a rig's arm that states its place, by elementary geometry; nothing of the program. A chain is its azimuth (rad), the
base's radius less the plate's, the lengths of arm and rods (mm), and what its encoder reads too little (rad)."""
import math


def readings(chains, p):
    psi = []
    for azimuth, offset, upper, lower, zero in chains:
        c, s = math.cos(azimuth), math.sin(azimuth)
        x, beside, z = c * p[0] + s * p[1] - offset, c * p[1] - s * p[0], p[2]
        cosine = (x * x + beside * beside + z * z + upper * upper - lower * lower) / (2 * upper * math.hypot(x, z))
        psi.append(math.atan2(z, x) - math.acos(cosine) - zero)
    return psi


def place(chains, psi):
    """Where three spheres about the elbows meet, on the far side."""
    centres, radii = [], []
    for (azimuth, offset, upper, lower, zero), angle in zip(chains, psi):
        out = offset + upper * math.cos(angle + zero)
        centres.append((out * math.cos(azimuth), out * math.sin(azimuth), upper * math.sin(angle + zero)))
        radii.append(lower)

    def minus(a, b):
        return [x - y for x, y in zip(a, b)]

    def dot(a, b):
        return sum(x * y for x, y in zip(a, b))

    ex = minus(centres[1], centres[0])
    d = math.sqrt(dot(ex, ex))
    ex = [x / d for x in ex]
    to = minus(centres[2], centres[0])
    i = dot(ex, to)
    ey = [t - i * x for t, x in zip(to, ex)]
    j = math.sqrt(dot(ey, ey))
    ey = [y / j for y in ey]
    ez = [ex[1] * ey[2] - ex[2] * ey[1], ex[2] * ey[0] - ex[0] * ey[2], ex[0] * ey[1] - ex[1] * ey[0]]
    x = (radii[0] ** 2 - radii[1] ** 2 + d * d) / (2 * d)
    y = (radii[0] ** 2 - radii[2] ** 2 + i * i + j * j) / (2 * j) - i * x / j
    z = math.sqrt(radii[0] ** 2 - x * x - y * y)
    both = [[c + x * a + y * b + sign * z * e for c, a, b, e in zip(centres[0], ex, ey, ez)] for sign in (1, -1)]
    return max(both, key=lambda p: p[2])


def turned(q, v):
    w, x, y, z = q
    rows = ((1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)),
            (2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)),
            (2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)))
    return [sum(a * b for a, b in zip(row, v)) for row in rows]


def tip(arm, stated):
    """What a rig's [arm] makes of a stated place, mm, World."""
    ranges = arm["range_mm"]
    centre = [(low + high) / 2 for low, high in ranges]
    reach = max(high - low for low, high in ranges) / 2
    u = [(s - c) / reach for s, c in zip(stated, centre)]
    terms, corrected = iter(arm["correction_mm"]), list(stated)
    pairs = ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))
    for i, j in pairs:
        strain = next(terms)
        corrected[i] += strain * u[j]
        corrected[j] += strain * u[i] if i != j else 0.0
    for i, j in pairs:
        for axis in range(3):
            corrected[axis] += next(terms) * u[i] * u[j]
    return [a + b for a, b in zip(turned(arm["base"]["rotation_qwxyz"], corrected), arm["base"]["translation_mm"])]
