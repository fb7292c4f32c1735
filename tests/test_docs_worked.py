"""The tutorial and the how-to pages are true: what they say is done, and gives what they show."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.pages import FOLDER, WORKED, blocks, renewed, sessions, worked_through

PAGE = """```console
$ echo a; echo a
b
$ exit 3
$ echo took 1.5 s
took 1 s
```
```python
print(1)
```
```text
2
```
end
"""


@pytest.mark.parametrize("page", WORKED, ids=lambda page: page.stem)
def test_a_page_gives_what_it_shows(page: Path, tmp_path: Path) -> None:
    folder = tmp_path / FOLDER
    folder.mkdir()
    done = list(worked_through(page.read_text(encoding="utf-8"), folder))
    wrong = [str(each) for each in done if not each.true]
    assert done
    assert not wrong, "run docs/collect_outputs.py if this is meant:\n" + "\n".join(wrong)


def test_what_comes_out_otherwise_is_told(tmp_path: Path) -> None:
    assert [block.language for block in blocks(PAGE)] == ["console", "python", "text"]
    assert sessions(blocks(PAGE)[0])[0] == ("echo a; echo a", "b")
    done = list(worked_through(PAGE, tmp_path))
    assert [each.came for each in done] == ["a\na\n", "exit code 3\n", "took 1.5 s\n", "1\n"]
    assert not any(each.true for each in done)


def test_a_page_is_renewed(tmp_path: Path) -> None:
    page = PAGE.replace("$ exit 3\n", "")
    new = renewed(page, list(worked_through(page, tmp_path)))
    assert all(each.true for each in worked_through(new, tmp_path))
    assert "took ... s\n```" in new
    assert renewed(new, list(worked_through(new, tmp_path))) == new
    assert new.endswith("```\nend\n")
