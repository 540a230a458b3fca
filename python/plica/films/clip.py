"""A film of a run: frames, and the true motion and glottis of each."""

from __future__ import annotations

from collections.abc import Iterator
from functools import cached_property, lru_cache
from threading import Lock
from typing import Any

import numpy as np
from numpy.typing import NDArray

from plica.camera.pose import Camera
from plica.errors import InvalidInput
from plica.films.instants import instants, spread
from plica.films.motion import Filmable, Motion
from plica.films.settings import Film
from plica.films.sight import Sight, View
from plica.films.tissue import Shading, normals

__all__ = ["Clip", "film"]

Floats = NDArray[np.float64]
Mask = NDArray[np.bool_]

_VIEWS = 8  # kept: a frame needs its own and the next frame's
_LARGEST_ERROR = 0.25  # px, of the motion interpolated between stored fields


def film(run: Filmable, camera: Camera | None = None, options: Film | None = None, /, **changed: Any) -> Clip:
    """Film a run (docs/film.md).

    Parameters
    ----------
    run : Run or RunPart
        With fields (``output.every``); any object with ``mesh.points``, ``mesh.cells``, ``mesh.surfaces``,
        ``fields["time"]`` and ``fields["displacement"]``. Seen is the surface of which ``airway`` is the
        name, or without that attribute the one named so; all of the mesh's skin if it has no such surface.
    camera : Camera, optional
    options : Film, optional
    **changed
        Fields of `Film`, instead of `options`.

    Returns
    -------
    Clip
        Frames and truth are computed on access.

    Raises
    ------
    InvalidInput
        Without fields or with too few; if `fps` or the exposure needs motion between the stored fields that
        cannot be interpolated accurately; if the camera sees no tissue.
    """
    if options is not None and changed:
        raise InvalidInput(
            f"Film: options and {', '.join(changed)} are both given; must be one or the other."
        )
    return Clip(run, camera or Camera(), options or Film(**changed))


