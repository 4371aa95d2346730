"""Shader programs, compiled once per context from the files of the `shaders` folder."""

import re
from functools import cache
from importlib.resources import files
from typing import TypeAlias

import moderngl

Names: TypeAlias = tuple[str, ...]
_INCLUDE = re.compile(r'^#include "([\w./]+)"$', re.MULTILINE)


@cache
def source(name: str) -> str:
    """Return the text of the shader file `name` with its `#include "…"` lines filled in."""
    text = (files("shaders") / name).read_text(encoding="utf-8")
    return _INCLUDE.sub(lambda match: source(match[1]), text)


class Programs:
    """The programs of one context by the names of their two files."""

    def __init__(self, context: moderngl.Context) -> None:
        self._context = context
        self._programs: dict[tuple[str, str, Names], moderngl.Program] = {}
        self._compute: dict[tuple[str, Names], moderngl.ComputeShader] = {}
        self._fullscreen: dict[tuple[str, Names], moderngl.VertexArray] = {}
        self.draws = True
        """Whether anything is drawn: a measurement of the processor's part leaves the draw calls out."""

    def get(self, vertex: str, fragment: str, defined: Names = ()) -> moderngl.Program:
        """Return the program of `vertex` and `fragment`, file names in `shaders`, the latter with names `defined`."""
        key = (vertex, fragment, defined)
        if key not in self._programs:
            text = _with_names(fragment, defined)
            self._programs[key] = self._context.program(vertex_shader=source(vertex), fragment_shader=text)
        return self._programs[key]

    def compute(self, name: str, defined: Names = ()) -> moderngl.ComputeShader:
        """Return the compute shader of the file `name`, with names `defined` (OpenGL 4.3)."""
        if (name, defined) not in self._compute:
            self._compute[name, defined] = self._context.compute_shader(_with_names(name, defined))
        return self._compute[name, defined]

    def fullscreen(
        self, fragment: str, defined: Names = (), vertex: str = "fullscreen.vert", /, **uniforms: object
    ) -> None:
        """Run `fragment`, with names `defined` in it, once for every pixel of the viewport."""
        program = self.get(vertex, fragment, defined)
        key = fragment, defined
        if key not in self._fullscreen:
            self._fullscreen[key] = self._context.vertex_array(program, [])
        set_uniforms(program, **uniforms)
        self.render(self._fullscreen[key], 3)

    def render(self, array: moderngl.VertexArray, vertices: int, first: int = 0) -> None:
        """Draw the triangles of so many vertices, or indices, of `array` from the `first` on."""
        if self.draws:
            array.render(moderngl.TRIANGLES, vertices=vertices, first=first)


def _with_names(name: str, defined: Names) -> str:
    """Return the text of the shader file `name` with names `defined` in it."""
    version, rest = source(name).split("\n", 1)
    return "\n".join([version, *(f"#define {name}" for name in defined), rest])


def programs_of(context: moderngl.Context) -> Programs:
    """Return the one `Programs` of `context`."""
    if not isinstance(context.extra, Programs):
        context.extra = Programs(context)
    return context.extra


def set_uniforms(program: moderngl.Program, **uniforms: object) -> None:
    """Set the uniforms that `program` has, where they are others than before; compilers drop those it does not use."""
    before: dict[str, object] = program.extra or {}
    program.extra = before | uniforms
    for name, value in uniforms.items():
        if name not in before or before[name] != value:
            member = program.get(name, None)
            if isinstance(member, moderngl.Uniform):
                member.value = value
