"""The keys of model.toml, validated; what each means stands with it."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import BaseModel, ConfigDict, Field, FiniteFloat

Name = Annotated[str, Field(min_length=1)]
# Bounded, so that squares and cubes of a length stay finite: no place on Earth is 1e20 units away.
Positive = Annotated[FiniteFloat, Field(gt=0, lt=1e20)]
NotNegative = Annotated[FiniteFloat, Field(ge=0, lt=1e20)]
Angle = Annotated[FiniteFloat, Field(ge=0, lt=90)]
#: Parts what a key means from its default in words, where its class has no value.
_DEFAULT = "; default: "


class _Section(BaseModel):
    model_config = ConfigDict(extra="forbid", frozen=True, strict=True)


class ModelSection(_Section):
    """The table [model]."""

    name: Name = Field(description="name of the model, in reports")
    z: Literal["elevation", "depth"] = Field(
        default="elevation",
        description="how files that do not state their own sign count: `elevation` is positive up, `depth` "
        "positive down; outputs count the same way",
    )
    unit: Literal["m", "ft", "none"] = Field(default="m", description="unit of all lengths")
    crs: str | None = Field(
        default=None,
        description="coordinate system, carried through to the outputs, such as `EPSG:23031`; default: none",
    )
    truth: str | None = Field(
        default=None,
        description="folder with the known answer; the run then scores itself; default: none",
    )


class HorizonSection(_Section):
    """One [[horizons]]: a grid, a triangulated surface or points."""

    name: Name = Field(
        description="name of the horizon; where its file holds several surfaces, also which of them it is"
    )
    file: Name = Field(description="grid, triangulated surface or points")
    step: Positive | None = Field(
        default=None,
        description="node spacing, for points and triangulated surfaces; a grid keeps its own; default: from "
        "the surface",
    )
    noise: NotNegative | None = Field(
        default=None,
        description="standard deviation of the picks, model units; 0 takes the nodes as they are; default: "
        "estimated",
    )


class FaultSection(_Section):
    """One [[faults]]: a triangulated surface or fault sticks."""

    name: Name | None = Field(
        default=None,
        description="name; without it every surface of the file is a fault, by its own name; default: from "
        "the file",
    )
    file: Name = Field(description="triangulated surface, or fault sticks")
    gamma: Positive | None = Field(
        default=None, description="gamma of this fault alone; default: `gamma` of [parameters]"
    )


class Parameters(_Section):
    """The table [parameters] of the variational problem (paper Sect. 2, 4, 7)."""

    theta: Annotated[FiniteFloat, Field(ge=0, le=1)] = Field(
        default=0.5, description="weight of the bends against the slope in the energy"
    )
    length: Positive | None = Field(
        default=None,
        description="the length that gives both terms of the energy one unit; default: 10 times the widest "
        "gamma of the subdomain",
    )
    gamma: Positive | None = Field(
        default=None,
        description="half-width, in plan, of the zone beside a fault that is rebuilt; default: 4 steps of "
        "the horizon",
    )
    tolerance: Positive | None = Field(
        default=None,
        description="largest change of a cut node, and its distance from the fault, at which the iteration "
        "ends; default: 1e-5 of the model's size, at most 0.1 m (0.33 ft; unit `none`: no limit)",
    )
    max_iterations: Annotated[int, Field(ge=1)] = Field(
        default=50, description="iterations after which a subdomain is given up (type 1)"
    )
    min_dip: Angle = Field(default=30.0, description="dip below which the check min-dip warns, degrees")
    acceleration: bool = Field(default=True, description="`false`: the plain iteration of the paper")


class RepairSettings(_Section):
    """The table [repair]."""

    max_move: Positive | None = Field(
        default=None,
        description="how far a vertex of the result may lie from the surface that was given; default: half "
        "the least step of the horizons; with none, half the median edge of the fault",
    )
    max_extension: Positive | None = Field(
        default=None,
        description="how far a fault may be extended or cut back at a contact, and half the width of a hole "
        "that is filled; the default limit of the check near-miss; default: 5 max_move",
    )
    dip_floor: Angle = Field(default=1.0, description="dip that the repair of z-monotone aims at, degrees")
    steepen: bool = Field(
        default=False, description="`true`: what dips less than `min_dip` is repaired as well"
    )
    warnings: bool = Field(default=True, description="`false`: only failures are repaired")
    skip: tuple[str, ...] = Field(
        default=(), strict=False, description="repairs switched off, by their names; default: none"
    )


class ContactRule(_Section):
    """One [[contacts]]: what is meant where two faults meet."""

    faults: tuple[Name, Name] = Field(strict=False, description="the two faults, by name")
    rule: Literal["accept", "forbid", "force"] = Field(
        description="`accept`: they stay as they are; `force`: they are to meet; `forbid`: they must not"
    )


class ModelFile(_Section):
    """The whole of model.toml."""

    model: ModelSection = Field(description="what the model is called and how its files count")
    horizons: tuple[HorizonSection, ...] = Field(default=(), strict=False, description="one for each horizon")
    faults: tuple[FaultSection, ...] = Field(
        default=(), strict=False, description="one for each fault, or for each file of faults"
    )
    parameters: Parameters = Field(default=Parameters(), description="of the rebuilding")
    repair: RepairSettings = Field(default=RepairSettings(), description="limits of repair")
    contacts: tuple[ContactRule, ...] = Field(
        default=(),
        strict=False,
        description="one for each pair of faults of which more is known than the surfaces tell",
    )
    checks: dict[str, NotNegative] = Field(
        default={}, description="tolerances, named as their checks; their pages say what they do"
    )


def meaning(section: type[BaseModel], key: str) -> tuple[str, str]:
    """Return what a key of a section means, and its default in words; no words where it has a value or none.

    >>> meaning(Parameters, "gamma")
    ('half-width, in plan, of the zone beside a fault that is rebuilt', '4 steps of the horizon')
    """
    means, _, default = (section.model_fields[key].description or "").partition(_DEFAULT)
    return means, default
