"""Collect what the installed packages say of their licences: `python docs/collect_licences.py`.

Writes docs/licences-table.md from the metadata of every package that graben needs, directly or through
another, and of those of its extras that are installed.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from importlib.metadata import Distribution, PackageNotFoundError, distribution
from pathlib import Path

from packaging.requirements import Requirement

TARGET = Path(__file__).resolve().parent / "licences-table.md"
#: In the order in which a package is counted: what it is first needed for.
GROUPS = {"": "run", "resqml": "resqml", "dask": "dask", "test": "test", "bench": "bench", "docs": "docs"}
#: Texts in which packages spell one licence in several ways.
SPELLINGS = {
    r"GPL-?3$": "GPL-3.0",
    r"(the )?MIT( license)?\b.*": "MIT",
    r"BSD 3-Clause.*": "BSD-3-Clause",
    r"BSD 2-Clause.*": "BSD-2-Clause",
    r"Apache( Software License|[ -]2\.0)$": "Apache-2.0",
    r"Mozilla Public License 2\.0.*": "MPL-2.0",
    r"ISC.*": "ISC",
    r"BSD( License)?$": "BSD",
    r"Python Software Foundation License": "PSF",
}


def main() -> None:
    """Write the table."""
    lines = ["| package | version | licence, as it says itself | needed for |", "|---|---|---|---|"]
    for package, group in sorted(needed().items(), key=lambda item: item[0].metadata["Name"].lower()):
        lines.append(f"| {package.metadata['Name']} | {package.version} | {licence(package)} | {group} |")
    TARGET.write_text("\n".join(lines) + "\n", encoding="utf-8", newline="\n")


def needed() -> dict[Distribution, str]:
    """Return every installed package that graben needs, with the first group that needs it."""
    found: dict[str, tuple[Distribution, str]] = {}
    for extra, group in GROUPS.items():
        waiting = list(requirements(distribution("graben"), {extra}))
        while waiting:
            requirement = waiting.pop()
            name = re.sub(r"[-_.]+", "-", requirement.name).lower()
            if name in found:
                continue
            try:
                package = distribution(requirement.name)
            except PackageNotFoundError:
                continue  # an extra that is not installed
            found[name] = package, group
            waiting += requirements(package, {"", *requirement.extras})
    return dict(found.values())


def requirements(package: Distribution, extras: set[str]) -> Iterator[Requirement]:
    """Yield what a package needs on this machine for the given extras; "" is the package itself."""
    for text in package.requires or ():
        requirement = Requirement(text)
        marker = requirement.marker
        if marker is None:
            if "" in extras:
                yield requirement
        elif any(marker.evaluate({"extra": extra}) for extra in extras):
            yield requirement


def licence(package: Distribution) -> str:
    """Return the licence that the metadata name: the expression, else the text, else the classifier."""
    metadata = package.metadata
    if metadata["License-Expression"]:
        return str(metadata["License-Expression"])
    classifiers = [
        c.split("::")[-1].strip() for c in metadata.get_all("Classifier") or [] if c.startswith("License ::")
    ]
    first = (metadata["License"] or "").strip().splitlines()
    if first and len(first) == 1:
        return spelled(first[0])
    named = [spelled(c) for c in classifiers if c not in ("OSI Approved", "DFSG approved")]
    return " or ".join(named) or (spelled(first[0]) if first else "not said")


def spelled(text: str) -> str:
    """Return a licence in its usual spelling."""
    for pattern, usual in SPELLINGS.items():
        if re.match(pattern, text, re.IGNORECASE):
            return usual
    return text


if __name__ == "__main__":
    main()
