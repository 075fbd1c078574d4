"""Patches of analytic shapes with exact truth, about one point per unit of area."""

import numpy as np

from crispline.surface import Cone, Cylinder, Plane, Similarity, Sphere, Torus

Z = np.array([0.0, 0.0, 1.0])
ORIGIN = np.zeros(3)


def around(angle):
    return np.stack([np.cos(angle), np.sin(angle), np.zeros_like(angle)], axis=1)


def plane(n, rng):
    side = np.sqrt(n)
    points = np.column_stack([rng.uniform(-side / 2, side / 2, (n, 2)), np.zeros(n)])
    return Plane(ORIGIN, Z), points, np.tile(Z, (n, 1))


def cylinder(n, rng, radius=20.0, arc_deg=90.0):
    arc = np.radians(arc_deg)
    height = n / (radius * arc)
    normals = around(rng.uniform(-arc / 2, arc / 2, n))
    along = rng.uniform(-height / 2, height / 2, n)
    return Cylinder(ORIGIN, Z, radius), radius * normals + along[:, None] * Z, normals


def sphere(n, rng, radius=30.0):
    z = rng.uniform(1.0 - n / (2 * np.pi * radius**2), 1.0, n)
    normals = np.sqrt(1 - z**2)[:, None] * around(rng.uniform(0, 2 * np.pi, n)) + z[:, None] * Z
    return Sphere(ORIGIN, radius), radius * normals, normals


def cone(n, rng, half_angle_deg=20.0, arc_deg=120.0, start=10.0):
    half, arc = np.radians(half_angle_deg), np.radians(arc_deg)
    end = np.sqrt(start**2 + 2 * n / (arc * np.sin(half)))
    ruling = np.sqrt(rng.uniform(start**2, end**2, n))[:, None]
    outward = around(rng.uniform(-arc / 2, arc / 2, n))
    points = ruling * (np.cos(half) * Z + np.sin(half) * outward)
    return Cone(ORIGIN, Z, float(half)), points, np.cos(half) * outward - np.sin(half) * Z


def torus(n, rng, major=20.0, minor=5.0, section_deg=(0.0, 90.0), arc_deg=180.0):
    arc = np.radians(arc_deg)
    section = rng.uniform(*np.radians(section_deg), n)[:, None]
    outward = around(rng.uniform(-arc / 2, arc / 2, n))
    normals = np.cos(section) * outward + np.sin(section) * Z
    return Torus(ORIGIN, Z, major, minor), major * outward + minor * normals, normals


PATCHES = {
    "plane": plane,
    "cylinder": cylinder,
    "sphere": sphere,
    "cone": cone,
    "torus": torus,
}


def random_motion(rng, scale=1.0):
    rotation, _ = np.linalg.qr(rng.normal(size=(3, 3)))
    rotation *= np.sign(np.linalg.det(rotation))
    return Similarity(scale, rotation, scale * rng.uniform(-50, 50, 3))


def scanned(patch, sigma, rng, normal_error_deg=7.0):
    """The patch moved anywhere, with noise along the normals and poor normals on one side."""
    surface, points, normals = patch
    motion = random_motion(rng)
    noisy = points + sigma * rng.normal(size=(len(points), 1)) * normals
    blurred = normals + np.radians(normal_error_deg) * rng.normal(size=normals.shape) / np.sqrt(2)
    blurred *= rng.choice([-1.0, 1.0]) / np.linalg.norm(blurred, axis=1, keepdims=True)
    return surface.transformed(motion), motion.points(noisy), motion.directions(blurred)
