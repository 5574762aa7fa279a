"""The energy balance a second time: the definitions of the documentation in plain loops over
objects and contacts, solved by mpmath."""

from __future__ import annotations

import itertools
import math

import mpmath
import numpy as np
from haptic_tracing.core.graph.haptic_graph import HapticGraph

Place = tuple[float, float, float]
LEAST = 0.005
"""Power that an object of its own takes up at least."""


def _mean_between(contacts: list[dict], axis: int, low: float, high: float) -> float:
    """Mean place along an axis of the part of the contacts, in order along it, between two
    fractions of their strengths."""
    total, before, mean = sum(c["strength"] for c in contacts), 0.0, 0.0
    for contact in sorted(contacts, key=lambda c: c["place"][axis]):
        after = before + contact["strength"] / total
        mean += (
            max(min(after, high) - max(before, low), 0.0) * contact["place"][axis] / (high - low)
        )
        before = after
    return mean


class Balance:
    """Subsystems and equations of a graph. ``regions``: (object, lattice point) of each
    subsystem."""

    def __init__(self, graph: HapticGraph, band: int | None = None) -> None:
        self.graph, self.band = graph, band
        self.contacts: dict[int, list[dict]] = {}
        for node in range(graph.node_count):
            partner = int(graph.partner[node])
            if partner < 0 or graph.transmission[graph.contact[node]] <= 0:
                continue
            here = int(graph.node_object[node])
            contact = int(graph.contact[node])
            strength = float(graph.weight[contact])
            place = tuple(graph.node_position[node].tolist())
            self.contacts.setdefault(here, []).append(
                {
                    "node": node,
                    "partner": partner,
                    "contact": contact,
                    "strength": strength,
                    "place": place,
                }
            )
        self.weights: dict[int, dict[tuple, float]] = {}
        self.uptake: dict[int, float] = {}
        for index, contacts in self.contacts.items():
            self._attach(index, contacts)
        self.regions = sorted({region for weights in self.weights.values() for region in weights})
        self.number = {region: k for k, region in enumerate(self.regions)}
        self.centre, self.away, self.mass = {}, {}, {}
        for index in self.contacts:
            self._measure(index)

    def squared(self, index: int, distance: float) -> float:
        """Square of an object's gain, at most 1."""
        item = self.graph.table.objects[index]
        gain = float(
            item.propagation.gain(
                np.array(distance), item.kappa, item.rho, self.graph.table.epsilon
            )
        )
        if self.band is not None:
            spectrum = item.propagation.spectrum
            decays = item.propagation.band_decays(item.kappa, item.rho)
            gain *= (spectrum.band_gains[self.band] if spectrum.band_gains else 1.0) * math.exp(
                -(decays[self.band] if decays else 0.0) * distance
            )
        return min(gain, 1.0) ** 2

    def mean_squared(self, region: tuple) -> float:
        """Mean squared gain over the typical distances of a region's contacts."""
        return sum(part * self.squared(region[0], away) for part, away in self.away[region])

    def on_object(self, index: int, place: Place) -> np.ndarray:
        """The nearest place in the bounding box of an object that has one."""
        frames = self.graph.frames
        middle, axes = frames.centre[index], frames.axes[index]
        if np.isnan(middle[0]):
            return np.array(place)
        along = axes.T @ (np.array(place) - middle)
        half = frames.size[index] / 2
        return middle + axes @ np.clip(along, -half, half)

    def length(self, index: int, extent: float) -> float:
        """Distance at which the plain gain has fallen to 1/e, by bisection."""
        item = self.graph.table.objects[index]

        def gain(distance: float) -> float:
            return float(
                item.propagation.gain(
                    np.array(distance), item.kappa, item.rho, self.graph.table.epsilon
                )
            )

        wanted = gain(0.0) / math.e
        if extent == 0 or gain(0.0) == 0 or gain(extent) >= wanted:
            return math.inf
        low, high = 0.0, extent
        for _ in range(200):
            low, high = (
                ((low + high) / 2, high)
                if gain((low + high) / 2) >= wanted
                else (low, (low + high) / 2)
            )
        return high

    def _attach(self, index: int, contacts: list[dict]) -> None:
        middle, axes = self.graph.frames.centre[index], self.graph.frames.axes[index]
        radius = math.hypot(*self.graph.frames.size[index].tolist()) / 2
        if np.isnan(middle[0]):
            ends = [
                np.array([_mean_between(contacts, k, *part) for k in range(3)])
                for part in ((0.05, 0.15), (0.85, 0.95))
            ]
            middle = (ends[0] + ends[1]) / 2
            radius = math.dist(*ends) / 2
        farthest = max(math.dist(self.on_object(index, c["place"]), middle) for c in contacts)
        length = self.length(index, 2 * max(radius, farthest))
        self.uptake[index] = min(max(2 * radius / length - 1, LEAST), 1.0)
        for contact in contacts:
            if farthest <= length / 2:
                self.weights[contact["node"]] = {(index, None): 1.0}
                continue
            sides = []
            for k in range(3):
                along = float(np.dot(axes[:, k], np.array(contact["place"]) - middle)) / length
                along = math.copysign(max(0.0, abs(along) - 0.5), along)
                first = math.floor(along)
                sides.append({first: 1 - (along - first), first + 1: along - first})
            self.weights[contact["node"]] = {
                (index, point): math.prod(side[p] for side, p in zip(sides, point, strict=True))
                for point in itertools.product(*sides)
                if math.prod(side[p] for side, p in zip(sides, point, strict=True)) > 0
            }

    def _measure(self, index: int) -> None:
        contacts = self.contacts[index]
        totals: dict = {}
        for contact in contacts:
            totals[contact["contact"]] = totals.get(contact["contact"], 0.0) + contact["strength"]
        for region in {r for c in contacts for r in self.weights[c["node"]]}:
            parts: dict = {}
            for contact in contacts:
                weight = contact["strength"] * self.weights[contact["node"]].get(region, 0.0)
                if weight > 0:
                    total, moment = parts.get(contact["contact"], (0.0, np.zeros(3)))
                    place = np.array(contact["place"])
                    if region[1] is None:
                        place = self.on_object(index, contact["place"])
                    parts[contact["contact"]] = total + weight, moment + weight * place
            places = [(strength, moment / strength) for strength, moment in parts.values()]
            total = sum(strength for strength, _ in places)
            self.centre[region] = sum(strength * place for strength, place in places) / total
            pairs = sum(a * b for (a, _), (b, _) in itertools.permutations(places, 2))
            ratio = math.sqrt(2 * total**2 / max(pairs, 2.0))
            self.away[region] = [
                (strength / total, ratio * math.dist(place, self.centre[region]))
                for strength, place in places
            ]
            self.mass[region] = (
                1.0
                if region[1] is None
                else min(1.0, max(s for s, _ in places) / max(totals.values()))
            )

    def equations(self) -> tuple[list[float], dict[tuple[int, int], float], dict[int, float]]:
        """Dampings, couplings (both directions) and leaks to objects that transmit nothing."""
        through = [self.mean_squared(region) for region in self.regions]
        loss = [
            self.mass[r] / (f if f > 0 else 1.0) for r, f in zip(self.regions, through, strict=True)
        ]
        damping = [
            self.mass[r] * ((1 - f) / f if f > 0 else 0.0) + self.mass[r] * self.uptake[r[0]]
            for r, f in zip(self.regions, through, strict=True)
        ]
        couplings: dict[tuple[int, int], float] = {}
        for contact in (c for contacts in self.contacts.values() for c in contacts):
            gain = float(self.graph.transmission[contact["contact"]])
            if self.band is not None and self.graph.contact_band_gains is not None:
                gain *= float(self.graph.contact_band_gains[contact["contact"], self.band])
            value = min(gain, 1.0) ** 2
            for (a, wa), (b, wb) in itertools.product(
                self.weights[contact["node"]].items(), self.weights[contact["partner"]].items()
            ):
                pair = self.number[a], self.number[b]
                couplings[pair] = couplings.get(pair, 0.0) + value * wa * wb
        for a, b in itertools.permutations(self.regions, 2):
            if a[0] == b[0] and through[self.number[a]] > 0 and through[self.number[b]] > 0:
                across = self.squared(a[0], math.dist(self.centre[a], self.centre[b]))
                value = across * loss[self.number[a]] * loss[self.number[b]]
                couplings[self.number[a], self.number[b]] = (
                    couplings.get((self.number[a], self.number[b]), 0.0) + value
                )
        leak: dict[int, float] = {}
        for a, b in list(couplings):
            if through[b] == 0:
                leak[a] = leak.get(a, 0.0) + couplings[a, b]
            if through[a] == 0 or through[b] == 0:
                del couplings[a, b]
        self.passes = [f > 0 for f in through]
        return damping, couplings, leak

    def attached(self, node: int) -> dict[int, tuple[float, float]]:
        """Share and energy of an end by subsystem of its object."""
        index, place = int(self.graph.node_object[node]), self.graph.node_position[node]
        reach = 0.0 if self.graph.reach is None else float(self.graph.reach[node])
        away = {r: math.dist(place, self.centre[r]) for r in self.regions if r[0] == index}
        here = list(away)
        arriving = {r: self.squared(index, away[r]) for r in here}
        felt = {r: self.squared(index, max(0.0, away[r] - reach)) for r in here}
        if not here or max(felt.values()) == 0:
            return {}
        # The nearest regions alone: those around one contact have the same centre but for rounding.
        if max(arriving.values()) == 0:
            arriving = {r: float(away[r] <= min(away.values()) * (1 + 1e-9)) for r in here}
        nearest = max(arriving.values())
        share = {r: (arriving[r] / nearest) ** 4 * self.mass[r] for r in here}
        total = sum(share.values())
        at_once = self.squared(index, 0.0)
        return {
            self.number[r]: (
                share[r] / total,
                share[r] / total * min(1.0, felt[r] / at_once) * self.passes[self.number[r]],
            )
            for r in here
        }


