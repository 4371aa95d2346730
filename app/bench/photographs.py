"""How many photographs of patterned cloth are decomposed: the `photographs` lists of `weft bench`, by picture and half.

A folder holds photos, and for each a matte of its cloth, NAME_mask.png. Those named `refuse_...` show no pattern that
repeats in two directions and have to be refused; `new_...` are textures, of which the first is laid on every cloth;
`plain_...` are left out. The photos are split into two fixed halves, so that what was tuned on one is judged by the
other.
"""

import sys
import time
import traceback
from collections.abc import Iterator
from pathlib import Path
from typing import Any, Literal, TypeAlias

import cv2
import numpy as np

from core.arrays import Bools, Floats, InputError, Singles
from core.imaging import color
from core.imaging.image import Image
from core.imaging.images import load, load_mask
from core.overlay.composition import Placement
from core.overlay.decomposition import Decomposition, decompose, decompose_whole_cloth
from core.overlay.detection.seeding import NoPatternError
from core.overlay.laying.compositing import Parts, encode, lay_over, searchable, texture_colours
from core.overlay.pixels.jacobian_validity import jumps, no_cloth
from core.overlay.tolerances import STRETCH
from core.progress import run

Record: TypeAlias = dict[str, Any]
Task: TypeAlias = Literal["painted", "whole_cloth", "refused"]

LEAST_COVERED, MOST_SPILT, LEAST_LIKENESS = 0.6, 0.1, 0.75
"""Share of the cloth that counts as decomposed, share beside it that whole cloth may cover, and least likeness."""
SCORES = ("covers", "spills", "likeness", "explains", "jumbled", "remains")
SLOW_PX = 12.0
"""Changes slower than this are no evidence of a pattern: shading alone gives them."""
BESIDE_PX = 4
"""A matte is right to so many pixels."""
LEAST_PIXELS = 500
EVEN = np.full((8, 8, 3), 0.5)
"""A texture that shows what a new one is laid in: folds, and what is left of the old one."""


def measure(folder: Path) -> list[Record]:
    """Return one record per photo and task: its half, 0 or 1, scores, whether it holds, and processor seconds."""
    photos, textures, refusals = photographs_in(folder), _named(folder, "new_"), _named(folder, "refuse_")
    texture = texture_colours(load(textures[0])) if textures else np.full((8, 8, 3), 0.5)
    plan: list[tuple[list[Path], tuple[Task, ...]]] = [(photos, ("painted", "whole_cloth")), (refusals, ("refused",))]
    return [
        record
        for files, tasks in plan
        for number, file in enumerate(files)
        for record in _records(file, number % 2, tasks, texture)
    ]


def photographs_in(folder: Path) -> list[Path]:
    """Return the photos of cloth that a folder holds, those of even places of one half; raise if there are none."""
    photos = [file for file in _named(folder, "") if not file.stem.startswith(("new_", "plain_", "refuse_"))]
    if not photos:
        raise InputError(f"{folder}: holds no photographs")
    return photos


def _named(folder: Path, start: str) -> list[Path]:
    """Return the pictures whose names begin so, without mattes."""
    return [file for file in sorted(folder.glob(f"{start}*.*")) if not file.stem.endswith("_mask")]


def cloth_of(file: Path) -> Bools | None:
    """Return where (H, W) the matte of a photo has cloth, None where there is no matte."""
    matte = file.with_name(f"{file.stem}_mask.png")
    return np.asarray(load_mask(matte, load(file).size_px) > 127, np.bool_) if matte.exists() else None


def summarise(records: list[Record]) -> list[Record]:
    """Return the share of the photos that hold, by task, of each half and of both, and the number of faults."""
    rows: list[Record] = []
    for half in (0, 1, None):
        own = [record for record in records if half is None or record["half"] == half]
        shares: Record = {"half": "both" if half is None else half}
        for task in ("painted", "whole_cloth", "refused"):
            holds = [record["holds"] for record in own if record["task"] == task]
            shares |= {task: float(np.mean(holds)) if holds else None, f"{task}_of": len(holds)}
        rows.append(shares | {"faults": sum(record["outcome"] == "fault" for record in own)})
    return rows


def _records(file: Path, half: int, tasks: tuple[Task, ...], texture: Floats) -> Iterator[Record]:
    image, cloth = load(file), cloth_of(file)
    for task in tasks:
        if task == "whole_cloth" and cloth is None:
            continue
        record = {"name": file.stem, "half": half, "task": task, **_try_out(image, cloth, task, texture)}
        if sys.stderr.isatty():
            sys.stderr.write(f"{record['name']} {task}: {record['outcome']}\n")
        yield record


