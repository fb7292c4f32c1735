"""Tables for notebooks."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from html import escape


def html_table(columns: Sequence[str], rows: Iterable[Sequence[object]], title: str = "") -> str:
    """Return rows as an HTML table under a title; every cell is text, numbers have four digits.

    >>> html_table(["name", "throw"], [["<F1>", 12.3456]])
    '<table><tr><th>name</th><th>throw</th></tr><tr><td>&lt;F1&gt;</td><td>12.35</td></tr></table>'
    """
    head = "".join(f"<th>{escape(name)}</th>" for name in columns)
    body = "".join(f"<tr>{''.join(f'<td>{_cell(value)}</td>' for value in row)}</tr>" for row in rows)
    return f"{f'<p>{escape(title)}</p>' if title else ''}<table><tr>{head}</tr>{body}</table>"


def _cell(value: object) -> str:
    return escape(f"{value:.4g}" if isinstance(value, float) else str(value))
