"""A table that grows by whole rows."""

from __future__ import annotations

from pathlib import Path

import pytest

from cogmap_gym.result_file import ResultFile

COLUMNS = ("agent", "seed", "note")


def test_rows_come_back_as_they_went_in(tmp_path: Path) -> None:
    file = ResultFile(tmp_path / "deep" / "results.csv", COLUMNS)
    file.add({"agent": "a", "seed": 1, "note": 'says "hello, world"'})
    file.add({"agent": "b", "seed": 2, "note": None})
    assert file.rows() == [
        {"agent": "a", "seed": "1", "note": 'says "hello, world"'},
        {"agent": "b", "seed": "2", "note": ""},
    ]
    assert file.done(("agent", "seed")) == {("a", "1"), ("b", "2")}


def test_opening_it_again_keeps_what_is_there(tmp_path: Path) -> None:
    ResultFile(tmp_path / "r.csv", COLUMNS).add({"agent": "a", "seed": 1, "note": ""})
    assert len(ResultFile(tmp_path / "r.csv", COLUMNS).rows()) == 1


@pytest.mark.parametrize("torn", [b"b,2", b'b,2,"half', b"b"])
def test_a_line_that_was_cut_short_is_no_row(torn: bytes, tmp_path: Path) -> None:
    path = tmp_path / "r.csv"
    ResultFile(path, COLUMNS).add({"agent": "a", "seed": 1, "note": ""})
    whole = path.read_bytes()
    path.write_bytes(whole + torn)
    file = ResultFile(path, COLUMNS)
    assert len(file.rows()) == 1
    assert path.read_bytes() == whole


def test_a_file_of_other_columns_is_refused_by_name(tmp_path: Path) -> None:
    path = tmp_path / "r.csv"
    path.write_text("agent,seed\n")
    with pytest.raises(ValueError, match="expected the columns agent,seed,note"):
        ResultFile(path, COLUMNS)
