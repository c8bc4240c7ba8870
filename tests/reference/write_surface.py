"""Writes tests/data/formulations/surface_*.json: forces and energies of clouds whose families have been given the
stiffness tensor of their material, by whole tensors of fourth order and differences of energies alone. Needs numpy."""

import itertools
import json
import math
import pathlib

import numpy as np

ALONG, ACROSS = 1e-3, 1e-2
FOLDER = pathlib.Path(__file__).parent.parent / "data" / "formulations"


def cloud(rng, counts, spacing, jitter):
    """Places and volumes of a cloud without order, turned off the axes."""
    places = np.array(list(itertools.product(*map(range, counts))), float)
    places = (places + rng.uniform(-jitter, jitter, places.shape)) * spacing
    turn, _ = np.linalg.qr(rng.normal(size=(len(counts), len(counts))))
    volumes = spacing ** len(counts) * rng.uniform(0.8, 1.2, len(places))
    return places @ turn.T, volumes


def symmetric_basis(size):
    """Symmetric tensors of fourth order, orthonormal, and whether each is even in every axis."""
    basis, is_even = [], []
    for indices in itertools.combinations_with_replacement(range(size), 4):
        tensor = np.zeros((size,) * 4)
        for order in set(itertools.permutations(indices)):
            tensor[order] = 1.0
        basis.append(tensor / np.linalg.norm(tensor))
        is_even.append(all(indices.count(axis) % 2 == 0 for axis in range(size)))
    return np.array(basis), np.array(is_even)


def isotropic(size):
    one = np.eye(size)
    return sum(np.einsum(f"{a},{b}->ijkl", one, one) for a, b in [("ij", "kl"), ("ik", "jl"), ("il", "jk")]) / (
        size * (size + 2)
    )


def factors(directions, weights, total):
    """q of the bonds of a family: the least of a convex function, by Newton's method with halved steps."""
    size = directions.shape[1]
    basis, is_even = symmetric_basis(size)
    forms = np.einsum("aijkl,bi,bj,bk,bl->ba", basis, *[directions] * 4)
    goal = np.einsum("aijkl,ijkl->a", basis, isotropic(size))
    penalty = np.where(is_even, ALONG, ACROSS)

    def value(x):
        return (weights * np.exp(forms @ x)).sum() / total - goal @ x + 0.5 * penalty @ (x * x)

    x = np.zeros(len(basis))
    for _ in range(200):
        stored = weights * np.exp(forms @ x) / total
        gradient = forms.T @ stored - goal + penalty * x
        step = -np.linalg.solve(forms.T @ (stored[:, None] * forms) + np.diag(penalty), gradient)
        length = 1.0
        # Near the end values tell no more.
        if abs(forms @ step).max() > 1e-3:
            while value(x + length * step) > value(x) + 0.1 * length * (gradient @ step):
                length *= 0.5
        x = x + length * step
        if abs(forms @ step).max() < 1e-14:
            break
    else:
        raise RuntimeError(f"no end: {abs(forms @ step).max()}")
    return np.exp(forms @ x)


def families(places, volumes, horizon):
    for point in range(len(places)):
        bonds = places - places[point]
        lengths = np.linalg.norm(bonds, axis=1)
        near = np.flatnonzero((lengths <= horizon) & (lengths > 0.0))
        yield point, near, bonds[near], lengths[near], volumes[near]


def bond_based(file, constant, modulus):
    """A function from positions to W of all points."""
    places, volumes, size = file["positions"], file["volumes"], file["dimension"]
    kept = []
    for point, near, bonds, lengths, others in families(places, volumes, file["horizon"]):
        weights = 0.5 * constant * lengths * others
        # Axial stiffness 3 T/(D (D + 2)) = lambda + 2 mu
        total = 2.0 * modulus * size * (size + 2) / 3.0
        kept.append((point, near, lengths, weights * factors(bonds / lengths[:, None], weights, total)))

    def densities(now):
        def of(point, near, lengths, weights):
            stretch = length_of(now[near] - now[point]) / lengths - 1.0
            return 0.5 * (weights * stretch**2).sum()

        return np.array([of(*family) for family in kept])

    return densities


