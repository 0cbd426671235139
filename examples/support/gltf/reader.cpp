#include "support/gltf/reader.hpp"

#if GMIS_HAS_JSON

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/gtc/quaternion.hpp>
#include <glm/matrix.hpp>
#include <numbers>
#include <utility>

#include "support/gltf/materials.hpp"
#include "support/gltf/nodes.hpp"
#include "support/gltf/primitive.hpp"
#include "support/pbrt/transform.hpp"
#include "support/sky.hpp"

namespace gmis::tools {

bool can_read_gltf() {
  return true;
}

namespace gltf {
namespace {

/// Reports each extension in extensionsRequired that is not supported here, before anything else is
/// read.
void require_extensions(const Document& document, Diagnostics& diagnostics) {
  static const std::set<std::string> understood {
    "KHR_lights_punctual", "KHR_texture_transform", "KHR_mesh_quantization", "EXT_mesh_gpu_instancing",
#if GMIS_HAS_MESHOPT
        "EXT_meshopt_compression", "KHR_meshopt_compression",
#endif
#if GMIS_HAS_DRACO
        "KHR_draco_mesh_compression",
#endif
        "KHR_node_visibility"
  };
  const Json& required = Document::member(document.root(), "extensionsRequired");
  if (!required.is_array()) return;
  for (const Json& name : required)
    if (name.is_string() && !understood.contains(name.get<std::string>()) &&
        !Materials::understood_extensions().contains(name.get<std::string>()))
      diagnostics.unsupported(document.where(), "the file needs the extension " + in_quotes(name.get<std::string>()) +
                                                    ", which is not read: export it without, or use --lenient");
}

/// Walks through the nodes of a file.
class Reader {
 public:
  Reader(const Document& document, SceneDescription& scene, Diagnostics& diagnostics, std::optional<double> seconds)
      : document_(document),
        scene_(scene),
        diagnostics_(diagnostics),
        nodes_(document, seconds),
        materials_(document, scene, diagnostics) {
    if (document.count("animations") == 0) return;
    if (!seconds)
      diagnostics.note(document.where(), "animations are ignored: the scene is shown as it stands (see --at)");
    else if (document.count("animations") > 1)
      diagnostics.note(document.where(), "the first of several animations is shown");
  }

  void read() {
    for (const std::size_t node : nodes_.shown()) visit(node);
    if (scene_.shapes.empty())
      throw document_.error(skipped_ == 0
                                ? "the scene holds no triangle"
                                : "the scene holds points and lines alone, which are not rendered: no triangle");
    if (skipped_ > 0)
      diagnostics_.warning(document_.where(), std::to_string(skipped_) + " parts of points or lines are left out");
    if (!has_camera_) {
      scene_.camera = camera_outside();
      diagnostics_.note(document_.where(), "the scene has no camera: all of it is seen from before and above");
    }
    // Emissive materials do not count as lights: such a scene gets the sky, too.
    if (scene_.lights.empty()) {
      scene_.lights.push_back({studio_sky(), document_.where()});
      diagnostics_.note(document_.where(),
                        "the scene has no light but emissive materials: the sky \"studio\" is added (see --sky)");
      const auto transmits = [](const MaterialDescription& material) {
        return std::holds_alternative<DielectricDescription>(material.kind);
      };
      const auto shines = [](const ShapeDescription& shape) { return shape.emission.has_value(); };
      if (has_camera_ && std::none_of(scene_.materials.begin(), scene_.materials.end(), transmits) &&
          std::none_of(scene_.shapes.begin(), scene_.shapes.end(), shines))
        scene_.camera_outside = camera_outside();
    }
  }

 private:
  void visit(std::size_t number) {
    const Json& node = document_.entry("nodes", number);
    const glm::dmat4& world_from_node = nodes_.world_from(number);
    if (const auto camera = document_.index(node, "camera"); camera && !has_camera_)
      add_camera(*camera, document_.named("node", node, number), world_from_node);
    if (nodes_.is_hidden(number)) return;
    if (const auto mesh = document_.index(node, "mesh")) add_mesh(*mesh, node, number);
    const Json& light = Document::extension(node, "KHR_lights_punctual");
    if (const auto place = document_.index(light, "light")) add_light(*place, world_from_node);
  }

