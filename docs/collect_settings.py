"""Put the keys of model.toml into their page: `python docs/collect_settings.py`.

Types, ranges and defaults are those of the classes that read the file; what a key means stands here. A key
without a meaning, and a meaning without a key, end the script. A test holds the page to the classes.
"""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

from between_marks import write

from graben.settings import ModelFile
from graben.validators.registry import CHECKS

DOCS = Path(__file__).resolve().parent
#: Numbers so large that a limit by them is none to a user.
ENDLESS = 1e20

#: What each table is, and for each of its keys what it means and, where the class has none, the default.
TABLES: dict[str, tuple[str, dict[str, tuple[str, str]]]] = {
    "[model]": (
        "Once. What the model is called and how its files count.",
        {
            "name": ("name of the model, in reports", ""),
            "z": (
                "how files that do not state their own sign count: `elevation` is positive up, `depth` "
                "positive down; outputs count the same way",
                "",
            ),
            "unit": ("unit of all lengths", ""),
            "crs": ("coordinate system, carried through to the outputs, such as `EPSG:23031`", "none"),
            "truth": ("folder with the [known answer](demo-models.md); the run then scores itself", "none"),
        },
    ),
    "[[horizons]]": (
        "One for each horizon.",
        {
            "name": ("name; of a file with several surfaces, the one that is taken", ""),
            "file": ("grid, triangulated surface or points: [formats](formats.md)", ""),
            "step": (
                "node spacing, for points and triangulated surfaces; a grid keeps its own",
                "[from the surface](conventions.md#step)",
            ),
            "noise": (
                "standard deviation of the picks, model units; 0 takes the nodes as they are",
                "estimated: [the method](method.md)",
            ),
        },
    ),
    "[[faults]]": (
        "One for each fault, or for each file of faults.",
        {
            "name": (
                "name; without it every surface of the file is a fault, by its own name",
                "from the file",
            ),
            "file": ("triangulated surface, or fault sticks: [formats](formats.md)", ""),
            "gamma": ("gamma of this fault alone", "`gamma` of [parameters]"),
        },
    ),
    "[parameters]": (
        "Of the rebuilding. How to choose them: [the full run](howto-run.md).",
        {
            "theta": ("weight of the bends against the slope in [the energy](theta.md)", ""),
            "length": (
                "the length that gives both terms of the energy one unit",
                "10 times the widest gamma of the subdomain",
            ),
            "gamma": (
                "half-width, in plan, of the zone beside a fault that is rebuilt",
                "4 steps of the horizon",
            ),
            "tolerance": (
                "largest change of a cut node, and its distance from the fault, at which the iteration ends",
                "1e-5 of the model's size, at most 0.1 m (0.33 ft; unit `none`: no limit)",
            ),
            "max_iterations": ("iterations after which a subdomain is given up (type 1)", ""),
            "min_dip": ("dip below which the check [min-dip](checks/min-dip.md) warns, degrees", ""),
            "acceleration": ("`false`: the plain iteration of the paper", ""),
        },
    ),
    "[repair]": (
        "Limits of [repair](repair.md).",
        {
            "max_move": (
                "how far a vertex of the result may lie from the surface that was given",
                "half the least step of the horizons; with none, half the median edge of the fault",
            ),
            "max_extension": (
                "how far a fault may be extended or cut back at a contact, and half the width of a hole that "
                "is filled; the default limit of the check [near-miss](checks/near-miss.md)",
                "5 max_move",
            ),
            "dip_floor": ("dip that the repair of z-monotone aims at, degrees", ""),
            "steepen": ("`true`: what dips less than `min_dip` is repaired as well", ""),
            "warnings": ("`false`: only failures are repaired", ""),
            "skip": ("repairs switched off, by their [names](repairs.md)", ""),
        },
    ),
    "[[contacts]]": (
        "One for each pair of faults of which more is known than the surfaces tell.",
        {
            "faults": ("the two faults, by name", ""),
            "rule": (
                "`accept`: they stay as they are; `force`: they are to meet; `forbid`: they must not",
                "",
            ),
        },
    ),
    "[checks]": (
        "Tolerances, named as their checks; their pages say what they do.",
        {},
    ),
}


def page() -> str:
    """Return the tables of all keys."""
    schema = ModelFile.model_json_schema()
    parts = []
    for title, (sentence, meanings) in TABLES.items():
        table = title.strip("[]")
        parts.append(f"## {title}\n{sentence}")
        if table == "checks":
            parts.append(tolerances())
        else:
            parts.append(keys(_resolved(schema["properties"][table], schema), meanings, title))
    if {t.strip("[]") for t in TABLES} != set(schema["properties"]):
        raise SystemExit("the tables of model.toml are others than those told here")
    return "\n\n".join(parts)


def keys(section: dict[str, Any], meanings: dict[str, tuple[str, str]], title: str) -> str:
    """Return the table of the keys of a section."""
    known = section["properties"]
    if list(known) != list(meanings):
        raise SystemExit(f"{title}: the keys are {', '.join(known)}, told are {', '.join(meanings)}")
    lines = ["| key | value | default | means |", "|---|---|---|---|"]
    for key, about in known.items():
        meaning, absent = meanings[key]
        needed = key in section.get("required", ())
        default = "**needed**" if needed else absent or _toml(about["default"])
        lines.append(f"| `{key}` | {_kind(about)} | {default} | {meaning} |")
    return "\n".join(lines)


def tolerances() -> str:
    """Return the table of the checks that have a tolerance."""
    lines = ["| key | unit | default | means |", "|---|---|---|---|"]
    for check in CHECKS:
        if check.tolerance is not None:
            t = check.tolerance
            name = f"[{check.id}](checks/{check.id}.md)"
            lines.append(f"| {name} | {t.unit} | {t.default} | {t.meaning} |")
    return "\n".join(lines)


def _resolved(about: dict[str, Any], schema: dict[str, Any]) -> dict[str, Any]:
    """Return the schema of a section, or of the entries of a list of sections."""
    about = about.get("items", about)
    found: dict[str, Any] = schema["$defs"][about["$ref"].rpartition("/")[2]]
    return found


def _kind(about: dict[str, Any]) -> str:
    """Return in words what a key takes."""
    about = next((a for a in about.get("anyOf", ()) if a.get("type") != "null"), about)
    if "enum" in about:
        return ", ".join(f'`"{value}"`' for value in about["enum"])
    if about["type"] == "array":
        return "list of texts" if "prefixItems" not in about else f"list of {len(about['prefixItems'])} texts"
    word = {"string": "text", "boolean": "`true`, `false`", "number": "number", "integer": "whole number"}
    return word[about["type"]] + _range(about)


def _range(about: dict[str, Any]) -> str:
    least = f" from {about['minimum']:g}" if "minimum" in about else ""
    least = f" above {about['exclusiveMinimum']:g}" if "exclusiveMinimum" in about else least
    most = f" to {about['maximum']:g}" if "maximum" in about else ""
    if about.get("exclusiveMaximum", ENDLESS) < ENDLESS:
        most = f" and below {about['exclusiveMaximum']:g}"
    return least + most


def _toml(value: object) -> str:
    if isinstance(value, list | tuple):
        return "none"
    return f"`{str(value).lower()}`" if isinstance(value, bool) else f"`{value}`"


def pages() -> dict[Path, str]:
    """Return what stands between the marks of each page."""
    return {DOCS / "model-toml.md": page()}


if __name__ == "__main__":
    sys.exit(write(pages()))
