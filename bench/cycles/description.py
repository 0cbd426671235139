"""A scene file of gmis-render as lists that another renderer can be fed from.

Reads what the scenes of the benchmark use: transforms, perspective cameras, flat meshes, whole
spheres, area and distant lights, and the materials of MATERIALS. Anything else is an error.
"""

import dataclasses
import math
import re
import struct

MATERIALS = ("diffuse", "mirror", "conductor", "dielectric", "mix")
NUMBERS_OF = {"LookAt": 9, "Translate": 3, "Scale": 3, "Rotate": 4}
DIVISIONS = 5  # of the meshes that stand for spheres: 20480 triangles
FACE = struct.Struct("<B3i")  # of a .ply file: three corners
TOKEN = re.compile(r'#[^\n]*|"[^"]*"|[\[\]]|[^\s\[\]"#]+')


@dataclasses.dataclass
class Shape:
    """A mesh of triangles, or a sphere where `radius` is set; its surface and the radiance that it
    emits on the side of its normal."""

    points: list
    triangles: list
    radius: float
    material: dict
    emission: list


@dataclasses.dataclass
class Description:
    """Shapes and distant lights in world space; `camera` is the matrix of the camera, whose axes
    are right, up and forward, and `fov` its angle in degrees."""

    camera: list = None
    fov: float = 90
    shapes: list = dataclasses.field(default_factory=list)
    distant: list = dataclasses.field(default_factory=list)  # (direction of travel, irradiance)


# --- Vectors and matrices -------------------------------------------------------------------------


def dot(a, b):
    return sum(x * y for x, y in zip(a, b))


def minus(a, b):
    return [x - y for x, y in zip(a, b)]


def cross(a, b):
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]


def unit(a):
    return [x / math.sqrt(dot(a, a)) for x in a]


def times(a, b):
    return [[sum(a[i][k] * b[k][j] for k in range(4)) for j in range(4)] for i in range(4)]


def moved(matrix, point):
    return [dot(row, [*point, 1]) for row in matrix[:3]]


def from_axes(x, y, z, origin):
    return [[x[i], y[i], z[i], origin[i]] for i in range(3)] + [[0, 0, 0, 1]]


def rigid_inverse(matrix):
    """Inverse of a matrix of orthonormal axes and an origin."""
    columns = [[matrix[i][j] for i in range(3)] for j in range(4)]
    return [[*columns[j], -dot(columns[j], columns[3])] for j in range(3)] + [[0, 0, 0, 1]]


IDENTITY = from_axes([1, 0, 0], [0, 1, 0], [0, 0, 1], [0, 0, 0])


def transform(word, n):
    """The matrix of a directive; LookAt takes the world into the space of the camera."""
    if word == "Translate":
        return from_axes([1, 0, 0], [0, 1, 0], [0, 0, 1], n)
    if word == "Scale":
        return from_axes([n[0], 0, 0], [0, n[1], 0], [0, 0, n[2]], [0, 0, 0])
    if word == "Rotate":
        axis, c, s = unit(n[1:]), math.cos(math.radians(n[0])), math.sin(math.radians(n[0]))
        def turned(v):  # Rodrigues
            return [c * v[i] + s * cross(axis, v)[i] + (1 - c) * dot(axis, v) * axis[i] for i in range(3)]
        return from_axes(*(turned(v) for v in ([1, 0, 0], [0, 1, 0], [0, 0, 1])), [0, 0, 0])
    forward = unit(minus(n[3:6], n[0:3]))
    right = unit(cross(unit(n[6:9]), forward))
    return rigid_inverse(from_axes(right, cross(forward, right), forward, n[0:3]))


# --- Reading --------------------------------------------------------------------------------------


def without_phong(text):
    """The file with a mixture in place of every Phong material: a diffuse surface, and a white
    metal of the same width, α = √(2 / (n + 2))."""
    count = 0

    def mixture(match):
        nonlocal count
        count += 1
        values = {name: [float(x) for x in numbers.strip("[] ").split()] for name, numbers in re.findall(r'"\w+ (\w+)" (\[[^\]]*\]|[\d.]+)', match[1])}
        amount = sum(values["specular"]) / 3
        diffuse = " ".join(f"{x / (1 - amount):.6g}" for x in values["reflectance"])
        alpha = math.sqrt(2 / (values["exponent"][0] + 2))
        return (f'MakeNamedMaterial "phong {count} below" "string type" "diffuse" "rgb reflectance" [ {diffuse} ]\n'
                f'MakeNamedMaterial "phong {count} above" "string type" "conductor" "rgb reflectance" [ 1 1 1 ] "float roughness" {alpha:.6g} "bool remaproughness" false\n'
                f'Material "mix" "string materials" [ "phong {count} below" "phong {count} above" ] "float amount" {amount:.6g}')

    return re.sub(r'Material "phong"([^\n]*)', mixture, text)