  void add_mesh(std::size_t number, const Json& node, std::size_t node_number) {
    const Json& mesh = document_.entry("meshes", number, document_.named("node", node, node_number));
    const std::string name = document_.named("mesh", mesh, number);
    std::vector<double> weights = nodes_.weights_of(node_number);
    for (const Json* owner : {&node, &mesh})
      if (const Json& list = Document::member(*owner, "weights"); weights.empty() && list.is_array())
        weights = document_.numbers(*owner, "weights", std::vector<double>(list.size()));
    const std::vector<glm::dmat4> bones = bones_of(node);
    const std::vector<glm::dmat4> places = places_of(node, nodes_.world_from(node_number));
    for (const Json& json : Document::member(mesh, "primitives")) {
      const Primitive primitive(document_, json, name);
      if (primitive.has_no_triangles()) {
        ++skipped_;
        continue;
      }
      if (!primitive.has("POSITION")) continue;
      add_primitive(primitive, weights, bones, places);
    }
  }

  /// The transformation of a vertex to the world, for each joint of the skin of a node; none where
  /// it has no skin.
  [[nodiscard]] std::vector<glm::dmat4> bones_of(const Json& node) const {
    const auto number = document_.index(node, "skin");
    if (!number) return {};
    const Json& skin = document_.entry("skins", *number, "a node");
    const Json& joints = Document::member(skin, "joints");
    if (!joints.is_array()) throw document_.error("a skin has no joints");
    std::vector<double> inverse;
    if (const auto matrices = document_.index(skin, "inverseBindMatrices"))
      inverse = document_.accessor(*matrices, 16, "a skin");
    if (!inverse.empty() && inverse.size() < 16 * joints.size()) throw document_.error("a skin has too few matrices");
    std::vector<glm::dmat4> bones;
    for (std::size_t i = 0; i < joints.size(); ++i) {
      const double joint = joints[i].is_number() ? joints[i].get<double>() : -1;
      if (!(joint >= 0 && joint < static_cast<double>(document_.count("nodes"))))
        throw document_.error("a skin has a joint that is not there");
      glm::dmat4 bind(1);
      if (!inverse.empty())
        for (int k = 0; k < 16; ++k) bind[k / 4][k % 4] = inverse[16 * i + static_cast<std::size_t>(k)];
      bones.push_back(nodes_.world_from(static_cast<std::size_t>(joint)) * bind);
    }
    return bones;
  }

  /// world_from_mesh, for each instance of EXT_mesh_gpu_instancing or for the only one.
  [[nodiscard]] std::vector<glm::dmat4> places_of(const Json& node, const glm::dmat4& world_from_node) const {
    const Json& attributes = Document::member(Document::extension(node, "EXT_mesh_gpu_instancing"), "attributes");
    if (!attributes.is_object()) return {world_from_node};
    const auto read = [&](const char* name, std::size_t width) {
      const auto number = document_.index(attributes, name);
      return number ? document_.accessor(*number, width) : std::vector<double>();
    };
    const std::vector<double> t = read("TRANSLATION", 3), r = read("ROTATION", 4), s = read("SCALE", 3);
    const std::size_t count = std::max({t.size() / 3, r.size() / 4, s.size() / 3});
    if ((!t.empty() && t.size() != 3 * count) || (!r.empty() && r.size() != 4 * count) ||
        (!s.empty() && s.size() != 3 * count))
      throw document_.error("the attributes of EXT_mesh_gpu_instancing differ in length");
    document_.budget().take(count, sizeof(glm::dmat4), "the instances of a mesh", document_.where());
    std::vector<glm::dmat4> places;
    for (std::size_t i = 0; i < count; ++i) {
      glm::dmat4 m(1);
      if (!r.empty())
        m = glm::mat4_cast(glm::normalize(glm::dquat(r[4 * i + 3], r[4 * i], r[4 * i + 1], r[4 * i + 2])));
      for (std::size_t axis = 0; axis < 3 && !s.empty(); ++axis) m[static_cast<int>(axis)] *= s[3 * i + axis];
      if (!t.empty()) m[3] = glm::dvec4(t[3 * i], t[3 * i + 1], t[3 * i + 2], 1);
      places.push_back(world_from_node * m);
    }
    return places;
  }