def _try_out(image: Image, cloth: Bools | None, task: Task, texture: Floats) -> Record:
    """Return what came of one photo: an outcome, scores, whether they are enough, and processor seconds."""
    region = searchable(image, cloth if task == "painted" else None)
    whole = task == "whole_cloth"
    job = decompose_whole_cloth(image, region=region) if whole else decompose(encode(image), region=region)
    found = None
    began = time.process_time()
    try:
        result = run(job)
        lay(image, result, texture)
        outcome, found = "found", result
    except NoPatternError:
        outcome = "refused"
    except Exception:  # noqa: BLE001  a fault is counted, and the other photos are looked at
        traceback.print_exc()
        outcome = "fault"
    elapsed = time.process_time() - began
    scores = score(image, cloth, found) if found is not None else dict.fromkeys(SCORES, 0.0)
    return {"outcome": outcome, **scores, "holds": _holds(task, outcome, scores), "cpu_s": elapsed}


def _holds(task: Task, outcome: str, scores: dict[str, float]) -> bool:
    if task == "refused":
        return outcome == "refused"
    is_found = scores["covers"] >= LEAST_COVERED and scores["likeness"] >= LEAST_LIKENESS
    return is_found and (task == "painted" or scores["spills"] <= MOST_SPILT)


def lay(image: Image, found: Decomposition, texture: Floats) -> Image:
    """Return the photo with the texture in its folds."""
    parts = Parts(image, found.uv, found.shading, found.detail, found.coverage, found.basis, found.texel.pixels)
    return lay_over(parts.under(texture, Placement()), texture, Placement(), alpha=1.0, strength=1.0)


def score(image: Image, cloth: Bools | None, found: Decomposition) -> dict[str, float]:
    """Return what share of the `cloth` (H, W) is covered, and of the covered pixels is none, and how well it is laid.

    `likeness` is the correlation of the photo with Wp T(Wg) on the cloth, both without their slow changes: a wrong
    lattice blurs the texel, and only the shading is left to agree. `explains` is the share of the photo's quick changes
    on all of the cloth, in colour and squared, that is missing in the detail; cloth that is not covered is not
    explained. `jumbled` is the share of the covered cloth where coordinates jump, or are folded over, blown up or
    crushed: small pieces may explain the photo so, and show as soon as another texture is laid. `remains` is the share
    of the covered photo's quick changes of grey, squared, that an even texture in its place shows: folds, and what is
    left of the old pattern.
    """
    cloth = np.ones(found.covered.shape, np.bool_) if cloth is None else cloth
    near = cv2.dilate(cloth.astype(np.uint8), np.ones((2 * BESIDE_PX + 1, 2 * BESIDE_PX + 1), np.uint8)) > 0
    covered = found.covered & cloth
    spills = float((found.covered & ~near).sum() / max(found.covered.sum(), 1))
    if covered.sum() < LEAST_PIXELS:
        return dict.fromkeys(SCORES, 0.0) | {"spills": spills}
    photo = encode(image).astype(np.float32)
    seen, model = (_without_slow(_grey(part), covered)[covered] for part in (photo, found.reconstruction))
    likeness = np.corrcoef(seen, model)[0, 1] if min(seen.std(), model.std()) > 1e-3 else 0.0
    changes, missed = _without_slow(photo, cloth), _without_slow(photo - found.reconstruction, covered)
    left = np.where(covered[..., None], missed, changes)[cloth]
    even = _without_slow(_grey(encode(lay(image, found, EVEN))), covered)[covered]
    return {
        "covers": float(covered.sum() / cloth.sum()),
        "spills": spills,
        "likeness": float(likeness),
        "explains": 1 - float((left**2).sum()) / max(float((changes[cloth] ** 2).sum()), 1e-9),
        "jumbled": float(_jumbled(found)[covered].mean()),
        "remains": float((even**2).sum()) / max(float((seen**2).sum()), 1e-9),
    }


def _jumbled(found: Decomposition) -> Bools:
    uv, side = found.uv.astype(np.float64), float(np.sqrt(abs(np.linalg.det(found.basis))))
    return np.asarray(no_cloth(uv, found.basis, side) | (jumps(uv, found.basis) > STRETCH), np.bool_)


def _grey(colours: Floats | Singles) -> Singles:
    levels = color.quantise(colours.astype(np.float32), np.uint8)
    return np.asarray(cv2.cvtColor(np.ascontiguousarray(levels), cv2.COLOR_RGB2GRAY), np.float32)


def _without_slow(plane: Singles, inside: Bools) -> Singles:
    """Return a plane (H, W) or (H, W, C) less the mean of its pixels inside (H, W) that are nearby."""
    share = cv2.GaussianBlur(inside.astype(np.float32), (0, 0), SLOW_PX) + np.float32(1e-6)
    inside, share = (inside, share) if plane.ndim == 2 else (inside[..., None], share[..., None])
    return plane - cv2.GaussianBlur(np.where(inside, plane, np.float32(0)), (0, 0), SLOW_PX) / share
