"""What a case of the zoo is: a whole model, what is wrong with it, and what follows from that."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from graben.model import Model


@dataclass(frozen=True, eq=False)
class Case:
    """A model and what the gate must say of it.

    Parameters
    ----------
    name : str
        Unique within its check.
    check : str
        The check that it fails, or that it comes close to and passes.
    model : Model
        The whole model: the gate itself computes everything from it.
    place : sequence of float, of such sequences, or None
        Where it is wrong (x, y, elevation; None for a coordinate that cannot be told), or all such places
        where it is as wrong in several, or None where the defect is everywhere.
    objects : tuple of str
        The objects of the finding.
    extended, paper : str
        The status under each profile.
    blocks : bool
        Whether it keeps something from being modeled.
    follows : tuple of str
        Other checks that the same defect fails or warns of, as it must.
    """

    name: str
    check: str
    model: Model
    place: Sequence[float | None] | Sequence[Sequence[float | None]] | None = None
    objects: tuple[str, ...] = ("F",)
    extended: str = "fail"
    paper: str = "fail"
    blocks: bool = False
    follows: tuple[str, ...] = ()