  void add_primitive(const Primitive& primitive, const std::vector<double>& weights,
                     const std::vector<glm::dmat4>& bones, const std::vector<glm::dmat4>& places) {
    MeshDescription mesh;
    mesh.positions = primitive.triples("POSITION");
    mesh.normals = primitive.triples("NORMAL");
    if (!mesh.normals.empty()) require_count(primitive, "NORMAL", mesh.normals.size(), mesh.positions.size());
    morph(primitive, weights, mesh);
    if (!bones.empty()) pose(primitive, bones, mesh);
    for (const Point& p : mesh.positions)
      if (!(glm::dot(p, p) < 1e18)) throw document_.error(primitive.name() + " has a coordinate above 1e9");
    mesh.triangles = primitive.triangles(mesh.positions.size());
    if (mesh.triangles.empty()) return;
    MadeMaterial material = dress(primitive, mesh);
    for (glm::dvec3& n : mesh.normals) {
      const double length = glm::length(n);
      if (!(length > 0) || !std::isfinite(length)) {
        mesh.normals.clear();
        break;
      }
      n /= length;
    }
    const ShapeDescription shape{std::move(mesh),   material.number,  material.emission,
                                 document_.where(), material.opacity, material.absorption};
    for (const glm::dmat4& place : bones.empty() ? places : std::vector{glm::dmat4(1)}) {
      document_.budget().take(built_bytes_of(shape), primitive.name(), document_.where());
      auto placed = pbrt::transformed(shape, place);
      if (placed && area_of(*placed) > 0) scene_.shapes.push_back(std::move(*placed));
    }
  }

  /// An attribute has a value for each vertex.
  void require_count(const Primitive& primitive, const std::string& attribute, std::size_t count,
                     std::size_t vertices) const {
    if (count != vertices)
      throw document_.error(primitive.name() + ": " + attribute + " has " + std::to_string(count) + " values for " +
                            std::to_string(vertices) + " vertices");
  }

  /// Moves vertices by the morph targets.
  void morph(const Primitive& primitive, const std::vector<double>& weights, MeshDescription& mesh) const {
    const Json& targets = Document::member(primitive.json(), "targets");
    if (!targets.is_array()) return;
    for (std::size_t k = 0; k < std::min(targets.size(), weights.size()); ++k) {
      if (weights[k] == 0) continue;
      const auto add = [&](const char* name, auto& to) {
        const auto number = document_.index(targets[k], name);
        if (!number || to.empty()) return;
        const std::vector<double> moved = document_.accessor(*number, 3);
        require_count(primitive, std::string(name) + " of a morph target", moved.size() / 3, to.size());
        for (std::size_t i = 0; i < to.size(); ++i)
          to[i] += weights[k] * glm::dvec3(moved[3 * i], moved[3 * i + 1], moved[3 * i + 2]);
      };
      add("POSITION", mesh.positions);
      add("NORMAL", mesh.normals);
    }
  }

  /// Skins positions and normals; the results are in the world frame.
  void pose(const Primitive& primitive, const std::vector<glm::dmat4>& bones, MeshDescription& mesh) const {
    std::vector<glm::dmat4> of_vertex(mesh.positions.size(), glm::dmat4(0));
    std::vector<double> sums(mesh.positions.size(), 0);
    for (int set = 0; set < 4; ++set) {
      const std::vector<double> joints = primitive.numbers("JOINTS_" + std::to_string(set), 4);
      const std::vector<double> shares = primitive.numbers("WEIGHTS_" + std::to_string(set), 4);
      if (joints.empty() || shares.empty()) break;
      if (joints.size() != 4 * mesh.positions.size() || shares.size() != joints.size())
        throw document_.error(primitive.name() + " has too few joints or weights");
      for (std::size_t i = 0; i < joints.size(); ++i) {
        if (shares[i] == 0) continue;
        if (!(joints[i] >= 0 && joints[i] < static_cast<double>(bones.size())))
          throw document_.error(primitive.name() + " has a joint that its skin has not");
        of_vertex[i / 4] += bones[static_cast<std::size_t>(joints[i])] * shares[i];
        sums[i / 4] += shares[i];
      }
    }
    for (std::size_t i = 0; i < mesh.positions.size(); ++i) {
      if (!(sums[i] > 0)) continue;  // held by nothing
      const glm::dmat4 m = of_vertex[i] / sums[i];
      mesh.positions[i] = pbrt::transform_point(m, mesh.positions[i]);
      if (mesh.normals.empty()) continue;
      if (pbrt::is_invertible_affine(m))
        mesh.normals[i] = glm::transpose(glm::inverse(glm::dmat3(m))) * mesh.normals[i];
      else
        mesh.normals[i] = glm::dmat3(m) * mesh.normals[i];
    }
  }