def ordinary(file, bulk, deviatoric, omega):
    places, volumes, size = file["positions"], file["volumes"], file["dimension"]
    kept = []
    for point, near, bonds, lengths, others in families(places, volumes, file["horizon"]):
        weights = omega(lengths / file["horizon"]) * lengths**2 * others
        weights = weights * factors(bonds / lengths[:, None], weights, weights.sum())
        kept.append((point, near, lengths, weights / weights.sum()))

    def densities(now):
        def of(point, near, lengths, weights):
            stretch = length_of(now[near] - now[point]) / lengths - 1.0
            theta = size * (weights * stretch).sum()
            return 0.5 * bulk * theta**2 + 0.5 * deviatoric * (weights * (stretch - theta / size) ** 2).sum()

        return np.array([of(*family) for family in kept])

    return densities


def length_of(vectors):
    # Complex numbers pass through.
    return np.sqrt((vectors * vectors).sum(axis=1))


def expected(formulation, file, densities):
    now, volumes = file["current"], file["volumes"]
    force = np.zeros_like(now)
    for place in np.ndindex(*now.shape):
        moved = now.astype(complex)
        moved[place] += 1e-30j
        force[place] = -(volumes * densities(moved)).sum().imag / 1e-30 / volumes[place[0]]
    options = {"surface_correction": "stiffness_tensor"}
    return {
        "formulation": formulation,
        "options": options,
        "force": force.ravel().tolist(),
        "energy": densities(now).tolist(),
    }


def write(name, counts, plane, ratio, formulation, seed):
    rng, modulus, size = np.random.default_rng(seed), 210.0, len(counts)
    places, volumes = cloud(rng, counts, 0.25, 0.2)
    horizon = 0.6
    current = places + 0.03 * places[:, ::-1] + rng.uniform(-0.01, 0.01, places.shape)
    file = {
        "dimension": size,
        "plane": plane,
        "positions": places,
        "volumes": volumes,
        "current": current,
        "horizon": horizon,
        "youngs_modulus": modulus,
        "poissons_ratio": ratio,
        "influence": "inverse",
        "broken_pairs": [],
    }
    shear = modulus / (2 * (1 + ratio))
    bulk = modulus / (3 * (1 - 2 * ratio))
    lame = bulk - 2 * shear / 3
    if plane == "stress":
        lame = 2 * lame * shear / (lame + 2 * shear)
    if formulation == "bond_based":
        constant = {
            None: 18 * bulk / (math.pi * horizon**4),
            "stress": 9 * modulus / (math.pi * horizon**3),
            "strain": 48 * modulus / (5 * math.pi * horizon**3),
        }[plane]
        densities = bond_based(file, constant, 0.5 * lame + shear)
    elif size == 3:
        densities = ordinary(file, bulk, 15 * shear, lambda q: 1 / q)
    else:
        densities = ordinary(file, lame + shear, 8 * shear, lambda q: 1 / q)
    file["models"] = {"surface": expected(formulation, file, densities)}
    file = {key: value.ravel().tolist() if isinstance(value, np.ndarray) else value for key, value in file.items()}
    (FOLDER / f"{name}.json").write_text(json.dumps(file))
    print(name, len(volumes))


write("surface_3d_bond_based", (4, 4, 3), None, 0.25, "bond_based", 1)
write("surface_3d_ordinary", (4, 4, 3), None, 0.3, "ordinary_state_based", 2)
write("surface_2d_bond_based", (6, 5), "stress", 1 / 3, "bond_based", 3)
write("surface_2d_ordinary", (6, 5), "strain", 0.2, "ordinary_state_based", 4)
