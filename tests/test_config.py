"""Settings: every one explained, bounded, and read back from the TOML that is printed."""

from __future__ import annotations

from pathlib import Path
from typing import get_args, get_type_hints

import pytest
from msgspec import Meta

from rgcore import config
from rgcore.config import Config
from rgcore.errors import InputError, SettingError


def test_every_setting_has_a_unit_and_a_reason() -> None:
    for stage in Config.__struct_fields__:
        part = getattr(Config(), stage)
        hints = get_type_hints(type(part), include_extras=True)
        for name in part.__struct_fields__:
            meta = [m for m in get_args(hints[name])[1:] if isinstance(m, Meta)]
            assert meta, f"{stage}.{name} is no documented setting"
            assert meta[0].extra
            assert meta[0].extra["unit"]
            assert len(meta[0].description or "") > 10


def test_the_defaults_obey_their_own_bounds(tmp_path: Path) -> None:
    file = tmp_path / "all.toml"
    file.write_text(config.as_toml(Config()), encoding="utf-8")
    assert config.load(file) == Config()


def test_pairs_win_over_the_file_and_only_changes_are_kept(tmp_path: Path) -> None:
    file = tmp_path / "some.toml"
    file.write_text("[slam]\nmax_range = 9.0\n[lines]\ngap = 0.5\n", encoding="utf-8")
    c = config.load(file, ["slam.max_range=12"])
    assert config.changed(c) == {"slam.max_range": 12.0, "lines.gap": 0.5}


@pytest.mark.parametrize(
    ("pair", "words"),
    [
        ("slam.max_range=-1", "slam.max_range"),
        ("slam.max_range=soon", "slam.max_range"),
        ("slam.max_range=nan", "slam.max_range"),
        ("slam.maxrange=3", "maxrange"),
        ("slm.max_range=3", "slm"),
        ("max_range=3", "stage.name=value"),
        ("slam=3", "stage.name=value"),
    ],
)
def test_a_wrong_setting_is_named(pair: str, words: str) -> None:
    with pytest.raises(SettingError, match=words):
        config.load(None, [pair])


def test_a_broken_file_is_named(tmp_path: Path) -> None:
    file = tmp_path / "broken.toml"
    file.write_text("[slam\n", encoding="utf-8")
    with pytest.raises(InputError, match=r"broken\.toml"):
        config.load(file)
    with pytest.raises(InputError, match=r"absent\.toml"):
        config.load(tmp_path / "absent.toml")