  /// The coordinates of a mesh and its material. Where one set of coordinates does for all
  /// textures, and vertices have no colours, the mesh keeps its vertices; else each triangle gets
  /// coordinates of its own.
  [[nodiscard]] MadeMaterial dress(const Primitive& primitive, MeshDescription& mesh) {
    const auto number = document_.index(primitive.json(), "material");
    std::map<std::size_t, std::vector<glm::dvec2>> sets;
    for (const std::size_t set : materials_.coordinate_sets(number)) {
      const std::vector<double> numbers = primitive.numbers("TEXCOORD_" + std::to_string(set), 2);
      auto& uv = sets[set];
      // glTF counts from the top of an image.
      for (std::size_t i = 0; i + 1 < numbers.size(); i += 2) uv.emplace_back(numbers[i], 1 - numbers[i + 1]);
      if (uv.size() == mesh.positions.size()) continue;
      diagnostics_.unsupported(document_.where(), primitive.name() + " has textures over TEXCOORD_" +
                                                      std::to_string(set) +
                                                      ", which it lacks: add it to the mesh; with --lenient the "
                                                      "textures show one texel");
      uv.assign(mesh.positions.size(), glm::dvec2(0, 1));
    }
    const bool has_colors = primitive.has("COLOR_0");
    if (sets.size() <= 1 && !has_colors) {
      if (!sets.empty()) mesh.uv = sets.begin()->second;
      return materials_.at(number);
    }
    return dress_by_triangle(primitive, mesh, sets, has_colors);
  }

  [[nodiscard]] MadeMaterial dress_by_triangle(const Primitive& primitive, MeshDescription& mesh,
                                               const std::map<std::size_t, std::vector<glm::dvec2>>& sets,
                                               bool has_colors) {
    const auto number = document_.index(primitive.json(), "material");
    std::vector<std::size_t> corners;
    for (const auto& triangle : mesh.triangles)
      for (const int corner : triangle) corners.push_back(static_cast<std::size_t>(corner));
    document_.budget().take(corners.size(), 200, primitive.name(), document_.where());
    const auto split = [&](const auto& values) {
      std::remove_cvref_t<decltype(values)> result;
      for (const std::size_t corner : corners) result.push_back(values[corner]);
      return result;
    };
    const auto tangent_set = materials_.normal_map_set(number);
    const TriangleCharts charts(mesh.triangles.size(),
                                tangent_set ? split(sets.at(*tangent_set)) : std::vector<glm::dvec2>());
    const auto function = [&](const std::vector<glm::dvec3>& values) {
      return charts.function(values, document_.budget(), document_.where());
    };
    SurfaceLayout layout;
    std::map<std::size_t, TextureHandle> coordinates;
    for (const auto& [set, uv] : sets) {
      std::vector<glm::dvec3> values;
      for (const std::size_t corner : corners) values.emplace_back(uv[corner], 0);
      coordinates[set] = function(values);
    }
    layout.over = [&](std::size_t set, TextureHandle image) {
      return scene::Texture<float>::through(coordinates.at(set), std::move(image));
    };
    if (has_colors) {
      const std::size_t width = primitive.components_of("COLOR_0");
      const std::vector<double> numbers = primitive.numbers("COLOR_0", width);
      if (width < 3 || width > 4 || numbers.size() != width * mesh.positions.size())
        throw document_.error(primitive.name() + " has colours that are not one a vertex");
      std::vector<glm::dvec3> colors, alphas;
      bool has_alpha = false;
      for (const std::size_t corner : corners) {
        const double* c = numbers.data() + width * corner;
        colors.push_back(glm::clamp(glm::dvec3(c[0], c[1], c[2]), glm::dvec3(0), glm::dvec3(1)));
        const double alpha = width == 4 ? std::clamp(c[3], 0.0, 1.0) : 1;
        alphas.emplace_back(alpha);
        has_alpha = has_alpha || alpha < 1;
      }
      // Only a radiance needs the slower one: of other colours a material cuts what is beyond.
      layout.vertex_color = materials_.is_unlit(number)
                                ? charts.fractions(colors, document_.budget(), document_.where())
                                : function(colors);
      if (has_alpha) layout.vertex_alpha = function(alphas);
    }
    mesh.positions = split(mesh.positions);
    if (!mesh.normals.empty()) mesh.normals = split(mesh.normals);
    mesh.uv = charts.uv();
    for (std::size_t k = 0; k < mesh.triangles.size(); ++k)
      for (std::size_t i = 0; i < 3; ++i) mesh.triangles[k][i] = static_cast<int>(3 * k + i);
    return materials_.made(number, layout);
  }

