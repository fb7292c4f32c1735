"""Put the errors that graben ends with into their page: `python docs/collect_messages.py`.

They are collected from the source: every text that an error is made with, its variable parts as `…`. The
texts of warnings are collected as well, and a test asks that the page speaks of each. A module that is not
told here, and an error without a mend, end the script.
"""

from __future__ import annotations

import ast
import re
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from between_marks import write

from graben import errors

DOCS = Path(__file__).resolve().parent
ROOT = DOCS.parent
FOLDERS = ("core", "cleaning", "modeling", "validators")
KINDS = {name for name, thing in vars(errors).items() if isinstance(thing, type)}
#: Texts with fewer words of their own only hand on what another part says.
LEAST_WORDS = 2
#: Shorter parts of a warning are put into others.
LEAST_OF_WARNING = 5
#: How the variable parts of these names are shown; all others as `…`.
SHOWN = {
    "path": "FILE",
    "file": "FILE",
    "target": "FILE",
    "partial": "DIR.partial",
    "number": "N",
    "line": "N",
}
#: A part behind a colon that holds one of these says what to do.
VERBS = {"choose", "give", "move", "wait", "undo", "install", "start"}

#: What a group of errors is about, and the modules that make them.
GROUPS: dict[str, tuple[str, ...]] = {
    "model.toml": ("core/formats/model_file.py", "core/reading.py"),
    "Any file": ("core/formats/text.py", "core/info.py", "core/guessing.py", "core/viewing.py"),
    "Irap grids": ("core/formats/irap.py",),
    "ZMAP+ grids": ("core/formats/zmap.py",),
    "GOCAD TSurf": ("core/formats/tsurf.py",),
    "Points and fault sticks": (
        "core/formats/points.py",
        "core/formats/sticks.py",
        "core/formats/stick_surface.py",
        "modeling/fitting.py",
        "modeling/coverage.py",
    ),
    "OBJ, PLY, STL, VTP": (
        "core/formats/meshes.py",
        "core/formats/obj.py",
        "core/formats/ply.py",
        "core/formats/stl.py",
        "core/formats/vtk_reader.py",
    ),
    "Outputs": (
        "core/output.py",
        "core/drafting.py",
        "core/cli.py",
        "core/reports/check_files.py",
        "core/formats/writing.py",
    ),
    "Long runs": ("core/resuming.py", "core/cluster.py", "core/horizons.py"),
    "Demo models": ("core/demo_by_name.py", "core/demo.py", "modeling/scoring.py", "modeling/truth.py"),
    "Fault blocks": ("cleaning/blocks.py", "core/prism.py"),
    "Geometry that cannot be meshed": (
        "modeling/tracing.py",
        "modeling/triangulation.py",
        "modeling/cutting.py",
        "modeling/hinges.py",
        "modeling/energy.py",
        "modeling/algebra.py",
        "modeling/products.py",
    ),
}
#: Modules whose errors no user meets: repairs note them as what is left, damaged kept work is done again.
UNMET = (
    "cleaning/shaping/extension.py",
    "cleaning/shaping/rim_chains.py",
    "cleaning/shaping/subdivision.py",
    "core/keeping.py",
)
_MESH = "Run the check: what it names at that place is the cause. Else use another step."
_BLOCKS = "Give it to `fault_blocks`."
#: What to do, by the beginning of a text that does not say it.
MENDS = {
    "there are fewer than three": "Give more points.",
    "they lie in": "Give points that cover an area.",
    "they lie within": "Give points that cover an area, or set a smaller `step`.",
    "no three of them": "Set a larger `step`.",
    "No surface can be fitted": "As the reason says: it is one of the four above.",
    "… lies in the horizon": "Fault and horizon coincide there: take the copied part out of one of them.",
    "… of … edges of the cut": _MESH,
    "… of … plan triangles": _MESH,
    "More than two triangles": "The horizon is no surface there: export it again as a grid.",
    "Horizon … has no regular grid": "Ask for the triangulation; only Python asks otherwise.",
    "The outline of": "The outline is that of a horizon: look at its check `functional`.",
    "Model … has no faults": "Give faults, or top and bottom.",
    "The outline of the blocks": _BLOCKS,
}

#: Where the texts of warnings and notes are made: the functions of each module.
WARNED: dict[str, tuple[str, ...]] = {
    "core/reading.py": ("_horizon_of_grid", "_horizon_of_points", "_unfit_note"),
    "core/stages.py": ("graph",),
    "modeling/advice.py": ("_restless", "_short", "_what"),
    "modeling/crossing.py": ("warning",),
    "modeling/filling.py": ("filled",),
    "modeling/fitting.py": ("_note",),
    "modeling/narrows.py": ("warning",),
    "modeling/preparation.py": ("prepared", "_few_steps", "_denoised"),
    "modeling/quality.py": ("ends", "gone", "turns", "jumps", "missed"),
    "modeling/refitting.py": ("refitted",),
}


