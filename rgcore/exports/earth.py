"""The map on the earth: its frame as others describe frames, and its points in WGS 84."""

from __future__ import annotations

from functools import lru_cache
from typing import Any

import numpy as np

from rgcore.errors import RgError
from rgcore.exports.options import Georeference

FRAME: dict[str, Any] = {
    "$schema": "https://proj.org/schemas/v0.7/projjson.schema.json",
    "type": "EngineeringCRS",
    "name": "map",
    "datum": {"type": "EngineeringDatum", "name": "map frame of the robot"},
    "coordinate_system": {
        "subtype": "Cartesian",
        "axis": [
            {"name": "x", "abbreviation": "x", "direction": "unspecified", "unit": "metre"},
            {"name": "y", "abbreviation": "y", "direction": "unspecified", "unit": "metre"},
        ],
    },
}
"""The map frame as PROJJSON: metres, x and y at a right angle, tied to nothing."""

_DIGITS = 9  # of degrees: a tenth of a millimetre


def to_earth(where: Georeference, points: np.ndarray) -> np.ndarray:
    """(K, 2) longitude, latitude [degrees] of points (K, 2) [m] of the map. Raises RgError for an impossible place."""
    c, s = np.cos(where.heading), np.sin(where.heading)
    xy = np.asarray(points, float) @ np.array([[c, s], [-s, c]])
    longitude, latitude = _projection(where.latitude, where.longitude).transform(
        xy[:, 0], xy[:, 1], direction="INVERSE"
    )
    return np.round(np.stack([longitude, latitude], 1), _DIGITS)


def to_map(where: Georeference, degrees: np.ndarray) -> np.ndarray:
    """(K, 2) points [m] of the map at (K, 2) longitude, latitude [degrees]."""
    lon, lat = np.asarray(degrees, float).T
    xy = np.stack(_projection(where.latitude, where.longitude).transform(lon, lat), 1)
    c, s = np.cos(where.heading), np.sin(where.heading)
    return np.asarray(xy @ np.array([[c, -s], [s, c]]))


@lru_cache(maxsize=8)
def _projection(latitude: float, longitude: float) -> Any:
    """Degrees to metres east and north of a place: azimuthal equidistant, which keeps lengths about its middle."""
    from pyproj import Transformer  # heavy, and needed with a georeference only

    if not (-90 <= latitude <= 90 and -180 <= longitude <= 180):
        raise RgError(f"georeference {latitude:g},{longitude:g}: latitude -90..90 and longitude -180..180 degrees")
    plane = f"+proj=aeqd +lat_0={latitude!r} +lon_0={longitude!r} +datum=WGS84 +units=m"
    return Transformer.from_crs("EPSG:4326", plane, always_xy=True)