  void add_camera(std::size_t number, const std::string& owner, const glm::dmat4& world_from_node) {
    const Json& camera = document_.entry("cameras", number, owner);
    const std::string name = document_.named("camera", camera, number);
    // A camera of glTF looks along −z; the scale of its node is ignored.
    glm::dmat4 m = world_from_node;
    m[2] = -m[2];
    for (int i = 0; i < 3; ++i) {
      const double length = glm::length(glm::dvec3(m[i]));
      if (!(length > 0)) throw document_.error(name + " is scaled to nothing");
      m[i] /= length;
    }
    if (!pbrt::similarity_scale(m)) {
      const auto upright = pbrt::made_similarity(m);
      if (!upright) throw document_.error(name + " is stretched");
      m = *upright;
    }
    CameraDescription& made = scene_.camera;
    made.world_from_camera = m;
    made.where = document_.where();
    double aspect = static_cast<double>(scene_.film.width) / scene_.film.height;
    if (document_.text(camera, "type") == "orthographic") {
      const Json& parallel = Document::member(camera, "orthographic");
      const double x = std::abs(document_.number(parallel, "xmag", 0)),
                   y = std::abs(document_.number(parallel, "ymag", 0));
      if (!(x > 0 && y > 0)) throw document_.error(name + " sees nothing: give it an xmag and a ymag");
      made.is_orthographic = true;
      made.screen_window = std::array{-x, x, -y, y};
      aspect = x / y;
    } else {
      const Json& perspective = Document::member(camera, "perspective");
      if (const double given = document_.number(perspective, "aspectRatio", 0); given > 0) aspect = given;
      const double fov = document_.number(perspective, "yfov", 0);
      if (!(fov > 1e-4 && fov < 3.1)) throw document_.error(name + " has a yfov that is not from 0.0001 to 3.1");
      made.vertical_field_of_view = fov * 180 / std::numbers::pi;
    }
    aspect = std::clamp(aspect, 1e-2, 1e2);
    scene_.film.width = std::max(1, static_cast<int>(std::lround(scene_.film.height * aspect)));
    has_camera_ = true;
  }

  /// Before the whole scene, a little from above.
  [[nodiscard]] CameraDescription camera_outside() const {
    Point lower(1e300), upper(-1e300);
    for (const ShapeDescription& shape : scene_.shapes)
      for (const Point& p : std::get<MeshDescription>(shape.geometry).positions)
        lower = glm::min(lower, p), upper = glm::max(upper, p);
    const Point middle = (lower + upper) * 0.5;
    const double radius = std::max(glm::length(upper - lower) / 2, 1e-9);
    CameraDescription camera;
    camera.field_of_view = 45;
    const glm::dvec3 from =
        glm::normalize(glm::dvec3(0.5, 0.4, 1)) * (radius / std::sin(22.5 * std::numbers::pi / 180));
    camera.world_from_camera = glm::inverse(*pbrt::look_at(middle + from, middle, {0, 1, 0}));
    // `look_at` makes a left-handed camera space; glTF is right-handed: mirror x.
    camera.world_from_camera[0] = -camera.world_from_camera[0];
    camera.where = document_.where();
    return camera;
  }

