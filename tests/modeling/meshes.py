"""Plan triangulations to try the energy on."""

import numpy as np


def equilateral(count, edge=1.0):
    """Rows of equilateral triangles: points (n, 2) and triangles (m, 3)."""
    i, j = np.meshgrid(np.arange(count), np.arange(count), indexing="ij")
    points = edge * np.stack([i + 0.5 * j, np.sqrt(0.75) * j], axis=-1).reshape(-1, 2)
    a = (i * count + j)[:-1, :-1].ravel()
    b, c, d = a + count, a + 1, a + count + 1
    return points, np.concatenate([np.stack([a, b, c], axis=1), np.stack([b, d, c], axis=1)])


def irregular(count, seed=0):
    """An equilateral triangulation about one unit wide with its nodes shaken, still counter-clockwise."""
    points, triangles = equilateral(count, 1.0 / count)
    return points + np.random.default_rng(seed).uniform(-0.2, 0.2, points.shape) / count, triangles


def area(points, triangles):
    a, b, c = (points[triangles[:, k]] for k in range(3))
    u, v = b - a, c - a
    return 0.5 * np.abs(u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0]).sum()


def turned(points, degrees):
    a = np.radians(degrees)
    return points @ np.array([[np.cos(a), np.sin(a)], [-np.sin(a), np.cos(a)]])
