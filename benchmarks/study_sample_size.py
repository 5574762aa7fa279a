"""How many people a study of the four renderings needs, by simulation.

python -m benchmarks.study_sample_size

Every person rates four conditions on a scale of seven steps. Ratings are normal with means that are
evenly spaced over the conditions, and rounded to steps; people differ in how high they rate, which
ranks take out. The spacing is set so that Kendall's W, the effect that Friedman's test sees, is
that of the published ratings: W = chi-square / (people * 3). Power: the share of simulated studies
with p < 0.05 in Friedman's test (F), and with all of the three neighbouring pairs below 0.05 in
Wilcoxon's, corrected by Holm (W).
"""

from __future__ import annotations

import numpy as np
from scipy.optimize import brentq
from scipy.stats import friedmanchisquare, wilcoxon

PEOPLE, CONDITIONS, STEPS = 40, 4, 7
PUBLISHED = {"realism": 15.5, "expressivity": 14.1}
STUDIES = 1000


def ratings(generator: np.random.Generator, people: int, spacing: float) -> np.ndarray:
    """Ratings (people, conditions) from 1 to 7."""
    means = 4 + spacing * (np.arange(CONDITIONS) - (CONDITIONS - 1) / 2)
    level = generator.normal(0, 1, (people, 1))
    return np.clip(
        np.rint(means + level + generator.normal(0, 1.2, (people, CONDITIONS))), 1, STEPS
    )


def excess(spacing: float, effect: float) -> float:
    """By how much Kendall's W of very many people is above ``effect``."""
    many = ratings(np.random.default_rng(1), 20_000, spacing)
    return float(friedmanchisquare(*many.T).statistic / (len(many) * (CONDITIONS - 1))) - effect


def power(people: int, spacing: float) -> tuple[float, float]:
    """Shares of simulated studies that find a difference, and the order of all neighbours."""
    generator, found, ordered = np.random.default_rng(people), 0, 0
    for _ in range(STUDIES):
        study = ratings(generator, people, spacing)
        found += friedmanchisquare(*study.T).pvalue < 0.05
        pairs = zip(study.T[:-1], study.T[1:], strict=True)
        values = sorted(
            1.0 if np.array_equal(a, b) else float(wilcoxon(a, b, zero_method="zsplit").pvalue)
            for a, b in pairs
        )
        ordered += all(value < 0.05 / (len(values) - k) for k, value in enumerate(values))
    return found / STUDIES, ordered / STUDIES


def main() -> None:
    for name, statistic in PUBLISHED.items():
        effect = statistic / (PEOPLE * (CONDITIONS - 1))
        spacing = brentq(excess, 0.0, 2.0, args=(effect,), xtol=1e-3)
        print(f"{name}: W = {effect:.3f}, neighbouring conditions {spacing:.2f} steps apart")
        for people in (12, 16, 20, 24, 32, 40, 60, 80):
            f, w = power(people, spacing)
            print(f"  {people:3} people: F {f:.2f}  W {w:.2f}")


if __name__ == "__main__":
    main()