def fresnel(cosine, eta, k):
    """Reflectance of a metal for unpolarised light."""
    sine2 = 1 - cosine * cosine
    t = eta * eta - k * k - sine2
    a2b2 = math.sqrt(t * t + 4 * eta * eta * k * k)
    a = math.sqrt(max(0.0, (a2b2 + t) / 2))
    s = (a2b2 + cosine * cosine - 2 * a * cosine) / (a2b2 + cosine * cosine + 2 * a * cosine)
    p = s * (cosine * cosine * a2b2 + sine2 * sine2 - 2 * a * cosine * sine2) / (cosine * cosine * a2b2 + sine2 * sine2 + 2 * a * cosine * sine2)
    return (s + p) / 2


def metal(parameters):
    """Index of a metal by channel: (eta, k); that with this reflectance head on where one is
    given."""
    if "reflectance" in parameters:
        values = [min(r, 0.9999) for r in parameters["reflectance"]]
        return [1, 1, 1], [2 * math.sqrt(r) / math.sqrt(1 - r) for r in values]
    return parameters["eta"], parameters["k"]


def alpha_of(parameters):
    roughness = parameters.get("roughness", [0])[0]
    return roughness if parameters.get("remaproughness") == [False] else math.sqrt(roughness)


class Reader:
    def __init__(self, text):
        self.tokens = [token for token in TOKEN.findall(text) if not token.startswith("#")]
        self.at = 0

    def next(self):
        self.at += 1
        return self.tokens[self.at - 1]

    def numbers(self, count):
        return [float(self.next()) for _ in range(count)]

    def text(self):
        return self.next().strip('"')

    def value(self, token):
        word = token.strip('"')
        if word in ("true", "false"):
            return word == "true"
        return word if token.startswith('"') else float(word)

    def parameters(self):
        found = {}
        while self.at < len(self.tokens) and re.match(r'"\w+ \w+"', self.tokens[self.at]):
            name = self.text().split()[1]
            values = [self.next()]
            if values == ["["]:
                end = self.tokens.index("]", self.at)
                values, self.at = self.tokens[self.at:end], end + 1
            found[name] = [self.value(value) for value in values]
        return found


def triples(numbers):
    return [list(numbers[i:i + 3]) for i in range(0, len(numbers), 3)]


def read_ply(file):
    """Points and triangles of a binary file with three floats a point."""
    head, rest = file.read_bytes().split(b"end_header\n", 1)
    points, faces = (int(re.search(rb"element %s (\d+)" % what, head)[1]) for what in (b"vertex", b"face"))
    flat = struct.unpack_from(f"<{3 * points}f", rest)
    return triples(flat), [face[1:] for face in FACE.iter_unpack(rest[12 * points:12 * points + FACE.size * faces])]


def shape_of(kind, parameters, matrix, material, emission, folder):
    if kind == "sphere":
        scale = math.sqrt(sum(row[0] ** 2 for row in matrix[:3]))
        return Shape([moved(matrix, [0, 0, 0])], [], scale * parameters["radius"][0], material, emission)
    if kind == "plymesh":
        points, triangles = read_ply(folder / parameters["filename"][0])
        return Shape([moved(matrix, point) for point in points], triangles, None, material, emission)
    points = [moved(matrix, point) for point in triples(parameters["P"])]
    if kind == "bilinearmesh" and len(points) == 4:
        return Shape(points, [[0, 1, 3], [0, 3, 2]], None, material, emission)
    if kind == "trianglemesh" and "N" not in parameters:
        return Shape(points, triples([int(i) for i in parameters["indices"]]), None, material, emission)
    raise ValueError(f"a shape {kind} that is not understood")


