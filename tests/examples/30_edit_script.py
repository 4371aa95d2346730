"""Script the editor's document: the same edits as with the mouse, saved as a project and rendered to a file."""

import tempfile
from dataclasses import replace
from pathlib import Path

from app.render.export import render_mesh
from assets import asset
from core.document.document import Document, Pin
from core.document.map_solver import settle_map
from core.document.project import load_project, save_project
from core.imaging.images import load, load_mask, save
from core.progress import run
from core.rasters.raster import Raster

picture = load(asset("balloons.png"))

document = Document.of(picture)
document = replace(document, mask=Raster.from_array(load_mask(asset("balloons_mask.png"), picture.size_px)))
document = document.with_warp(preset="flag", bend=35.0)
document = replace(document, pins=(Pin((0.25, 0.35), (0.30, 0.30)),))

with tempfile.TemporaryDirectory() as folder:
    project = Path(folder) / "balloons.weft"
    save_project(document, project)
    again = load_project(project)
    warped = run(settle_map(again))
    result = render_mesh(picture, warped.rest, warped.warped, size=document.size_px)
    save(result, Path(folder) / "balloons.jpg")
    print(f"{project.name}: {project.stat().st_size} bytes; {warped.report()['features']}")

assert (warped.warped == run(settle_map(document)).warped).all()