  void add_light(std::size_t number, const glm::dmat4& world_from_node) {
    const Json& lights = Document::member(Document::extension(document_.root(), "KHR_lights_punctual"), "lights");
    if (!lights.is_array() || number >= lights.size())
      throw document_.error("a node: light " + std::to_string(number) + " of KHR_lights_punctual is not there");
    const Json& light = lights[number];
    const std::string name = document_.named("light", light, number);
    const auto list = document_.numbers(light, "color", {1, 1, 1});
    const double intensity = document_.number(light, "intensity", 1);
    constexpr double brightest = 1e20;
    if (!(intensity >= 0 && intensity <= brightest))
      throw document_.error(name + " has an intensity that is negative or above 1e20");
    for (const double c : list)
      if (!(c >= 0 && c <= brightest)) throw document_.error(name + " has a colour that is negative or above 1e20");
    const Rgb power = Rgb(list[0], list[1], list[2]) * intensity;
    if (!(std::max({power.x, power.y, power.z}) <= brightest)) throw document_.error(name + " is brighter than 1e20");
    if (power == Rgb(0)) return;
    const Point position(world_from_node[3]);
    const double length = glm::length(glm::dvec3(world_from_node[2]));
    const glm::dvec3 direction = length > 0 ? -glm::dvec3(world_from_node[2]) / length : glm::dvec3(0, 0, -1);
    if (document_.number(light, "range", 0) > 0)
      diagnostics_.note(document_.where(), "the range of a light is ignored: its light reaches any distance");
    const std::string type = document_.text(light, "type");
    if (type == "directional") {
      scene_.lights.push_back({DistantLightDescription{-direction, power}, document_.where()});
    } else if (type == "point") {
      scene_.lights.push_back({PointLightDescription{position, power}, document_.where()});
    } else if (type == "spot") {
      const Json& cone = Document::member(light, "spot");
      SpotLightDescription spot{position, direction, power};
      spot.outer = std::clamp(document_.number(cone, "outerConeAngle", std::numbers::pi / 4), 1e-3, std::numbers::pi);
      spot.inner = std::clamp(document_.number(cone, "innerConeAngle", 0), 0.0, spot.outer);
      scene_.lights.push_back({spot, document_.where()});
    } else {
      diagnostics_.unsupported(document_.where(), name + " is of type " + in_quotes(type));
    }
  }

  const Document& document_;
  SceneDescription& scene_;
  Diagnostics& diagnostics_;
  Nodes nodes_;
  Materials materials_;
  bool has_camera_ = false;
  std::size_t skipped_ = 0;  ///< parts of points or lines
};

SceneDescription scene_of(const Document& document, SceneDescription& scene, const std::filesystem::path& file,
                          Diagnostics& diagnostics, const LoadOptions& options) {
  require_extensions(document, diagnostics);
  scene.film.file_name = file.stem().string() + ".exr";
  scene.materials.push_back({DiffuseDescription{}, document.where(), {}});
  Reader(document, scene, diagnostics, options.seconds).read();
  return std::move(scene);
}

}  // namespace
}  // namespace gltf

SceneDescription read_gltf_scene(const std::filesystem::path& file, Diagnostics& diagnostics,
                                 const LoadOptions& options) {
  LoadBudget budget(options.max_memory.value_or(LoadBudget::default_limit()));
  SceneDescription scene;
  add_file(scene, file);
  const gltf::Document document(file, budget, [&](const std::filesystem::path& used) { add_file(scene, used); });
  return gltf::scene_of(document, scene, file, diagnostics, options);
}

SceneDescription read_gltf_bytes(std::string bytes, const std::filesystem::path& file, Diagnostics& diagnostics,
                                 const LoadOptions& options) {
  LoadBudget budget(options.max_memory.value_or(LoadBudget::default_limit()));
  SceneDescription scene;
  const gltf::Document document(std::move(bytes), file, budget,
                                [&](const std::filesystem::path& used) { add_file(scene, used); });
  return gltf::scene_of(document, scene, file, diagnostics, options);
}

}  // namespace gmis::tools

#else

namespace gmis::tools {

bool can_read_gltf() {
  return false;
}

SceneDescription read_gltf_scene(const std::filesystem::path& file, Diagnostics&, const LoadOptions&) {
  throw InputError(file.string() +
                   ": this program was built without the library nlohmann_json, which reads glTF: use a .pbrt file");
}

SceneDescription read_gltf_bytes(std::string, const std::filesystem::path& file, Diagnostics& diagnostics,
                                 const LoadOptions& options) {
  return read_gltf_scene(file, diagnostics, options);
}

}  // namespace gmis::tools

#endif
