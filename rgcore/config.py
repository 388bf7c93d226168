"""Every setting: one frozen struct a stage, each field with its unit, bounds and the reason for its default.

Metre, radian, second throughout. ``Config()`` holds the defaults; :func:`load` reads a TOML file and ``--set`` pairs.
"""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any, get_args, get_type_hints

import msgspec
from msgspec import Meta

from rgcore.errors import InputError, SettingError


def setting(unit: str, reason: str, **bounds: Any) -> Meta:
    """What a setting says of itself: unit, why its default is what it is, and its bounds (``ge gt le lt``)."""
    return Meta(description=reason, extra={"unit": unit}, **bounds)


class Settings(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Base of the stages' settings."""


class Extract(Settings, frozen=True):
    """Segments from single scans (paper, sections IV-A and IV-C)."""

    max_range: Annotated[
        float, setting("m", "beyond it neighbouring beams lie too far apart to make a segment", gt=0, le=200)
    ] = 20.0
    cluster_distance: Annotated[
        float, setting("m", "neighbouring echoes farther apart belong to different things", gt=0, le=5)
    ] = 0.35
    point_line_distance: Annotated[
        float, setting("m", "farthest point from its segment; never less than 4 deviations of the noise", gt=0, le=1)
    ] = 0.06
    variance: Annotated[float, setting("m", "largest root mean square distance of a segment's points", gt=0, le=1)] = (
        0.03
    )
    min_points: Annotated[int, setting("points", "two echoes always lie on a line, a third can tell", ge=2, le=100)] = 3
    min_length: Annotated[float, setting("m", "shorter ones have no direction, at 12 mm noise", gt=0, le=5)] = 0.08
    noise: Annotated[
        float,
        setting("m", "deviation of a range of a usual laser, where the log has too few long walls to tell", gt=0, le=1),
    ] = 0.012


class Slam(Settings, frozen=True):
    """Scan matching by local registration and global correlation (paper, section IV-A)."""

    max_range: Annotated[float, setting("m", "halls are this wide; farther readings are few", gt=0, le=200)] = 40.0
    spacing: Annotated[float, setting("m", "points of a scan nearer than this say the same", ge=0, le=1)] = 0.06
    point_noise: Annotated[
        float, setting("m", "deviation of an echo from its wall, range noise and roughness", gt=0, le=1)
    ] = 0.03
    odometry_noise: Annotated[
        float, setting("m/m, rad/rad", "deviation of raw odometry by the way driven", gt=0, le=5)
    ] = 0.15
    reach: Annotated[float, setting("m", "how far off the predicted pose may be", gt=0, le=5)] = 0.5
    keyframe_distance: Annotated[float, setting("m", "a scan every so often keeps all that was seen", gt=0, le=10)] = (
        0.4
    )
    keyframe_angle: Annotated[float, setting("rad", "a quarter of a 120 degree view", gt=0, le=3.2)] = 0.5
    local_keyframes: Annotated[
        int, setting("keyframes", "the local map: what was seen over some metres", ge=1, le=100)
    ] = 10
    drift: Annotated[float, setting("m/m", "how far poses run off by the way driven, closures apart", gt=0, le=1)] = (
        0.03
    )
    certain: Annotated[float, setting("m", "old keyframes surer than this join the local map", gt=0, le=5)] = 0.2
    neighbourhood: Annotated[float, setting("m", "keyframes nearer than this see the same things", gt=0, le=50)] = 3.0
    window: Annotated[float, setting("m", "widest search for a loop closure", gt=0, le=50)] = 6.0
    least_response: Annotated[float, setting("1", "a maximum's mean likelihood must exceed this", gt=0, le=1)] = 0.45
    rival: Annotated[float, setting("1", "and be without another maximum of this part of it", ge=0.7, le=1)] = 0.8
    least_closures: Annotated[
        int, setting("closures", "so many in a row must agree before they bend the map", ge=1, le=20)
    ] = 3
    strain: Annotated[
        float, setting("chi squared", "a closure that stretches the other links by more is a look-alike", gt=0)
    ] = 100.0
    least_agreement: Annotated[
        float, setting("1", "scans that agree less about what they see were not taken there", ge=0, le=1)
    ] = 0.6
    least_points: Annotated[
        int, setting("points", "fewer surface points do not show where a scan is", ge=1, le=1000)
    ] = 30
    blind: Annotated[
        float, setting("m, rad", "deviation of the motion guessed where there is no odometry", gt=0, le=5)
    ] = 0.1


class Lines(Settings, frozen=True):
    """Merging of segments to the lines of the map (paper, section IV-B and IV-C)."""

    distance: Annotated[
        float, setting("m", "segments nearer than this are one line; the paper takes 0.05 to 0.1", gt=0, le=1)
    ] = 0.08
    min_length: Annotated[
        float, setting("m", "mu: shorter lines are dropped; the side of a bin is longer", gt=0, le=5)
    ] = 0.1
    ratio: Annotated[float, setting("1", "rho: largest distance / length; the paper takes 0.1 to 0.4", gt=0, le=2)] = (
        0.25
    )
    gap: Annotated[
        float, setting("m", "gamma: collinear lines merge across gaps up to this; the paper takes 0.2", ge=0, le=5)
    ] = 0.2
    angle: Annotated[
        float, setting("rad", "20 degrees: the direction of a short segment is no better", gt=0, le=0.5)
    ] = 0.35
    corner: Annotated[
        float, setting("m", "ends that meet within this are one corner: the last echo is that far off", ge=0, le=1)
    ] = 0.1
    min_support: Annotated[
        int, setting("segments", "a line seen less often is noise or has passed by", ge=1, le=1000)
    ] = 2
    price: Annotated[
        float,
        setting("readings", "so many a line must tell right that no other does: few lines against true ones", ge=0),
    ] = 22.0
    reduction: Annotated[
        float, setting("1", "segments a line at least: the price rises up to that, at most 4 times", ge=1, le=1000)
    ] = 17.0
    max_range: Annotated[float, setting("m", "farther readings do not judge lines", gt=0, le=200)] = 12.0


class Adapt(Settings, frozen=True):
    """Parameters of merging that adapt themselves to each region (paper, section IV-C)."""

    on: Annotated[bool, setting("-", "false: all regions are merged with the settings of [lines]")] = True
    goal: Annotated[
        float,
        setting("m", "acc(R) above it lowers the price of a region's lines, to an eighth at most", ge=0, le=10),
    ] = 0.19
    sample: Annotated[
        int, setting("readings", "so many judge the settings; more say the same", ge=1000, le=10_000_000)
    ] = 100_000


class Accuracy(Settings, frozen=True):
    """The accuracy measure (paper, section IV-C)."""

    max_range: Annotated[float, setting("m", "readings farther than this are left out", gt=0, le=200)] = 12.0
    penalty: Annotated[float, setting("m", "p: what a reading costs that no line predicts", gt=0, le=10)] = 1.0


class Places(Settings, frozen=True):
    """Free space, gateways and regions (paper, section IV-D)."""

    resolution: Annotated[
        float, setting("m", "cell of the free-space raster: half of the thinnest wall", gt=0, le=0.5)
    ] = 0.05
    max_range: Annotated[
        float, setting("m", "farther readings show little of a room and much of pose errors", gt=0, le=200)
    ] = 20.0
    robot_radius: Annotated[
        float,
        setting(
            "m", "half the width of a usual robot: the box of a region is that of its possible positions", gt=0, le=3
        ),
    ] = 0.25
    min_gateway: Annotated[float, setting("m", "narrower gaps let no robot through", gt=0, le=5)] = 0.5
    max_gateway: Annotated[float, setting("m", "wider gaps are no transition but one place", gt=0, le=20)] = 5.0
    clutter: Annotated[
        float, setting("m", "free-standing things smaller than this divide no room: legs, bins, people", ge=0, le=10)
    ] = 0.8
    min_confidence: Annotated[
        float, setting("1", "a chord below it is no gateway: as likely right as wrong", ge=0, le=1)
    ] = 0.66
    unpassed_confidence: Annotated[
        float, setting("1", "a gap between cabinets looks like a door; what was driven through is surer", ge=0, le=1)
    ] = 0.97
    weak_confidence: Annotated[
        float, setting("1", "a chord above it still counts where it closes a room together with a sure one", ge=0, le=1)
    ] = 0.3
    furniture: Annotated[
        float, setting("m", "things up to this size that touch no wall divide no room either", ge=0, le=20)
    ] = 1.8
    snap_distance: Annotated[
        float, setting("m", "posts move this far onto the end of a line: two cells and a line's error", ge=0, le=1)
    ] = 0.15
    split_hallways: Annotated[
        bool, setting("-", "hallways that bend or cross stay one region; true cuts them at junctions")
    ] = False
    min_area: Annotated[float, setting("m2", "smaller places are niches of their neighbours", ge=0, le=100)] = 0.8
    no_echo_reach: Annotated[
        float, setting("m", "a beam without an echo is free that far; glass and black walls give none", ge=0, le=200)
    ] = 1.0
    widest_door: Annotated[float, setting("m", "a usual double door; what is wider is an opening", gt=0, le=20)] = 2.0


class Classes(Settings, frozen=True):
    """Region classes (paper, section IV-D)."""

    histogram_bins: Annotated[int, setting("bins", "36 bins of 5 degrees over half a turn", ge=8, le=180)] = 36


class Objects(Settings, frozen=True):
    """Object hypotheses (paper, section III)."""

    min_face: Annotated[float, setting("m", "shorter lines are legs and noise", gt=0, le=5)] = 0.2
    min_width: Annotated[float, setting("m", "smaller boxes are posts and jambs", gt=0, le=5)] = 0.3
    max_width: Annotated[float, setting("m", "longer boxes are parts of the building", gt=0, le=20)] = 4.0
    min_depth: Annotated[float, setting("m", "shallower ones are walls, door frames and pilasters", gt=0, le=2)] = 0.2
    max_depth: Annotated[float, setting("m", "deeper ones are parts of the building", gt=0, le=5)] = 1.2
    min_confidence: Annotated[float, setting("1", "boxes below it are more likely wrong than right", ge=0, le=1)] = 0.5
    height: Annotated[float, setting("m", "a 2D laser cannot see heights: that of a usual cabinet", gt=0, le=10)] = 1.0


class Localize(Settings, frozen=True):
    """Localization of a robot on the lines of a finished map."""

    max_range: Annotated[float, setting("m", "farther readings are few and hit at grazing angles", gt=0, le=200)] = 20.0
    spacing: Annotated[float, setting("m", "points of a scan nearer than this say the same", ge=0, le=1)] = 0.06
    point_noise: Annotated[
        float, setting("m", "deviation of an echo from its line, range noise and roughness", gt=0, le=1)
    ] = 0.03
    line_noise: Annotated[
        float, setting("m", "deviation of a line from its wall, common to all its echoes", gt=0, le=1)
    ] = 0.01
    odometry_noise: Annotated[
        float, setting("m/m, rad/rad", "deviation of raw odometry by the way driven", gt=0, le=5)
    ] = 0.15
    reach: Annotated[
        float, setting("m", "how far off the predicted pose may be before lines are searched wider", gt=0, le=5)
    ] = 0.5
    tolerance: Annotated[
        float, setting("m", "an echo nearer to a line than this is explained by it: 4 deviations", gt=0, le=1)
    ] = 0.12
    least_fit: Annotated[
        float,
        setting(
            "1",
            "scans with less share explained, less crossed, are not believed: it is that of wrong places",
            gt=0,
            le=1,
        ),
    ] = 0.3
    patience: Annotated[
        int, setting("scans", "so many unbelieved scans in a row and the robot is lost", ge=1, le=1000)
    ] = 5
    window: Annotated[int, setting("scans", "a global search takes that many: some metres of way", ge=1, le=1000)] = 20
    least_found: Annotated[
        float,
        setting("1", "a window that fits worse nowhere fits: with every third beam on people it is 0.55", gt=0, le=1),
    ] = 0.5
    rival: Annotated[
        float, setting("1", "places whose scans fit this much worse than the best are no rivals", gt=0, le=1)
    ] = 0.05


class Config(Settings, frozen=True):
    """All settings of a run, by stage."""

    extract: Extract = Extract()
    slam: Slam = Slam()
    lines: Lines = Lines()
    adapt: Adapt = Adapt()
    accuracy: Accuracy = Accuracy()
    places: Places = Places()
    classes: Classes = Classes()
    objects: Objects = Objects()
    localize: Localize = Localize()


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
