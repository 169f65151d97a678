"""What `sim.report()` returns, and `report.json` of a run holds. A quantity that was not measured is missing."""

from __future__ import annotations

from typing import TypedDict

__all__ = ["Report"]


class Adapter(TypedDict):
    """The adapter that ran."""

    name: str
    backend: str
    driver: str
    kind: str
    """"discrete", "integrated", "virtual", "software" or "other"."""


class Particles(TypedDict):
    """Numbers of particles."""

    hair: int
    """Points of all strands."""
    air: int
    """Air particles."""
    hair_outside_box: int
    """Hair points that are outside the box of air now."""


class Skipped(TypedDict):
    """A pass that the scene does not need."""

    name: str
    """Label of the pass."""
    why: str
    """The reason."""


class _OfABand(TypedDict, total=False):
    band: int


# A class cannot have the word `pass` as an attribute.
_Pass = TypedDict("_Pass", {"stage": str, "name": str, "pass": str, "ms": float, "runs": int})


class Pass(_Pass, _OfABand):
    """GPU time [ms] of all `runs` of a pass in a step; `band` is the index of the band in turbulence.bands that it is for."""


class _Timed(TypedDict, total=False):
    ms: float


class BandEnergy(_Timed):
    """A band of eddies: the mean of ½ |û|² over the air, about the mean wind, and its GPU time in a step, `ms`."""

    scale: float
    """Scale s [m]."""
    m2_per_s2_at_start: float
    """Energy at t = 0 [m²/s²]."""
    m2_per_s2: float
    """Energy now [m²/s²]."""


class BodyImpulse(TypedDict):
    """A body in the air."""

    name: str
    """Name of the body."""
    impulse_kg_m_per_s: list[float]
    """Impulse that the air has given it in the run, by pressure and friction."""


class Warning(TypedDict):
    """A warning: the scene is valid, or the run goes on, but it may not do as expected."""

    code: str
    """Kind of the warning: `unread_key`, `strand_reset`."""
    key: str
    """Key or table of the scene that it is about; empty where it is about none."""
    text: str
    """The warning in words."""
    count: int
    """How often its cause acted in the run; 0 for a warning about the scene."""


class Changed(TypedDict):
    """An update of the scene in the run, as one of `[[change]]`."""

    time: float
    """Time of the update [s]."""
    over: float
    """0: at once."""
    set: list[list[str]]
    """Dotted keys, each with its value as TOML."""


class Reset(TypedDict):
    """Strands or air that were reset because a value was not finite or too large."""

    step: int
    """Step of time.step, from 0, in which it was found."""
    time_s: float
    """Time at the start of that step."""
    strands: int
    """Number of strands that were put into their rest shape."""
    named: list[int]
    """Indices of some of them."""
    air: bool
    """Whether all air was put where it was at the start."""
    recovered: bool
    """Whether the run had ended there and was made to go on."""


class Failure(TypedDict):
    """Why a run ended before its time."""

    step: int
    """Step of time.step, from 0, that could not be taken."""
    time_s: float
    """Time at the start of that step."""
    why: str
    """The error, in words."""


class _Measured(TypedDict, total=False):
    commit: str
    """Commit that windswept was built from."""
    failure: Failure
    """Why the run ended before its time; in `report.json` alone."""
    changes: list[Changed]
    """Updates of the scene in the run."""
    ms_per_step: float
    """Median wall time of a step, the first excluded."""
    ms_first_step: float
    """Wall time of the first step, in which drivers may compile pipelines."""
    passes: list[Pass]
    """GPU time of each pass."""
    max_stretch: float
    """Largest stretch of a segment over the run, |l/l0 - 1|."""
    strand_steps: dict[str, int]
    """Steps of strands that went otherwise than by a solve: `euler_steps`, `sleeping_steps`, `teleports`, `unsolved_steps`."""
    density_error_rms: float
    """rms of ρ/ρ0 - 1 over the air."""
    over_density_rms: float
    """rms of max(ρ/ρ0 - 1, 0) over the air."""
    confinement_impulse_kg_m_per_s: list[float]
    """Impulse that confinement has given the air, after its mean was taken out."""
    bodies: list[BodyImpulse]
    """Bodies, and what the air has given them."""
    confinement_limited_steps: int
    """Steps in which the confinement's limiter acted on some particle."""
    band_energy: list[BandEnergy]
    """Energy and cost of each of turbulence.bands."""
    resets: list[Reset]
    """Strands and air that were reset in the run; the first thousand."""


class Report(_Measured):
    """The report of a run so far."""

    schema: int
    """Version of this schema."""
    windswept: str
    """Version of windswept."""
    scene: str
    """Title of the scene."""
    method: str
    """"accurate" or "published"."""
    adapter: Adapter
    """The adapter that ran."""
    variant: str
    """Variant of the shaders: "subgroups", "workgroup" or "software"."""
    particles: Particles
    """Numbers of particles."""
    steps: int
    """Steps since t = 0."""
    time_s: float
    """Time reached."""
    ms_setup: float
    """Wall time of making the simulation from its initial state."""
    skipped: list[Skipped]
    """Passes that the scene does not need."""
    momentum_kg_m_per_s: list[float]
    """Momentum Σ m v of hair and air, without clamped roots."""
    memory_bytes: int
    """Size of the engine's buffers."""
    warnings: list[Warning]
    """Warnings about the scene, and those whose cause acted in the run."""