class Clip:
    """Frames of a run as a camera sees them, with their truth; a frame depends only on its number.

    Attributes
    ----------
    camera : Camera
    options : Film
    time : (n) s
        Middles of the frames' exposures.
    fps : float
        Frames a second.
    """

    def __init__(self, run: Filmable, camera: Camera, options: Film) -> None:
        self.camera, self.options = camera, options
        self._sight = Sight(run.mesh, camera, getattr(run, "airway", "airway"))
        self._motion = Motion(run, self._sight.surface.nodes)
        self.fps, self.time = instants(self._motion, options)
        self._check_motion()
        self._shading = Shading(options, camera.axes)
        self._cached_view = lru_cache(maxsize=_VIEWS)(self._view_at)
        self._viewing = Lock()
        if not self._view(0).raster.pixels.size:
            raise InvalidInput(
                f"Camera: no tissue is visible in {camera.width} x {camera.height} px of "
                f"{camera.mm_per_px:g} mm; must be. Check centre, mm_per_px, tilt and lean."
            )

    @property
    def count(self) -> int:
        """Number of frames."""
        return int(self.time.size)

    def __len__(self) -> int:
        return self.count

    def frame(self, index: int) -> NDArray[np.uint8]:
        """(h, w) grey levels as the camera stores them; a negative index counts from the end."""
        index = self._index(index, self.count)
        clean, film = self.clean(index), self.options
        random = np.random.default_rng([film.seed, 1, index])
        spread = np.sqrt(film.photon_noise**2 * np.clip(clean, 0, 255) / 255 + film.read_noise**2)
        noisy = clean + spread * random.standard_normal(clean.shape)
        return np.clip(np.round(noisy), 0, 255).astype(np.uint8)

    def frames(self) -> Iterator[NDArray[np.uint8]]:
        """All frames."""
        return (self.frame(k) for k in range(self.count))

    def clean(self, index: int) -> Floats:
        """(h, w) grey levels before noise and rounding; highlights may exceed 255."""
        from scipy import ndimage

        index = self._index(index, self.count)
        film, exposure = self.options, self.options.seconds("exposure")
        picture = np.zeros(self.camera.shape)
        for late, right, down in spread(film.samples):
            nodes = self._nodes(float(self.time[index] + late * exposure))
            picture += self._picture(nodes - [right, down, 0.0]) / film.samples
        if film.blur:
            picture = ndimage.gaussian_filter(picture, film.blur, mode="nearest")
        return np.asarray(picture * self._vignette)

    def glottis(self, index: int) -> Mask:
        """(h, w) pixels whose centre sees between the folds, in the middle of the exposure."""
        view = self._view(self._index(index, self.count))
        return (view.raster.triangle < 0) & view.opening.pixels(self.camera.shape)

    def area(self, index: int) -> float:
        """Glottal area perpendicular to the line of sight, m^2: pixels of `glottis`."""
        return float(self.glottis(index).sum() * self.camera.pixel**2)

    def flow(self, index: int) -> tuple[NDArray[np.float32], Mask]:
        """Motion of the tissue at the pixels' centres to the next frame, and where it stays visible.

        Returns
        -------
        flow : (h, w, 2) px
            (u, v), to the right and down, on the pixels of frame `index`; NaN without tissue.
        visible : (h, w)
            Where that tissue is visible in frame ``index + 1`` too: inside the frame, facing the camera and
            not occluded.
        """
        index = self._index(index, self.count - 1)
        now, then = self._view(index), self._view(index + 1)
        height, width = self.camera.shape
        raster = now.raster
        flow = np.full((height * width, 2), np.nan, dtype=np.float32)
        flow[raster.pixels] = now.of(then.nodes[:, :2] - now.nodes[:, :2])
        visible = np.zeros(height * width, dtype=bool)
        flat = raster.of(then.corners, self._sight.surface.triangles)  # on the triangles that occlude it
        visible[raster.pixels] = self._sight.still_visible(flat, raster.shown, then)
        return flow.reshape(height, width, 2), visible.reshape(height, width)

    def material(self, index: int) -> Floats:
        """(h, w, 3) m, reference position of the tissue at each pixel; NaN without tissue."""
        view = self._view(self._index(index, self.count))
        place = np.full((*self.camera.shape, 3), np.nan)
        place.reshape(-1, 3)[view.raster.pixels] = view.of(self._sight.points)
        return place

    @cached_property
    def _vignette(self) -> Floats:
        height, width = self.camera.shape
        y, x = np.mgrid[:height, :width].astype(float)
        r2 = (x - (width - 1) / 2) ** 2 + (y - (height - 1) / 2) ** 2
        return np.asarray(1 - self.options.vignetting * r2 / r2.max())

    def _nodes(self, t: float) -> Floats:
        """(k, 3) px, px, m of the surface's nodes at the time t."""
        return self._sight.nodes(self._motion.at(t))

    def _view(self, index: int) -> View:
        with self._viewing:  # neighbouring frames, which threads make, want the same one
            return self._cached_view(index)

    def _view_at(self, index: int) -> View:
        return self._sight.view(self._nodes(float(self.time[index])))

    def _picture(self, nodes: Floats) -> Floats:
        """(h, w) grey levels of the surface with its nodes at these positions, without lens and noise."""
        triangles, view = self._sight.surface.triangles, self._sight.view(nodes)
        raster, pixel = view.raster, self.camera.pixel
        metric = view.corners * [pixel, -pixel, 1.0]  # m along the camera's axes: right, up, towards it
        normal = raster.of(normals(metric @ self.camera.axes, triangles), triangles)
        picture = np.full(self.camera.height * self.camera.width, float(self.options.glottis))
        picture[raster.pixels] = self._shading.grey(view.of(self._sight.points), normal)
        outside = ~view.opening.pixels(self.camera.shape).ravel()
        picture[outside] = self._surroundings[outside]
        return picture.reshape(self.camera.shape)

    @cached_property
    def _surroundings(self) -> Floats:
        """(h * w) grey levels around the airway: a fixed plane of dull tissue at the height of its upper
        end."""
        points = self._sight.around()
        return self._shading.grey(points, np.tile([0.0, 0.0, 1.0], (len(points), 1)), wet=False)

    def _index(self, index: int, count: int) -> int:
        position = index + count if index < 0 else index
        if not 0 <= position < count:
            raise InvalidInput(f"Film: frame = {index}; must be in [0, {count}).")
        return position

    def _check_motion(self) -> None:
        """Raises InvalidInput if motion between stored fields is needed and too uncertain."""
        film, motion = self.options, self._motion
        if not film.seconds("exposure") and all(motion.stored_at(t) is not None for t in self.time):
            return
        error = motion.error_between() / self.camera.pixel
        if error > _LARGEST_ERROR:
            raise InvalidInput(
                f"Film: the motion between stored fields, {motion.interval:g} s apart, is uncertain by "
                f"{error:.2g} px; must be at most {_LARGEST_ERROR:g} px. Store fields more often "
                "(output.every), or choose an fps whose frames coincide with stored instants, without "
                "exposure."
            )