def energy_gain(graph: HapticGraph, row: int, column: int, band: int | None = None) -> float:
    """The amplitude gain of one pair."""
    balance = Balance(graph, band)
    damping, couplings, leak = balance.equations()
    total = [damping[k] + leak.get(k, 0.0) for k in range(len(damping))]
    for (a, _), value in couplings.items():
        total[a] += value
    sources, listener = graph.sources[row].nodes, int(graph.listener_nodes[column])
    level = sum(
        min(max(_level(balance, total, couplings, node, listener), 0), 1) for node in sources
    )
    return float(mpmath.sqrt(level / len(sources)))


def _level(
    balance: Balance,
    total: list[float],
    couplings: dict[tuple[int, int], float],
    node: int,
    listener: int,
) -> mpmath.mpf:
    """The squared gain from one node of a source to a listener."""
    graph, ends = balance.graph, [balance.attached(node), balance.attached(listener)]
    through = [sum(energy for _, energy in end.values()) for end in ends]
    level = mpmath.mpf(0)
    if all(through):
        parts = [
            {k: mpmath.mpf(energy) / whole for k, (_, energy) in end.items()}
            for end, whole in zip(ends, through, strict=True)
        ]
        energies = [
            solved(total, couplings, [part.get(k, 0.0) for k in range(len(total))])
            for part in parts
        ]
        own_s, across, own_l = (
            sum(energies[a][k] * part for k, part in parts[b].items())
            for a, b in ((0, 0), (0, 1), (1, 1))
        )
        takes_s, takes_l = (
            (1 - balance.uptake[int(graph.node_object[end])]) / mpmath.mpf(3)
            for end in (node, listener)
        )
        lost = (
            (1 + takes_s * own_s) * (1 + takes_l * own_l)
            - takes_s * takes_l * across**2
            + min(takes_s, takes_l) * across
        )
        level += through[0] * through[1] * across / lost
    if graph.node_object[node] == graph.node_object[listener]:
        index = int(graph.node_object[node])
        away = math.dist(graph.node_position[node], graph.node_position[listener])
        reach = 0.0 if graph.reach is None else float(graph.reach[listener])
        straight = balance.squared(index, max(0.0, away - reach))
        if all(region[0] != index for region in balance.regions):
            return mpmath.mpf(straight)
        put_in, heard = ends
        both = [k for k in put_in if k in heard]
        kept = {
            k: total[k] + balance.mass[balance.regions[k]] * (1 - balance.uptake[index])
            for k in both
        }
        inside = {
            k: 1 / balance.mean_squared(balance.regions[k]) for k in both if balance.passes[k]
        }
        left = sum(put_in[k][0] * heard[k][0] * inside.get(k, 1.0) / kept[k] for k in both)
        spread = sum(put_in[k][1] * heard[k][1] / kept[k] for k in both)
        level += min(1.0, left) * straight - spread
    return level


def solved(
    total: list[float], couplings: dict[tuple[int, int], float], power: list[float]
) -> list[mpmath.mpf]:
    """Energies of the balance with diagonal ``total`` and ``couplings``: LU in double precision,
    refined with residuals of 40 digits."""
    matrix = np.diag(np.array(total))
    for (a, b), value in couplings.items():
        matrix[a, b] -= value
    with mpmath.workdps(40):
        energy, residual = [mpmath.mpf(0)] * len(total), [mpmath.mpf(part) for part in power]
        for _ in range(40):
            scale = max(abs(part) for part in residual)
            if scale <= mpmath.mpf(max(power)) * 1e-25:  # no double: it may be below all of them
                return energy
            step = np.linalg.solve(matrix, [float(part / scale) for part in residual])
            energy = [
                known + scale * mpmath.mpf(float(part))
                for known, part in zip(energy, step, strict=True)
            ]
            residual = [
                mpmath.mpf(put) - mpmath.mpf(own) * known
                for put, own, known in zip(power, total, energy, strict=True)
            ]
            for (a, b), value in couplings.items():
                residual[a] += mpmath.mpf(value) * energy[b]
    raise ArithmeticError("the refinement does not converge")
