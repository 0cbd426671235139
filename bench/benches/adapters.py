"""The costs of each adapter of examples/, as Markdown tables; `compile` has the costs of compiling.

lines    Lines of the adapter, and of the complete program.
share    The library's share and the renderer's share of the instructions of an iteration. Callgrind
         counts the instructions at each address; line tables with inlined calls say whose source
         each comes from: the innermost call that lies in the library (core, transport) or in the
         renderer (examples, or gmis/scene for the built-in one). Functions that both use (GLM, the
         standard library, the C library, Embree) count for whoever calls them. The difference of
         two runs leaves out the construction of the scene.

Writes two tables in docs/your-renderer.md, where Embree is installed.
"""
import pathlib
import subprocess
import tempfile

import callgrind
from measuring import Table, publish

DOCUMENT = "docs/your-renderer.md"
root = pathlib.Path(__file__).resolve().parents[2]
compile_options = ["-std=c++20", "-O2", "-I", str(root / "include"), "-I", str(root / "examples"), "-ffp-contract=off"]


class Adapter:
    def __init__(self, name, lines, program, macro, libraries=()):
        self.name, self.lines, self.program, self.macro, self.libraries = name, lines, program, macro, list(libraries)

    def is_here(self):
        return "-lembree3" not in self.libraries or pathlib.Path("/usr/include/embree3/rtcore.h").exists()


adapters = [
    Adapter("the built-in scene", None, "render_a_scene.cpp", "GMIS_OVER_BUILT_IN"),
    Adapter("a renderer of another style", "bring_your_own/adapter.hpp", "bring_your_own/main.cpp", "GMIS_OVER_BRING_YOUR_OWN"),
    Adapter("lamps chosen for their receiver", "many_lights/adapter.hpp", "many_lights/main.cpp", "GMIS_OVER_MANY_LIGHTS"),
    Adapter("Embree's intersector", "embree/embree_scene.hpp", "embree/main.cpp", "GMIS_OVER_EMBREE", ["-lembree3"]),
]


def count_lines(name):
    return len((root / "examples" / name).read_text(encoding="utf-8").splitlines()) if name else "–"


def keep(options, table, name):
    publish(options, table, DOCUMENT if all(adapter.is_here() for adapter in adapters) else None, name)


def lines(options):
    table = Table("over", "lines of the adapter", "lines of the program", numbers_from=1)
    for a in adapters:
        table.add(a.name, count_lines(a.lines), count_lines(a.program))
    keep(options, table, "adapter lines")


# --- Shares ---------------------------------------------------------------------------------------

library, renderer = "library", "renderer"


def owner(file):
    """The owner of a file; None for code that works for whoever calls it."""
    if "/include/gmis/" in file:
        part = file.split("/include/gmis/")[1]
        if part.startswith("scene/"):
            return renderer
        return library if part.startswith(("transport/", "result/", "render/")) else None
    if "/examples/" in file:
        return renderer
    return None


def share(options):
    table = Table("over", "counts", "M instructions an iteration", "library", "renderer", "library's share", numbers_from=2)
    with tempfile.TemporaryDirectory() as folder:
        for adapter in filter(Adapter.is_here, adapters):
            program = f"{folder}/{adapter.macro.lower()}"
            subprocess.run(["g++", *compile_options, "-march=x86-64-v3", "-g1", "-no-pie", "-D" + adapter.macro,
                            str(root / "bench/adapters/main.cpp"), "-o", program, *adapter.libraries], check=True)
            for counts in ("pt", "vcm"):
                sums = callgrind.shares(program, [counts, "1"], [counts, "3"], owner)
                total = sum(sums.values())
                table.add(adapter.name, counts, f"{total / 2e6:.2f}", f"{sums[library] / 2e6:.2f}", f"{sums[renderer] / 2e6:.2f}",
                          f"{100 * sums[library] / total:.0f} %")
    table.note("48x36 pixels, callgrind, g++ -O2 -march=x86-64-v3.")
    keep(options, table, "adapter shares")


def run(options):
    lines(options)
    share(options)
