"""The readme's own words hold."""

from __future__ import annotations

import gzip
import re
from pathlib import Path

import pytest

from rgviz.cli.arguments import parser
from rgviz.demo import LOG

README = (Path(__file__).parents[1] / "README.md").read_text(encoding="utf-8")


def test_the_lines_of_python_run(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (code,) = re.findall(r"```python\n(.*?)```", README, re.S)
    lines = gzip.decompress(LOG.read_bytes()).splitlines(keepends=True)
    (tmp_path / "office.log.gz").write_bytes(gzip.compress(b"".join(lines[:900])))
    monkeypatch.chdir(tmp_path)
    exec(code, {})
    assert (tmp_path / "office.rg" / "current").exists()


def test_the_commands_that_it_names_exist() -> None:
    known = re.findall(r"^    (\w+)  ", parser().format_help(), re.M)
    named = re.findall(r"^    rgviz (\w+)", README, re.M)
    assert named
    assert set(named) <= set(known)


def test_the_files_that_it_names_exist() -> None:
    for link in re.findall(r"\]\(([^)#]+)\)", README):
        assert (Path(__file__).parents[1] / link).exists(), link
