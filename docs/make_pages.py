"""Write the pages that follow from the code, `equations.md` and the picture in `architecture.md`: `make pages`."""

import ast
import re
from collections import defaultdict
from collections.abc import Iterator
from functools import cache
from pathlib import Path

import grimp

ROOT = Path(__file__).parent.parent
PAPERS = {
    "FAT": ("Feature-aware texturing", "Gal, Sorkine, Cohen-Or 2006"),
    "DPD": ("Detail-preserving deformation", "retexturing along feature curves"),
    "NRT": ("Near-regular texture overlay", "Hilsmann, Schneider, Eisert 2011"),
}
EQUATIONS = {
    "FAT": {
        1: "T, the linear part of W on a quad",
        2: "R, the rotation closest to T",
        3: "the edges of a feature's quads are those of the picture, turned by R and scaled by λ",
        4: "the edges of all other quads are those that W gives them",
        5: "the frame lies where W has it",
        6: "f, the decay of a feature's weight with the distance from it",
        7: "w(Q), the weight of a quad's equations",
        8: "handles are where the hand has them",
        9: "all of it as one least-squares system, A x = b",
        10: "its normal equations, AᵀA x = Aᵀb",
        11: "their Cholesky factor, AᵀA = L Lᵀ",
        12: "forward substitution",
        13: "back-substitution",
    },
    "DPD": {
        1: "Laplace's equation for the way D from a target pixel to its source",
        2: "spines along a feature curve, ribs across it",
        3: "their smoothing",
        4: "how far D compresses the source",
    },
    "NRT": {
        1: "a photo of cloth is shading times a deformed regular texture, and detail",
        2: "the residual of a pixel",
        3: "the unknowns: places and shading at the vertices of a mesh",
        4: "a pixel's place and shading from those of the vertices",
        5: "the vertices' shares in it, barycentric",
        6: "what is minimised: data and smoothness",
        7: "Huber's norm of the residuals, second differences of the unknowns",
        8: "those of places and of shading, with their weights",
        9: "the residual's derivatives",
        10: "the detail: what shading and texture do not explain",
    },
}
DIFFERENCES = {
    ("FAT", 2): "The paper prints V Uᵀ for T = U Σ Vᵀ; the polar rotation is U Vᵀ, and never a reflection.",
    ("FAT", 3): "A feature is one body, α arm + t, so that it is similar exactly; `per-quad` solves it as printed.",
    ("FAT", 5): "Where the frame stays a rectangle, its nodes glide along their side.",
    ("FAT", 8): "Points of the background hold bilinearly; in a feature they determine its pose. The paper pins nodes.",
    ("FAT", 10): "One complex number for each node in place of two real unknowns; bodies are eliminated exactly.",
    ("FAT", 11): "Only what a stroke touched is factorised anew.",
    ("DPD", 1): "D leads from the target to the source: a place is read at q + D(q), where sec. 3.3 writes D(q).",
    ("DPD", 4): "D is read as the place it leads to: a mere turn or shift compresses nothing.",
    ("NRT", 4): "As printed the shading has no offset; here it starts at 1.",
    ("NRT", 6): "The smoothness is that of displacements, not of absolute places as printed.",
    ("NRT", 10): "The paper prints the opposite sign, with which eq. 1 would not give the photo back.",
}
AND = r"\s+and\s+|\s*,\s*|\s+or\s+eq\.\s+"
TO = r"\s+to\s+|\s*-\s*"
CITATION = re.compile(rf"(FAT|DPD|NRT)(?:'s)?\s+eqs?\.\s+(\d+(?:(?:{TO}|{AND})\d+)*)")


def main() -> None:
    """Write them all."""
    (ROOT / "docs" / "equations.md").write_text(equations_page())
    page = ROOT / "docs" / "architecture.md"
    page.write_text(with_rooms(page.read_text()))