def read(file):
    """The description of a file without Phong materials."""
    result, reader = Description(), Reader(file.read_text())
    matrix, material, emission, named, stack = IDENTITY, None, None, {}, []

    def checked(kind, parameters):
        if kind not in MATERIALS:
            raise ValueError(f"a material {kind} that is not understood")
        if kind == "mix":
            parameters["parts"] = [named[name] for name in parameters["materials"]]
        return {"type": kind, **parameters}

    while reader.at < len(reader.tokens):
        word = reader.next()
        if word in NUMBERS_OF:
            matrix = times(matrix, transform(word, reader.numbers(NUMBERS_OF[word])))
        elif word == "Camera":
            reader.text()
            result.fov = reader.parameters()["fov"][0]
            # The axes may be mirrored, but are orthonormal.
            result.camera = rigid_inverse(matrix)
        elif word == "WorldBegin":
            matrix = IDENTITY
        elif word in ("Film", "PixelFilter"):
            reader.text(), reader.parameters()
        elif word == "AttributeBegin":
            stack.append((matrix, material, emission))
        elif word == "AttributeEnd":
            matrix, material, emission = stack.pop()
        elif word == "MakeNamedMaterial":
            name, parameters = reader.text(), reader.parameters()
            named[name] = checked(parameters.pop("type")[0], parameters)
        elif word == "NamedMaterial":
            material = named[reader.text()]
        elif word == "Material":
            material = checked(reader.text(), reader.parameters())
        elif word == "AreaLightSource":
            reader.text()
            emission = reader.parameters()["L"]
        elif word == "LightSource" and reader.text() == "distant":
            parameters = reader.parameters()
            result.distant.append((unit(minus(parameters["to"], parameters["from"])), parameters["L"]))
        elif word == "Shape":
            result.shapes.append(shape_of(reader.text(), reader.parameters(), matrix, material, emission, file.parent))
        else:
            raise ValueError(f"{word} is not understood")
    return result


# --- Shapes ---------------------------------------------------------------------------------------


def sphere_mesh(divisions):
    """Points and triangles of a unit sphere: an icosahedron whose triangles are quartered
    `divisions` times, outward normals."""
    g = (1 + math.sqrt(5)) / 2
    points = [unit(p) for p in ([-1, g, 0], [1, g, 0], [-1, -g, 0], [1, -g, 0], [0, -1, g], [0, 1, g], [0, -1, -g], [0, 1, -g],
                                [g, 0, -1], [g, 0, 1], [-g, 0, -1], [-g, 0, 1])]
    triangles = [[0, 11, 5], [0, 5, 1], [0, 1, 7], [0, 7, 10], [0, 10, 11], [1, 5, 9], [5, 11, 4], [11, 10, 2], [10, 7, 6], [7, 1, 8],
                 [3, 9, 4], [3, 4, 2], [3, 2, 6], [3, 6, 8], [3, 8, 9], [4, 9, 5], [2, 4, 11], [6, 2, 10], [8, 6, 7], [9, 8, 1]]
    for _ in range(divisions):
        middles, finer = {}, []

        def middle(a, b):
            key = (min(a, b), max(a, b))
            if key not in middles:
                middles[key] = len(points)
                points.append(unit([x + y for x, y in zip(points[a], points[b])]))
            return middles[key]

        for a, b, c in triangles:
            ab, bc, ca = middle(a, b), middle(b, c), middle(c, a)
            finer += [[a, ab, ca], [b, bc, ab], [c, ca, bc], [ab, bc, ca]]
        triangles = finer
    return points, triangles


def with_meshes(text):
    """The file with the mesh that Cycles gets, with smooth normals, in place of every sphere."""
    points, triangles = sphere_mesh(DIVISIONS)
    indices = " ".join(str(i) for triangle in triangles for i in triangle)
    normals = " ".join(f"{x:.7g}" for point in points for x in point)

    def mesh(match):
        moved_out = " ".join(f"{float(match[1]) * x:.7g}" for point in points for x in point)
        return f'Shape "trianglemesh" "integer indices" [ {indices} ] "point3 P" [ {moved_out} ] "normal N" [ {normals} ]'

    return re.sub(r'Shape "sphere" "float radius" ([\d.]+)', mesh, text)


def rectangle(shape):
    """Centre, the two edges and the unit normal of a shape that is a rectangle."""
    a, b, c = (shape.points[i] for i in shape.triangles[0])
    normal = unit(cross(minus(b, a), minus(c, a)))
    for p, q, r in ((a, b, c), (b, c, a), (c, a, b)):
        edges = minus(q, p), minus(r, p)
        if len(shape.points) == 4 and abs(dot(*edges)) < 1e-9:
            return [(x + y) / 2 for x, y in zip(q, r)], *edges, normal
    raise ValueError("a lamp that is neither a rectangle nor a sphere")


def around(shape, description):
    """The index of the glass that a sphere lies in, or 1."""
    for other in description.shapes:
        if other is not shape and other.radius and other.material["type"] == "dielectric":
            between = minus(other.points[0], shape.points[0])
            if math.sqrt(dot(between, between)) + shape.radius < other.radius:
                return other.material["eta"][0]
    return 1
