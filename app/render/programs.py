"""Shader programs, compiled once per context from the files of the `shaders` folder."""

import re
from functools import cache
from importlib.resources import files

import moderngl

_INCLUDE = re.compile(r'^#include "([\w.]+)"$', re.MULTILINE)


@cache
def source(name: str) -> str:
    """Return the text of the shader file `name` with its `#include "…"` lines filled in."""
    text = (files("shaders") / name).read_text(encoding="utf-8")
    return _INCLUDE.sub(lambda match: source(match[1]), text)


class Programs:
    """The programs of one context by the names of their two files."""

    def __init__(self, context: moderngl.Context) -> None:
        self._context = context
        self._programs: dict[tuple[str, str], moderngl.Program] = {}
        self._fullscreen: dict[str, moderngl.VertexArray] = {}

    def get(self, vertex: str, fragment: str) -> moderngl.Program:
        """Return the program of `vertex` and `fragment`, file names in `shaders`."""
        key = (vertex, fragment)
        if key not in self._programs:
            self._programs[key] = self._context.program(vertex_shader=source(vertex), fragment_shader=source(fragment))
        return self._programs[key]

    def fullscreen(self, fragment: str, **uniforms: object) -> None:
        """Run `fragment` once for every pixel of the viewport."""
        program = self.get("fullscreen.vert", fragment)
        if fragment not in self._fullscreen:
            self._fullscreen[fragment] = self._context.vertex_array(program, [])
        set_uniforms(program, **uniforms)
        self._fullscreen[fragment].render(moderngl.TRIANGLES, vertices=3)


def programs_of(context: moderngl.Context) -> Programs:
    """Return the one `Programs` of `context`."""
    if not isinstance(context.extra, Programs):
        context.extra = Programs(context)
    return context.extra


def set_uniforms(program: moderngl.Program, **uniforms: object) -> None:
    """Set the uniforms that `program` has; compilers drop those that it does not use."""
    for name, value in uniforms.items():
        member = program.get(name, None)
        if isinstance(member, moderngl.Uniform):
            member.value = value
