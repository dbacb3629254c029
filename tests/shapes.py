"""Objects of simple shape as mesh files, for the simulated hand."""

import math

SEGMENTS = 64
STEP_MM = 4.0


def write_obj(path, outline_mm, square=False):
    """Writes the surface of an outline of (radius, height), from the axis at the bottom to the axis at the top, that turns
    about z; `square`: along a square that wide instead of a circle. Millimetres."""
    vertices, rings = [], []
    for radius, height in subdivided(outline_mm):
        count = SEGMENTS if radius > 0 else 1
        rings.append((len(vertices) + 1, count))
        for number in range(count):
            angle = 2 * math.pi * number / SEGMENTS
            x, y = math.cos(angle), math.sin(angle)
            reach = radius / max(abs(x), abs(y)) if square else radius
            vertices.append((reach * x, reach * y, height))
    lines = ['v {:.4f} {:.4f} {:.4f}'.format(*vertex) for vertex in vertices]
    lines += ['f {} {} {}'.format(*face) for face in faces(rings)]
    path.write_text('\n'.join(lines) + '\n')


def subdivided(outline):
    """The same outline in short steps: what is dented must be able to bend."""
    points = [outline[0]]
    for start, end in zip(outline, outline[1:]):
        steps = math.ceil(math.dist(start, end) / STEP_MM)
        points += [tuple(a + (b - a) * step / steps for a, b in zip(start, end)) for step in range(1, steps + 1)]
    return points


def faces(rings):
    """Triangles between rings, each of which is a first vertex and a count of them."""
    for (low, low_count), (high, high_count) in zip(rings, rings[1:]):
        for number in range(SEGMENTS):
            following = (number + 1) % SEGMENTS
            if low_count > 1:
                yield low + number, low + following, high + following % high_count
            if high_count > 1:
                yield low + number % low_count, high + following, high + number
