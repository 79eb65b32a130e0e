# SPDX-License-Identifier: MIT
"""Ratios of times with 95 % intervals, as docs/benchmarking.md defines them: geometric means, Student's t on logarithms."""
import dataclasses
import math
import statistics
from typing import Any, Optional

# Student's t of 97.5 % for 1 to 30 degrees of freedom; above, the first two terms of its expansion.
T_975 = (12.706, 4.303, 3.182, 2.776, 2.571, 2.447, 2.365, 2.306, 2.262, 2.228, 2.201, 2.179, 2.160, 2.145, 2.131,
         2.120, 2.110, 2.101, 2.093, 2.086, 2.080, 2.074, 2.069, 2.064, 2.060, 2.056, 2.052, 2.048, 2.045, 2.042)


def t_factor(freedom: float) -> float:
    """`freedom` is rounded down, which makes intervals wider, never narrower."""
    whole = max(1, int(freedom))
    return T_975[whole - 1] if whole <= len(T_975) else 1.960 + 2.44 / whole


@dataclasses.dataclass
class Ratio:
    value: float
    low: Optional[float] = None   # None: one sample has no interval
    high: Optional[float] = None


@dataclasses.dataclass
class Sample:
    """Mean of logarithms, its squared standard error (None: one sample), and degrees of freedom."""
    mean: float
    error2: Optional[float]
    freedom: int


def sample_of(logs: list[float]) -> Sample:
    n = len(logs)
    return Sample(statistics.fmean(logs), statistics.variance(logs) / n if n > 1 else None, n - 1)


def mean_of(samples: list[Sample]) -> Ratio:
    """The geometric mean of ratios that were measured on their own, such as the scenes of a set.

    The interval covers the noise within the samples and not the choice of scenes; degrees of freedom by Welch and
    Satterthwaite.
    """
    mean = statistics.fmean(sample.mean for sample in samples)
    if any(sample.error2 is None for sample in samples):
        return Ratio(math.exp(mean))
    errors = [(sample.error2 or 0) / len(samples) ** 2 for sample in samples]
    total = sum(errors)
    below = sum(error ** 2 / sample.freedom for error, sample in zip(errors, samples))
    half = t_factor(total ** 2 / below if below > 0 else 1) * math.sqrt(total)
    return Ratio(math.exp(mean), math.exp(mean - half), math.exp(mean + half))


def paired(rows: list[dict[str, Any]], mode: str, other: str) -> Optional[Sample]:
    """How many times as fast as `other` a mode is, from the rows of one bench.json: cameras are the samples."""
    def logs(name: str) -> dict[int, float]:
        return {row["view"]: statistics.fmean(math.log(ms) for ms in row.get("round_ms") or [row["ms_median"]])
                for row in rows if row["mode"] == name and row["ms_median"] > 0}
    fast, slow = logs(mode), logs(other)
    both = [slow[view] - fast[view] for view in fast if view in slow]
    return sample_of(both) if both else None
