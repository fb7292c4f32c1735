from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from graben.errors import InputError
from graben.formats.points import read_points, read_table

DATA = Path(__file__).parents[3] / "shared" / "data"
POINTS = [[1.5, 2.0, -3.25], [4.0, 5e3, -6.0]]
SAME = {
    "bare": "1.5 2 -3.25\n4 5e3 -6\n",
    "bare, padded": "   1.5\t2   -3.25  \n\n  4 5e3 -6",
    "bare, more columns": "1.5 2 -3.25 7\n4 5e3 -6 8\n",
    "commas": "X,Y,Z\n1.5,2,-3.25\n4,5e3,-6\n",
    "semicolons, other order": "id;z;Y;x\na;-3.25;2;1.5\nb;-6;5e3;4\n",
    "quoted header": '"X","Y","Z"\n1.5,2,-3.25\n4,5e3,-6\n',
    "commas without header": "1.5,2,-3.25\n4,5e3,-6\n",
    "header by white space": "x y z\n1.5 2 -3.25\n4 5e3 -6\n",
    "comments and blanks": "# picked\nX;Y;Z\n1.5; 2; -3.25\n\n# more\n4;5e3;-6\n",
    "byte order mark": "\ufeffX,Y,Z\n1.5,2,-3.25\n4,5e3,-6\n",
    "UTM and TVDSS": "UTM_X,UTM_Y,TVDSS\n1.5,2,-3.25\n4,5e3,-6\n",
    "names with units, in another order": "Northing [m];Easting (m);Depth_m\n2;1.5;-3.25\n5e3;4;-6\n",
    "Z itself before what stands for it": "depth,easting,northing,Z\n9,1.5,2,-3.25\n9,4,5e3,-6\n",
    "Windows line ends": "X,Y,Z\r\n1.5,2,-3.25\r\n4,5e3,-6\r\n",
}
BROKEN = {
    "letters": ("X,Y,Z\n1,2,3\n1,b,3\n", ("line 3", "Y", "'b'")),
    "decimal commas": ("X;Y;Z\n1,5;2;3\n", ("line 2", "'1,5'", "decimal comma", "1.5")),
    "an empty cell": ("X;Y;Z\n1;2;3\n\n1;2;\n", ("line 4", "Z", "empty")),
    "a row cut short": ("1 2 3\n4 5\n", ("line 2", "column 3")),
    "two columns": ("1 2\n4 5\n", ("line 1", "column 3")),
    "no column z": ("X,Y,amplitude\n1,2,3\n", ("line 1", "column Z", "'amplitude'", "Easting")),
    "two columns for z": ("X,Y,TVDSS,TWT\n1,2,3,4\n", ("line 1", "'TVDSS'", "'TWT'", "Z")),
    "decimal commas in bare columns": ("1,5 2,5 3,5\n", ("line 1", "decimal comma", "1.5")),
    "a column twice": ("X,Y,Z,x\n1,2,3,4\n", ("line 1", "X", "twice")),
    "a header alone": ("X,Y,Z\n", ("no points",)),
    "comments alone": ("# nothing\n", ("no table",)),
    "prose": ("these are no points\n", ("line 1", "column X")),
}


@pytest.mark.parametrize("case", SAME)
def test_every_form_gives_the_same_points(tmp_path: Path, case: str) -> None:
    path = tmp_path / "p"
    path.write_text(SAME[case], encoding="utf-8", newline="")
    assert read_points(path).tolist() == POINTS


@pytest.mark.parametrize("case", BROKEN)
def test_what_cannot_be_read_is_named(tmp_path: Path, case: str) -> None:
    text, words = BROKEN[case]
    path = tmp_path / "p"
    path.write_text(text)
    with pytest.raises(InputError) as caught:
        read_points(path)
    message = str(caught.value)
    assert str(path) in message and all(word in message for word in words), message


def test_numbers_that_are_not_finite_are_kept_with_their_line(tmp_path: Path) -> None:
    (tmp_path / "p").write_text("X;Y;Z\n1;2;3\n\n4;nan;-inf\n")
    table, lines = read_table(tmp_path / "p", ("x", "y", "z"))
    assert np.array_equal(table, [[1, 2, 3], [4, np.nan, -np.inf]], equal_nan=True)
    assert lines.tolist() == [2, 4]


@pytest.mark.skipif(not DATA.is_dir(), reason="shared data are not here")
def test_real_files() -> None:
    claudius = [len(read_points(DATA / "claudius" / f"{name}Points.csv")) for name in "ABCD"]
    assert sum(claudius) == 19_954
    assert sum(len(read_points(DATA / "hecho" / f"H{k}.csv")) for k in range(1, 10)) == 729
    top = read_points(DATA / "drogon" / "horizons" / "TopVolantis.poi")
    assert top.shape == (32_616, 3) and top[0].tolist() == [460487.528, 5933634.357, 1653.757]
