"""Draw a model that fails each check, for its page: `python docs/make_check_pictures.py [CHECK ...]`.

The models are those of the tests; each picture is the one that the report shows of the finding.
"""

from __future__ import annotations

import base64
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT))

from graben.finding import Profile  # noqa: E402
from graben.pipeline import examine  # noqa: E402
from graben.reports.check_figures import finding_picture  # noqa: E402
from graben.reports.scenery import Scenery  # noqa: E402
from graben.validators.registry import CHECKS, known_ids  # noqa: E402
from tests.zoo import FAILING  # noqa: E402

#: The case that is shown, where it is not the first of its check.
SHOWN = {
    "degenerate": "sliver",
    "duplicate": "crack",
    "functional": "overturned fault",
    "min-dip": "listric below",
    "strongly-connected": "crumb",
    "acyclic": "large triangle",
}
#: Bytes of a picture.
MOST = 120_000
#: What they show, by the names of their files.
PICTURES = {f"check-{check.id}": f"{check.id}: a model that fails it." for check in CHECKS}


def drawn(check: str) -> tuple[bytes, str]:
    """Return the picture (PNG) of a check's case and its caption."""
    cases = [c for c in FAILING if c.check == check]
    case = next(c for c in cases if c.name == SHOWN.get(check, cases[0].name))
    seen = examine(case.model, Profile.PAPER)
    finding = seen.result.of(check)[0]
    picture = finding_picture(Scenery.of(seen), finding, MOST)
    if picture is None:
        raise SystemExit(f"{check}: {case.name} has no place to draw")
    kind, _, content = picture.source.partition(",")
    assert "png" in kind
    return base64.b64decode(content), f"{case.name}: {finding.message} {picture.caption}"


def main(wanted: list[str]) -> int:
    """Write the pictures of the checks asked for, else of all."""
    for check in wanted or known_ids():
        content, caption = drawn(check)
        (ROOT / "docs" / "images" / f"check-{check}.png").write_bytes(content)
        print(f"{check}: {caption}")
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
