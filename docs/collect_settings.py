"""Put the keys of model.toml into their page: `python docs/collect_settings.py`.

Types, ranges, defaults and meanings are those of the classes that read the file; the page adds links. A key
without a meaning, and a link without its words, end the script. A test holds the page to the classes.
"""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

from between_marks import write
from pydantic import BaseModel

from graben.formats.model_file import SECTIONS
from graben.settings import ModelFile, meaning
from graben.validators.registry import CHECKS

DOCS = Path(__file__).resolve().parent
#: Numbers so large that a limit by them is none to a user.
ENDLESS = 1e20

#: By a table, or a table and its key: words that are said of it, and the page that they lead to.
LINKS = {
    "model.truth": ("known answer", "demo-models.md"),
    "horizons.file": ("grid, triangulated surface or points", "formats.md"),
    "horizons.step": ("from the surface", "conventions.md#step"),
    "horizons.noise": ("estimated", "method.md"),
    "faults.file": ("triangulated surface, or fault sticks", "formats.md"),
    "parameters": ("rebuilding", "howto-run.md"),
    "parameters.theta": ("the energy", "theta.md"),
    "parameters.min_dip": ("min-dip", "checks/min-dip.md"),
    "repair": ("repair", "repair.md"),
    "repair.max_extension": ("near-miss", "checks/near-miss.md"),
    "repair.skip": ("names", "repairs.md"),
}


def page() -> str:
    """Return the tables of all keys."""
    schema = ModelFile.model_json_schema()
    parts = []
    for table, about in schema["properties"].items():
        title = f"[[{table}]]" if "items" in about else f"[{table}]"
        said = linked(meaning(ModelFile, table)[0], table)
        parts.append(f"## {title}\n{said[:1].upper()}{said[1:]}.")
        parts.append(keys(_resolved(about, schema), table) if table in SECTIONS else tolerances())
    unused = {name for name in LINKS if not _has(name)}
    if unused:
        raise SystemExit(f"there is nothing to link at {', '.join(sorted(unused))}")
    return "\n\n".join(parts)


def _has(name: str) -> bool:
    """Return whether a table, or a table and its key, exists."""
    table, _, key = name.partition(".")
    return table in ModelFile.model_fields and (not key or key in SECTIONS[table].model_fields)


def linked(text: str, name: str) -> str:
    """Return what is said of a table or key, with its link."""
    words, target = LINKS.get(name, ("", ""))
    return text.replace(words, f"[{words}]({target})", 1) if words else text


def keys(known: dict[str, Any], table: str) -> str:
    """Return the table of the keys of a section."""
    section: type[BaseModel] = SECTIONS[table]
    lines = ["| key | value | default | means |", "|---|---|---|---|"]
    for key, about in known["properties"].items():
        means, absent = meaning(section, key)
        if not means:
            raise SystemExit(f"[{table}] {key} has no meaning: describe it in core/settings.py")
        name = f"{table}.{key}"
        if name in LINKS and LINKS[name][0] not in f"{absent}; {means}":
            raise SystemExit(f"nothing that is said of {name} reads {LINKS[name][0]!r}")
        default = "**needed**" if key in known.get("required", ()) else absent or _toml(about["default"])
        lines.append(f"| `{key}` | {_kind(about)} | {linked(default, name)} | {linked(means, name)} |")
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
    return f"`{str(value).lower()}`" if isinstance(value, bool) else f"`{value}`"


def pages() -> dict[Path, str]:
    """Return what stands between the marks of each page."""
    return {DOCS / "model-toml.md": page()}


if __name__ == "__main__":
    sys.exit(write(pages()))
