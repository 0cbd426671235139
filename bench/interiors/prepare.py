"""Makes scenes readable whose textures or meshes are missing: a copy of links, beside the folder
that holds them.

A missing texture becomes a grey one, and the shape of a missing mesh is left out, so that every
renderer reads the same scene.
"""

import os
import pathlib
import re

GREY = 128
FILE_NAME = re.compile(r'"([^"\n]+\.(?:tga|png|jpg|exr|hdr|pfm|ply))"')


def grey_picture(extension):
    """A picture of one grey pixel: a Targa, whatever it is called, unless it holds floats."""
    if extension == ".pfm":
        return b"PF\n1 1\n-1.0\n" + bytes((0, 0, 0x80, 0x3E)) * 3
    return bytes((0, 0, 2, 0, 0, 0, 0, 0, 0, 0, 0, 0, 1, 0, 1, 0, 24, 0, GREY, GREY, GREY))


def prepare(scene, folder):
    """Writes `folder`/scene.pbrt, which is `scene` with all that is missing filled in. Returns its
    path and the names of the missing files."""
    scene, folder = pathlib.Path(scene).resolve(), pathlib.Path(folder)
    folder.mkdir(parents=True, exist_ok=True)
    lines, missing = scene.read_text(encoding="utf-8").splitlines(keepends=True), []
    # The picture's own name is no file to read.
    named = {name for line in lines if '"string filename"' in line for name in FILE_NAME.findall(line)}
    own = re.search(r'^Film[^\n]*\n(?:\s[^\n]*\n)*', "".join(lines), re.M)
    own = set(FILE_NAME.findall(own[0])) if own else set()
    left_out = set()
    for name in sorted(named - own):
        place = folder / name
        place.parent.mkdir(parents=True, exist_ok=True)
        if (scene.parent / name).exists():
            place.unlink(missing_ok=True)
            os.symlink(scene.parent / name, place)
            continue
        missing.append(name)
        if name.endswith(".ply"):
            left_out.add(name)
        else:
            place.write_bytes(grey_picture(place.suffix))
    text = "".join(lines)
    for name in left_out:
        text = re.sub(r'^[ \t]*Shape[^\n]*\n?(?:[ \t]+"[^\n]*\n)*?[ \t]*[^\n]*"' + re.escape(name) + r'"[^\n]*\n(?:[ \t]+"[^\n]*\n)*', "", text,
                      flags=re.M)
    for name in re.findall(r'^Include "([^"\n]+)"', text, re.M):
        if not (scene.parent / name).exists():
            missing.append(name)
            text = text.replace(f'Include "{name}"\n', "")
    file = folder / "scene.pbrt"
    file.write_text(text, encoding="utf-8")
    return file, missing