def equations_page() -> str:
    """Return the page that says for every numbered equation where it is computed."""
    cited = citations()
    lines = [
        "# The papers' equations, and where they are computed",
        "",
        "Made by `make pages` from the docstrings; a test fails where an equation is named by no function.",
    ]
    for paper, (title, authors) in PAPERS.items():
        lines += ["", f"## {paper}: {title} ({authors})", "", "| eq. | what it says | computed in | where we differ |"]
        lines += ["|---|---|---|---|"]
        for number, says in EQUATIONS[paper].items():
            places = ", ".join(f"[`{name}`](../{file})" for name, file in cited[paper, number])
            lines.append(f"| {number} | {says} | {places} | {DIFFERENCES.get((paper, number), '')} |")
    return "\n".join(lines) + "\n"


@cache
def citations() -> dict[tuple[str, int], list[tuple[str, str]]]:
    """Return the qualified names and files of the functions, classes and attributes whose docstrings cite equations."""
    found: dict[tuple[str, int], list[tuple[str, str]]] = defaultdict(list)
    for path in sorted((ROOT / "core").rglob("*.py")):
        file = path.relative_to(ROOT).as_posix()
        module = file.removesuffix(".py").replace("/", ".").removeprefix("core.").removesuffix(".__init__")
        for name, text in docstrings(ast.parse(path.read_text()), module):
            for paper, number in cited_in(text):
                if (name, file) not in found[paper, number]:
                    found[paper, number].append((name, file))
    return found


def docstrings(node: ast.AST, name: str) -> Iterator[tuple[str, str]]:
    """Yield the names and docstrings of what a module or class holds; those of attributes stand behind them."""
    before: ast.AST | None = None
    for child in ast.iter_child_nodes(node):
        if isinstance(child, ast.FunctionDef | ast.ClassDef):
            yield f"{name}.{child.name}", ast.get_docstring(child) or ""
            yield from docstrings(child, f"{name}.{child.name}")
        elif isinstance(child, ast.Expr) and isinstance(child.value, ast.Constant):
            target = before.target if isinstance(before, ast.AnnAssign) else None
            if isinstance(target, ast.Name):
                yield f"{name}.{target.id}", str(child.value.value)
        before = child


def cited_in(text: str) -> Iterator[tuple[str, int]]:
    """Yield the equations that a docstring names: "FAT eqs. 3 and 4", "FAT eqs. 11-13"."""
    for paper, numbers in CITATION.findall(text):
        for part in re.split(AND, numbers):
            first, _, last = re.sub(TO, "-", part).partition("-")
            yield from ((paper, n) for n in range(int(first), int(last or first) + 1))


def with_rooms(page: str) -> str:
    """Return the page with the picture of rooms and arrows between its marks drawn anew."""
    before, _, rest = page.partition("<!-- rooms -->\n")
    after = rest.partition("<!-- /rooms -->")[2]
    return f"{before}<!-- rooms -->\n{rooms()}<!-- /rooms -->{after}"


def rooms() -> str:
    """Return the rooms and their imports as a Mermaid chart; an arrow that follows from others is left out."""
    graph = grimp.build_graph("app", "core", cache_dir=None)
    above: dict[str, set[str]] = defaultdict(set)
    for module in graph.modules:
        for other in graph.find_modules_directly_imported_by(module):
            one, two = room_of(module), room_of(other)
            if one != two:
                above[one].add(two)
    lines = ["```mermaid", "flowchart TD"]
    lines += [f"    {one} --> {two}" for one in sorted(above) for two in sorted(direct(above, one))]
    return "\n".join([*lines, "```"]) + "\n"


def room_of(module: str) -> str:
    """Return the room of a module, such as `core.mapping`; a module that stands loose is one of its own."""
    return ".".join(module.split(".")[:2])


def direct(above: dict[str, set[str]], one: str) -> set[str]:
    """Return what a room imports but for what it reaches through another room as well."""
    return {two for two in above[one] if not any(two in reached(above, other) for other in above[one] - {two})}


def reached(above: dict[str, set[str]], one: str) -> set[str]:
    """Return all rooms below one."""
    found: set[str] = set()
    todo = [one]
    while todo:
        for other in above.get(todo.pop(), set()) - found:
            found.add(other)
            todo.append(other)
    return found


if __name__ == "__main__":
    main()
