"""Runs the checks of the registry in the order in which they can run, and puts the findings in its order."""

from __future__ import annotations

from collections.abc import Container, Mapping
from dataclasses import replace
from types import MappingProxyType
from typing import TypeVar

from graben.arrays import FloatArray
from graben.complexes import Complex
from graben.cutgraph import CutGraph
from graben.errors import ModelingError
from graben.finding import CheckResult, Finding, Profile, Status
from graben.model import Model
from graben.validators.context import (
    Anchoring,
    Check,
    CheckContext,
    Evidence,
    Need,
    Providers,
    Severity,
)
from graben.validators.course import Course
from graben.validators.measuring.contacts import Contact, KnownContacts, contacts
from graben.validators.registry import CHECKS

Value = TypeVar("Value")


def run_checks(
    model: Model,
    profile: Profile,
    providers: Providers,
    through: Need = Need.ANCHORS,
    warning: Container[str] | None = None,
    known: KnownContacts | None = None,
) -> tuple[CheckResult, Evidence]:
    """Run every check that can run.

    The surfaces are looked at first; the complex, the cut graphs and the anchoring are asked of
    ``providers`` only where no failure stands against it.

    Parameters
    ----------
    model : Model
        In its local frame: places in the findings are in that frame too, see :func:`shifted`.
    profile : Profile
        Which defects fail.
    providers : Providers
        What computes the rest.
    through : Need
        The last stage to run; checks of later ones are left out of the result.
    warning : container of str, optional
        Of the checks that can only warn, the ids of those to run; the others are left out of the result.
        By default all run.
    known : KnownContacts, optional
        What is known of pairs of surfaces from earlier runs; what this one finds is added.

    Returns
    -------
    result : CheckResult
        Findings in the order of the registry, then of the model.
    evidence : Evidence
        What was computed on the way, and what blocks modeling.
    """
    checks = [c for c in CHECKS if warning is None or c.severity is not Severity.WARN or c.id in warning]
    names = tuple(h.name for h in model.horizons)
    course = Course(checks, profile, CheckContext(model, frozenset(), Evidence(horizons=names)))
    for need in (n for n in Need if n <= through):
        course.context = _supplied_ahead(course, providers, need, known)
        if need in (Need.GRAPH, Need.ANCHORS):
            course.join()
            course.context = _unblocked(course.context, need)
        course.run(need)
    course.join()
    context, said = course.context, course.said
    order = {s.name: k for k, s in enumerate(model.surfaces)}
    findings: list[Finding] = []
    for check in (c for c in checks if (c.stage or c.need) <= through):
        own = sorted(said.get(check.id, ()), key=lambda f: [order[name] for name in f.objects])
        findings += own or [_empty(check, context)]
    return CheckResult(profile, tuple(findings), model.z_factor), context.evidence


def shifted(result: CheckResult, offset: FloatArray) -> CheckResult:
    """Return the result with all places moved by ``offset``, shape (3,), model units."""
    return replace(result, findings=tuple(f.moved(offset) for f in result.findings))


def _supplied_ahead(
    course: Course, providers: Providers, need: Need, known: KnownContacts | None
) -> CheckContext:
    """Return the context with what ``need`` asks for, while checks of horizons may still run beside.

    Of a horizon that these turn out to block anything may come; what is no fault of it comes again.
    """
    try:
        return _supplied(course.context, providers, need, known)
    except Exception:
        if not course.waits:
            raise
        course.join()
        return _supplied(course.context, providers, need, known)


