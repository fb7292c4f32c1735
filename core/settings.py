"""The keys of model.toml, validated."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import BaseModel, ConfigDict, Field, FiniteFloat

Name = Annotated[str, Field(min_length=1)]
# Bounded, so that squares and cubes of a length stay finite: no place on Earth is 1e20 units away.
Positive = Annotated[FiniteFloat, Field(gt=0, lt=1e20)]
NotNegative = Annotated[FiniteFloat, Field(ge=0, lt=1e20)]
Angle = Annotated[FiniteFloat, Field(ge=0, lt=90)]


class _Section(BaseModel):
    model_config = ConfigDict(extra="forbid", frozen=True, strict=True)


class ModelSection(_Section):
    """The table [model]."""

    name: Name
    z: Literal["elevation", "depth"] = "elevation"
    unit: Literal["m", "ft", "none"] = "m"
    crs: str | None = None
    truth: str | None = None


class HorizonSection(_Section):
    """One [[horizons]]: a grid, a triangulated surface or points."""

    name: Name
    file: Name
    step: Positive | None = None
    noise: NotNegative | None = None


class FaultSection(_Section):
    """One [[faults]]: a triangulated surface or fault sticks."""

    name: Name | None = None
    file: Name
    gamma: Positive | None = None


class Parameters(_Section):
    """The table [parameters] of the variational problem (paper Sect. 2, 4, 7)."""

    theta: Annotated[FiniteFloat, Field(ge=0, le=1)] = 0.5
    length: Positive | None = None
    gamma: Positive | None = None
    tolerance: Positive | None = None
    max_iterations: Annotated[int, Field(ge=1)] = 50
    min_dip: Angle = 30.0
    acceleration: bool = True


class RepairSettings(_Section):
    """The table [repair]."""

    max_move: Positive | None = None
    max_extension: Positive | None = None
    dip_floor: Angle = 1.0
    steepen: bool = False
    warnings: bool = True
    skip: tuple[str, ...] = Field(default=(), strict=False)


class ContactRule(_Section):
    """One [[contacts]]: what is meant where two faults meet."""

    faults: tuple[Name, Name] = Field(strict=False)
    rule: Literal["accept", "forbid", "force"]


class ModelFile(_Section):
    """The whole of model.toml."""

    model: ModelSection
    horizons: tuple[HorizonSection, ...] = Field(default=(), strict=False)
    faults: tuple[FaultSection, ...] = Field(default=(), strict=False)
    parameters: Parameters = Parameters()
    repair: RepairSettings = RepairSettings()
    contacts: tuple[ContactRule, ...] = Field(default=(), strict=False)
    checks: dict[str, NotNegative] = Field(default={})
