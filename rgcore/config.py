"""Every setting: one frozen struct a stage, each field with its unit, bounds and the reason for its default.

Metre, radian, second throughout. ``Config()`` is the set of defaults; :func:`load` reads a TOML file and ``--set`` pairs.
"""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any, get_args, get_type_hints

import msgspec
from msgspec import Meta

from rgcore.errors import InputError, SettingError


def setting(unit: str, reason: str, **bounds: float) -> Meta:
    """What a setting says of itself: unit, why its default is what it is, and its bounds (``ge gt le lt``)."""
    return Meta(description=reason, extra={"unit": unit}, **bounds)  # type: ignore[arg-type]


class Settings(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Base of the stages' settings."""


class Extract(Settings):
    """Segments from single scans (paper, sections IV-A and IV-C)."""

    max_range: Annotated[float, setting("m", "beyond it neighbouring beams lie too far apart to make a segment", gt=0, le=200)] = 20.0
    cluster_distance: Annotated[float, setting("m", "neighbouring echoes farther apart belong to different things", gt=0, le=5)] = 0.35
    point_line_distance: Annotated[float, setting("m", "farthest point from its segment: 3 sigma of usual range noise", gt=0, le=1)] = 0.06
    variance: Annotated[float, setting("m", "largest root mean square distance of a segment's points", gt=0, le=1)] = 0.03
    min_points: Annotated[int, setting("points", "fewer do not show a line against noise", ge=2, le=100)] = 4
    min_length: Annotated[float, setting("m", "shorter ones have no certain direction", gt=0, le=5)] = 0.12


class Slam(Settings):
    """Scan matching by local registration and global correlation (paper, section IV-A)."""

    max_range: Annotated[float, setting("m", "farther readings are few and hit at grazing angles", gt=0, le=200)] = 25.0


class Lines(Settings):
    """Merging of segments to the lines of the map (paper, section IV-B and IV-C)."""

    distance: Annotated[float, setting("m", "segments nearer than this are one line; the paper takes 0.05 to 0.1", gt=0, le=1)] = 0.08
    min_length: Annotated[float, setting("m", "mu: shorter lines are dropped", gt=0, le=5)] = 0.15
    ratio: Annotated[float, setting("1", "rho: largest distance / length; the paper takes 0.1 to 0.4", gt=0, le=2)] = 0.25
    gap: Annotated[float, setting("m", "gamma: collinear lines merge across gaps up to this; the paper takes 0.2", ge=0, le=5)] = 0.2


class Accuracy(Settings):
    """The accuracy measure (paper, section IV-C)."""

    max_range: Annotated[float, setting("m", "readings farther than this are left out", gt=0, le=200)] = 12.0
    penalty: Annotated[float, setting("m", "p: what a reading costs that no line predicts", gt=0, le=10)] = 1.0


class Places(Settings):
    """Free space, gateways and regions (paper, section IV-D)."""

    resolution: Annotated[float, setting("m", "cell of the free-space raster: half of the thinnest wall", gt=0, le=0.5)] = 0.05
    max_range: Annotated[float, setting("m", "farther readings show little of a room and much of pose errors", gt=0, le=200)] = 20.0
    no_echo_reach: Annotated[float, setting("m", "a beam without an echo is free that far; glass and black walls give none", ge=0, le=200)] = 4.0


class Classes(Settings):
    """Region classes (paper, section IV-D)."""

    histogram_bins: Annotated[int, setting("bins", "36 bins of 5 degrees over half a turn", ge=8, le=180)] = 36


class Objects(Settings):
    """Object hypotheses (paper, section III)."""

    height: Annotated[float, setting("m", "a 2D laser cannot see heights: that of a usual cabinet", gt=0, le=10)] = 1.0


class Config(Settings):
    """All settings of a run, by stage."""

    extract: Extract = Extract()
    slam: Slam = Slam()
    lines: Lines = Lines()
    accuracy: Accuracy = Accuracy()
    places: Places = Places()
    classes: Classes = Classes()
    objects: Objects = Objects()


def load(path: str | Path | None = None, pairs: list[str] | tuple[str, ...] = ()) -> Config:
    """Settings from a TOML file (``[stage]`` tables) and then ``stage.name=value`` pairs.

    Raises InputError for a file that is no TOML, SettingError for an unknown name or a value out of bounds.
    """
    tree: dict[str, Any] = {}
    if path is not None:
        try:
            tree = msgspec.toml.decode(Path(path).read_bytes())
        except OSError as e:
            raise InputError(path, f"cannot read the settings: {e.strerror}") from e
        except (msgspec.DecodeError, UnicodeDecodeError, ValueError) as e:
            raise InputError(path, f"not a TOML file: {e}") from e
    for pair in pairs:
        name, eq, text = pair.partition("=")
        stage, dot, field = name.strip().partition(".")
        if not eq or not dot:
            raise SettingError(f"--set {pair}: write it as stage.name=value, e.g. slam.max_range=12")
        try:
            value = msgspec.toml.decode(f"v = {text.strip()}")["v"]
        except (msgspec.DecodeError, ValueError):
            value = text.strip()
        table = tree.setdefault(stage, {})
        if not isinstance(table, dict):
            raise SettingError(f"{stage}: is a table of settings, not a value; see `rgviz config`")
        table[field] = value
    try:
        return msgspec.convert(tree, Config)
    except msgspec.ValidationError as e:
        reason, _, where = str(e).partition(" - at `$")
        where = where.strip("`.") or "settings"
        raise SettingError(f"setting {where}: {reason}; `rgviz config` lists all with their bounds") from e


def changed(config: Config) -> dict[str, Any]:
    """``{"stage.name": value}`` of the settings that differ from the defaults, sorted."""
    now, default = msgspec.to_builtins(config), msgspec.to_builtins(Config())
    return {f"{s}.{k}": v for s, t in sorted(now.items()) for k, v in sorted(t.items()) if v != default[s][k]}


def as_toml(config: Config) -> str:
    """All settings as TOML, each with its unit and reason as a comment; :func:`load` reads it back."""
    out = []
    for stage in config.__struct_fields__:
        part = getattr(config, stage)
        out.append(f"# {(type(part).__doc__ or '').strip()}\n[{stage}]")
        hints = get_type_hints(type(part), include_extras=True)
        for name in part.__struct_fields__:
            meta = next((m for m in get_args(hints[name])[1:] if isinstance(m, Meta)), None)
            text = msgspec.toml.encode({name: getattr(part, name)}).decode().strip()
            unit, why = ((meta.extra or {}).get("unit", ""), meta.description) if meta else ("", "")
            out.append(f"{text:<32} # {unit}: {why}")
        out.append("")
    return "\n".join(out)