@dataclass(frozen=True)
class Text:
    """A text for a user, its variable parts as `…`, and the module that makes it."""

    module: str
    words: str

    def speaks(self, least: int) -> bool:
        """Whether it says something itself: so many words in it are its own."""
        return len(re.findall(r"\b[a-z]{2,}", self.words)) >= least

    @property
    def parted(self) -> tuple[str, str]:
        """What it says, and what it says to do, which may be all of it."""
        for beginning, mend in MENDS.items():
            if self.words.startswith(beginning):
                return self.words.rstrip("."), mend
        for mark in ("; ", ": "):
            said, found, mend = self.words.rstrip(".").rpartition(mark)
            if found and (mark == "; " or VERBS & set(re.findall(r"[a-z]+", mend))):
                return said, mend
        if re.search("[;:,]", self.words):
            return self.words.rstrip("."), "as it says"
        raise SystemExit(f"{self.module}: it does not say what to do: {self.words}")


def error_texts() -> list[Text]:
    """Return the texts of all errors, in the order of the source."""
    found = []
    for module, tree, constants in modules():
        calls = [n for n in ast.walk(tree) if isinstance(n, ast.Call) and n.args]
        calls = [n for n in calls if isinstance(n.func, ast.Name) and n.func.id in KINDS]
        if calls and module not in UNMET and all(module not in group for group in GROUPS.values()):
            raise SystemExit(f"{module} makes errors and is in no group of docs/collect_messages.py")
        for call in sorted(calls, key=lambda n: n.lineno):
            text = Text(module, template(call.args[0], constants))
            found += [text] if text.speaks(LEAST_WORDS) else []
    return found


def warning_texts() -> list[Text]:
    """Return the texts that the functions which make warnings and notes put together."""
    found = []
    for module, tree, constants in modules():
        wanted = WARNED.get(module, ())
        functions = [n for n in ast.walk(tree) if isinstance(n, ast.FunctionDef) and n.name in wanted]
        if len({f.name for f in functions}) != len(wanted):
            raise SystemExit(f"{module} has not all of the functions {', '.join(wanted)}")
        for function in functions:
            document = ast.get_docstring(function, clean=False)
            texts = (Text(module, template(node, constants)) for node in _told(function))
            found += [t for t in texts if t.words != document and t.speaks(LEAST_OF_WARNING)]
    return found


def _told(function: ast.FunctionDef) -> Iterator[ast.expr]:
    """Yield the texts of a function, whole, without those of the errors that it raises."""
    raised = {id(n) for r in ast.walk(function) if isinstance(r, ast.Raise) for n in ast.walk(r)}
    inner = {id(part) for n in ast.walk(function) if isinstance(n, ast.JoinedStr) for part in n.values}
    for node in ast.walk(function):
        if isinstance(node, ast.JoinedStr | ast.Constant) and id(node) not in raised | inner:
            yield node


def modules() -> Iterator[tuple[str, ast.Module, dict[str, str]]]:
    """Yield each module of the package: its place, its tree, and its texts with a name."""
    for folder in FOLDERS:
        for path in sorted((ROOT / folder).rglob("*.py")):
            tree = ast.parse(path.read_text(encoding="utf-8"))
            named = (n for n in tree.body if isinstance(n, ast.Assign) and isinstance(n.targets[0], ast.Name))
            constants = {
                n.targets[0].id: n.value.value
                for n in named
                if isinstance(n.targets[0], ast.Name)
                and isinstance(n.value, ast.Constant)
                and isinstance(n.value.value, str)
            }
            yield path.relative_to(ROOT).as_posix(), tree, constants


def template(node: ast.expr, constants: dict[str, str]) -> str:
    """Return a text as far as the source knows it, with `…` for the rest."""
    if isinstance(node, ast.Constant):
        return node.value if isinstance(node.value, str) else ""
    if isinstance(node, ast.FormattedValue):
        return template(node.value, constants)
    if isinstance(node, ast.JoinedStr):
        return "".join(template(part, constants) for part in node.values)
    if isinstance(node, ast.Name):
        return constants.get(node.id) or SHOWN.get(node.id, "…")
    return "…"


def table() -> str:
    """Return the errors, group by group."""
    found = error_texts()
    parts = []
    for title, group in GROUPS.items():
        rows = dict.fromkeys(text.parted for module in group for text in found if text.module == module)
        lines = [f"| {code(said)} | {plain(mend) if mend != '…' else 'as it says'} |" for said, mend in rows]
        parts.append("\n".join([f"### {title}", "", "| says | what to do |", "|---|---|", *lines]))
    return "\n\n".join(parts)


def code(words: str) -> str:
    """Return a text as it stands on the screen."""
    return f"`` {words} ``" if "`" in words else f"`{words}`"


def plain(words: str) -> str:
    """Return a text in which options and tables stand as on the screen."""
    return re.sub(r"(?<![\w`-])(-{1,2}[a-z-]+|\[\[\w+\]\])(?!`)", r"`\1`", words)


def pages() -> dict[Path, str]:
    """Return what stands between the marks of each page."""
    return {DOCS / "messages.md": table()}


if __name__ == "__main__":
    sys.exit(write(pages()))