def _supplied(
    context: CheckContext, providers: Providers, need: Need, known: KnownContacts | None
) -> CheckContext:
    """Return the context with what ``need`` asks for, as far as nothing stands against it."""
    model, evidence = context.model, context.evidence
    errors = dict(evidence.errors)
    if need is Need.COMPLEX:
        shape: Complex | None = None
        if not any(not set(evidence.horizons).intersection(f.objects) for f in evidence.blocking):
            try:
                shape = providers.complex(model)
            except ModelingError as error:
                errors[""] = str(error)
        met: tuple[Contact, ...] = ()
        if shape is not None:
            met = contacts([f.surface for f in model.faults], shape, context.contact, known)
        evidence = replace(evidence, complex=shape, contacts=met, errors=MappingProxyType(errors))
        return replace(context, evidence=evidence)
    places = dict(evidence.places)
    graphs: dict[str, CutGraph] = dict(evidence.graphs)
    anchors: dict[str, tuple[Anchoring, ...]] = dict(evidence.anchors)
    if need in (Need.GRAPH, Need.ANCHORS) and evidence.complex is not None:
        for horizon in context.horizons:
            if evidence.blocked(horizon.name) or horizon.name in errors:
                continue
            try:
                if need is Need.GRAPH:
                    graphs[horizon.name] = providers.graph(model, horizon, evidence.complex)
                elif horizon.name in graphs:
                    anchors[horizon.name] = providers.anchoring(model, horizon, graphs[horizon.name])
            except ModelingError as error:
                errors[horizon.name] = str(error)
                if error.place is not None:
                    places[horizon.name] = error.place
    evidence = replace(
        evidence,
        graphs=MappingProxyType(graphs),
        anchors=MappingProxyType(anchors),
        errors=MappingProxyType(errors),
        places=MappingProxyType(places),
    )
    return replace(context, evidence=evidence)


def _unblocked(context: CheckContext, need: Need) -> CheckContext:
    """Return the context without what a stage made for horizons that turned out to be blocked meanwhile."""
    evidence = context.evidence
    asked = evidence.horizons if need is Need.GRAPH else evidence.graphs
    gone = {name for name in asked if evidence.blocked(name)}
    evidence = replace(
        evidence,
        graphs=_without(evidence.graphs, gone) if need is Need.GRAPH else evidence.graphs,
        anchors=_without(evidence.anchors, gone),
        errors=_without(evidence.errors, gone),
        places=_without(evidence.places, gone),
    )
    return replace(context, evidence=evidence)


def _without(made: Mapping[str, Value], gone: Container[str]) -> Mapping[str, Value]:
    return MappingProxyType({name: value for name, value in made.items() if name not in gone})


def _empty(check: Check, context: CheckContext) -> Finding:
    """Return the one finding of a check that has nothing to say: passed, or what it waits for."""
    reason = _waits_for(check, context)
    if reason:
        return Finding(check.id, Status.SKIPPED, message=reason, repairable=check.repairable)
    return Finding(check.id, Status.PASS, message=check.sentence, repairable=check.repairable)


def _waits_for(check: Check, context: CheckContext) -> str:
    """Return why a check could not look at everything; empty where it could."""
    if check.id == "finite":
        return ""
    evidence, model = context.evidence, context.model
    if check.need >= Need.GRAPH and not model.horizons:
        return "Waits for a horizon: the model has none."
    missing: list[str] = []
    if check.need is Need.SURFACES:
        looked_at = [f.surface for f in model.faults] if check.faults_only else model.surfaces
        missing = [s.name for s in looked_at if s.name not in context.sound]
    elif evidence.complex is None:
        missing = [f.name for f in model.faults]
    elif check.need is not Need.COMPLEX:
        have = evidence.graphs if check.need is Need.GRAPH else evidence.anchors
        missing = [h.name for h in model.horizons if h.name not in have]
    if not missing:
        return ""
    everywhere = [f for f in evidence.blocking if not set(evidence.horizons).intersection(f.objects)]
    own = [f for f in evidence.blocking if set(missing).intersection(f.objects)]
    blockers = list(dict.fromkeys(f.check for f in everywhere + own))
    waits = "waits for " + ", ".join(blockers) if blockers else "could not be prepared"
    return f"Not looked at: {', '.join(missing)}; {waits}."
