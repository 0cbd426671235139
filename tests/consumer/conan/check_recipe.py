"""Runs examples/packaging/conan/conanfile.py with the few functions of Conan that it calls, written
out here, and looks at the package that it makes. Where Conan itself is installed, it also reads the
recipe (`conan inspect`).

Usage: check_recipe.py PROJECT_DIR WORK_DIR VERSION
"""
import fnmatch
import importlib.util
import pathlib
import shutil
import subprocess
import sys
import types

project, work, version = pathlib.Path(sys.argv[1]), pathlib.Path(sys.argv[2]), sys.argv[3]
recipe_path = project / "examples/packaging/conan/conanfile.py"


def copy(_, pattern, src, dst):
    src = pathlib.Path(src).resolve()
    for path in src.rglob("*"):
        name = path.relative_to(src).as_posix()
        if path.is_file() and fnmatch.fnmatch(name, pattern):
            target = pathlib.Path(dst) / name
            target.parent.mkdir(parents=True, exist_ok=True)
            shutil.copy(path, target)


class ConanFile:
    def __init__(self):
        self.needed = []
        self.recipe_folder = str(recipe_path.parent)

    def requires(self, reference, transitive_headers=False):
        self.needed.append((reference, transitive_headers))


class CppInfo:
    def __init__(self):
        self.properties = {}

    def set_property(self, name, value):
        self.properties[name] = value


standards = []
for name, members in {
    "conan": {"ConanFile": ConanFile},
    "conan.tools": {},
    "conan.tools.build": {"check_min_cppstd": lambda _, standard: standards.append(standard)},
    "conan.tools.files": {"copy": copy, "load": lambda _, path: pathlib.Path(path).read_text(encoding="utf-8")},
}.items():
    module = types.ModuleType(name)
    module.__dict__.update(members)
    sys.modules[name] = module

spec = importlib.util.spec_from_file_location("conanfile", recipe_path)
module = importlib.util.module_from_spec(spec)
spec.loader.exec_module(module)

shutil.rmtree(work, ignore_errors=True)
recipe = module.GmisConan()
recipe.set_version()
assert recipe.version == version, f"the recipe takes itself for version {recipe.version}, not {version}"
recipe.export_sources_folder = recipe.source_folder = str(work / "source")
recipe.package_folder = str(work / "package")
recipe.export_sources()
recipe.requirements()
recipe.validate()
recipe.package()
recipe.cpp_info = CppInfo()
recipe.package_info()

assert standards == [20], standards
assert [name.split("/")[0] for name, _ in recipe.needed] == ["glm"] and recipe.needed[0][1], recipe.needed
assert (work / "package/licenses/LICENSE").read_bytes() == (project / "LICENSE").read_bytes()
headers = sorted(path.relative_to(project) for path in (project / "include").rglob("*") if path.is_file())
packaged = sorted(path.relative_to(work / "package") for path in (work / "package/include").rglob("*") if path.is_file())
assert packaged == headers, "the packaged headers are not those of include/"
assert recipe.cpp_info.properties["cmake_target_name"] == "gmis::gmis", recipe.cpp_info.properties
assert recipe.cpp_info.bindirs == [] and recipe.cpp_info.libdirs == []
test_package = recipe_path.parent / "test_package"
assert (test_package / "my_renderer.cpp").read_bytes() == (project / "tests/consumer/main.cpp").read_bytes(), (
    "test_package/my_renderer.cpp is not tests/consumer/main.cpp")
if shutil.which("conan"):
    subprocess.run(["conan", "inspect", str(recipe_path)], check=True)
print(f"gmis {recipe.version}: {len(packaged)} headers")
