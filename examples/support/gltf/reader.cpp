#include "support/gltf/reader.hpp"

#if GMIS_HAS_TINYGLTF

#include <algorithm>
#include <charconv>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/gtc/quaternion.hpp>
#include <glm/matrix.hpp>
#include <numbers>
#include <utility>

#include "support/gltf/accessors.hpp"
#include "support/gltf/materials.hpp"
#include "support/pbrt/transform.hpp"

namespace gmis::tools {

bool can_read_gltf() {
  return true;
}

namespace gltf {
namespace {

/// Keeps the bytes of an image as they are.
bool keep_bytes(tinygltf::Image* image, const int, std::string*, std::string*, int, int, const unsigned char* bytes,
                int count, void*) {
  image->image.assign(bytes, bytes + count);
  image->as_is = true;
  return true;
}

/// Walks through the nodes of a model.
class Reader {
 public:
  Reader(const tinygltf::Model& model, const SourcePosition& where, SceneDescription& scene, Diagnostics& diagnostics)
      : model_(model),
        where_(where),
        scene_(scene),
        diagnostics_(diagnostics),
        materials_(model, scene, where, diagnostics) {}

  void read() {
    static const std::set<std::string> understood{"KHR_lights_punctual",
                                                  "KHR_materials_transmission",
                                                  "KHR_materials_ior",
                                                  "KHR_materials_volume",
                                                  "KHR_materials_emissive_strength",
                                                  "KHR_materials_specular",
                                                  "KHR_texture_transform",
                                                  "KHR_mesh_quantization"};
    for (const std::string& name : model_.extensionsRequired)
      if (!understood.contains(name)) diagnostics_.unsupported(where_, "the file needs " + name);
    if (!model_.animations.empty())
      diagnostics_.note(where_, "animations are ignored: the scene is shown as it stands");
    if (model_.scenes.empty()) throw InputError(where_, "the file holds no scene");
    const int number = std::clamp(model_.defaultScene, 0, static_cast<int>(model_.scenes.size()) - 1);
    for (const int node : model_.scenes[static_cast<std::size_t>(number)].nodes) visit(node, glm::dmat4(1), 0);
    if (scene_.shapes.empty()) throw InputError(where_, "the scene holds no triangle");
    if (!has_camera_) place_camera();
    const bool has_light = !scene_.lights.empty() || std::any_of(scene_.shapes.begin(), scene_.shapes.end(),
                                                                 [](const auto& s) { return s.emission.has_value(); });
    if (!has_light) {
      scene_.lights.push_back({InfiniteLightDescription{Rgb(1)}, where_});
      diagnostics_.note(where_, "the scene has no light: a white sky of radiance 1 lights it");
    }
  }

 private:
  void visit(int number, const glm::dmat4& world_from_parent, int depth) {
    constexpr int deepest = 1000;
    if (number < 0 || static_cast<std::size_t>(number) >= model_.nodes.size() || depth > deepest)
      throw InputError(where_, "node " + std::to_string(number) + " is not there, or its own ancestor");
    const tinygltf::Node& node = model_.nodes[static_cast<std::size_t>(number)];
    const glm::dmat4 world_from_node = world_from_parent * matrix_of(node);
    if (node.skin >= 0) diagnostics_.unsupported(where_, "node " + in_quotes(node.name) + ": a skin");
    if (node.mesh >= 0) add_mesh(node.mesh, world_from_node);
    if (node.camera >= 0 && !has_camera_) add_camera(node.camera, world_from_node);
    if (const auto found = node.extensions.find("KHR_lights_punctual");
        found != node.extensions.end() && found->second.Has("light"))
      add_light(found->second.Get("light").GetNumberAsInt(), world_from_node);
    for (const int child : node.children) visit(child, world_from_node, depth + 1);
  }

  [[nodiscard]] static glm::dmat4 matrix_of(const tinygltf::Node& node) {
    glm::dmat4 m(1);
    if (node.matrix.size() == 16) {
      for (int i = 0; i < 16; ++i) m[i / 4][i % 4] = node.matrix[static_cast<std::size_t>(i)];
      return m;
    }
    if (node.rotation.size() == 4)
      m = glm::mat4_cast(glm::dquat(node.rotation[3], node.rotation[0], node.rotation[1], node.rotation[2]));
    if (node.scale.size() == 3)
      for (int i = 0; i < 3; ++i) m[i] *= node.scale[static_cast<std::size_t>(i)];
    if (node.translation.size() == 3)
      m[3] = glm::dvec4(node.translation[0], node.translation[1], node.translation[2], 1);
    return m;
  }

  void add_mesh(int number, const glm::dmat4& world_from_node) {
    if (static_cast<std::size_t>(number) >= model_.meshes.size()) throw InputError(where_, "a mesh is not there");
    const tinygltf::Mesh& mesh = model_.meshes[static_cast<std::size_t>(number)];
    for (const double weight : mesh.weights)
      if (weight != 0) diagnostics_.unsupported(where_, "mesh " + in_quotes(mesh.name) + ": a morph target");
    if (!pbrt::is_invertible_affine(world_from_node)) return;  // scaled to nothing
    for (const tinygltf::Primitive& primitive : mesh.primitives) add_primitive(mesh.name, primitive, world_from_node);
  }

  void add_primitive(const std::string& name, const tinygltf::Primitive& primitive, const glm::dmat4& world_from_node) {
    const auto attribute = [&](const std::string& wanted) {
      const auto found = primitive.attributes.find(wanted);
      return found == primitive.attributes.end() ? -1 : found->second;
    };
    const int mode = primitive.mode < 0 ? TINYGLTF_MODE_TRIANGLES : primitive.mode;
    if (mode != TINYGLTF_MODE_TRIANGLES && mode != TINYGLTF_MODE_TRIANGLE_STRIP && mode != TINYGLTF_MODE_TRIANGLE_FAN) {
      diagnostics_.unsupported(where_, "mesh " + in_quotes(name) + ": points or lines");
      return;
    }
    if (attribute("POSITION") < 0) return;
    if (attribute("COLOR_0") >= 0)
      diagnostics_.unsupported(where_, "mesh " + in_quotes(name) + ": colours at its vertices");
    const MadeMaterial& material = materials_.at(primitive.material);
    MeshDescription mesh;
    mesh.positions = triples_of(model_, attribute("POSITION"), where_);
    for (const Point& p : mesh.positions)
      if (!(glm::dot(p, p) < 1e30))
        throw InputError(where_, "mesh " + in_quotes(name) + " has a coordinate that is no number");
    if (attribute("NORMAL") >= 0) mesh.normals = triples_of(model_, attribute("NORMAL"), where_);
    if (const int uv = attribute("TEXCOORD_" + std::to_string(material.uv_set)); uv >= 0) {
      const std::vector<double> numbers = numbers_of(model_, uv, 2, where_);
      // glTF counts from the top of an image.
      for (std::size_t i = 0; i < numbers.size(); i += 2) mesh.uv.emplace_back(numbers[i], 1 - numbers[i + 1]);
    }
    if (mesh.normals.size() != mesh.positions.size()) mesh.normals.clear();
    if (mesh.uv.size() != mesh.positions.size()) mesh.uv.clear();
    for (glm::dvec3& n : mesh.normals) {
      const double length = glm::length(n);
      if (!(length > 0) || !std::isfinite(length)) {
        mesh.normals.clear();
        break;
      }
      n /= length;
    }
    std::vector<int> corners;
    if (primitive.indices >= 0) {
      for (const double index : numbers_of(model_, primitive.indices, 1, where_)) {
        if (!(index >= 0 && index < static_cast<double>(mesh.positions.size())))
          throw InputError(where_, "mesh " + in_quotes(name) + " refers to a vertex that is not there");
        corners.push_back(static_cast<int>(index));
      }
    } else {
      for (std::size_t i = 0; i < mesh.positions.size(); ++i) corners.push_back(static_cast<int>(i));
    }
    const std::size_t step = mode == TINYGLTF_MODE_TRIANGLES ? 3 : 1;
    for (std::size_t i = 0; i + 2 < corners.size(); i += step) {
      if (mode == TINYGLTF_MODE_TRIANGLE_FAN)
        mesh.triangles.push_back({corners[0], corners[i + 1], corners[i + 2]});
      else if (mode == TINYGLTF_MODE_TRIANGLE_STRIP && i % 2 == 1)
        mesh.triangles.push_back({corners[i + 1], corners[i], corners[i + 2]});
      else
        mesh.triangles.push_back({corners[i], corners[i + 1], corners[i + 2]});
    }
    if (mesh.triangles.empty()) return;
    ShapeDescription shape;
    shape.geometry = std::move(mesh);
    shape.material = material.number;
    shape.emission = material.emission;
    shape.opacity = material.opacity;
    shape.absorption = material.absorption;
    shape.where = where_;
    scene_.shapes.push_back(*pbrt::transformed(std::move(shape), world_from_node));
  }

  void add_camera(int number, const glm::dmat4& world_from_node) {
    if (static_cast<std::size_t>(number) >= model_.cameras.size()) throw InputError(where_, "a camera is not there");
    const tinygltf::Camera& camera = model_.cameras[static_cast<std::size_t>(number)];
    // glTF looks along −z; its scale is not to count.
    glm::dmat4 m = world_from_node;
    m[2] = -m[2];
    for (int i = 0; i < 3; ++i) {
      const double length = glm::length(glm::dvec3(m[i]));
      if (!(length > 0)) throw InputError(where_, "camera " + in_quotes(camera.name) + " is scaled to nothing");
      m[i] /= length;
    }
    if (!pbrt::similarity_scale(m)) {
      const auto upright = pbrt::made_similarity(m);
      if (!upright) throw InputError(where_, "camera " + in_quotes(camera.name) + " is stretched");
      m = *upright;
    }
    CameraDescription& made = scene_.camera;
    made.world_from_camera = m;
    made.where = where_;
    double aspect = static_cast<double>(scene_.film.width) / scene_.film.height;
    if (camera.type == "orthographic") {
      const auto& parallel = camera.orthographic;
      if (!(parallel.xmag != 0 && parallel.ymag != 0)) throw InputError(where_, "a camera sees nothing");
      made.is_orthographic = true;
      made.screen_window = std::array{-std::abs(parallel.xmag), std::abs(parallel.xmag), -std::abs(parallel.ymag),
                                      std::abs(parallel.ymag)};
      aspect = std::abs(parallel.xmag / parallel.ymag);
    } else {
      const auto& perspective = camera.perspective;
      if (perspective.aspectRatio > 0) aspect = perspective.aspectRatio;
      if (!(perspective.yfov > 1e-4 && perspective.yfov < 3.1)) throw InputError(where_, "a camera has no yfov");
      // Across the shorter side.
      const double half = std::tan(perspective.yfov / 2) * std::min(aspect, 1.0);
      made.field_of_view = 2 * std::atan(half) * 180 / std::numbers::pi;
    }
    aspect = std::clamp(aspect, 1e-2, 1e2);
    scene_.film.width = std::max(1, static_cast<int>(std::lround(scene_.film.height * aspect)));
    has_camera_ = true;
  }

  /// Before the whole scene, a little from above.
  void place_camera() {
    Point lower(1e300), upper(-1e300);
    for (const ShapeDescription& shape : scene_.shapes)
      for (const Point& p : std::get<MeshDescription>(shape.geometry).positions)
        lower = glm::min(lower, p), upper = glm::max(upper, p);
    const Point middle = (lower + upper) * 0.5;
    const double radius = std::max(glm::length(upper - lower) / 2, 1e-9);
    scene_.camera.field_of_view = 45;
    const glm::dvec3 from =
        glm::normalize(glm::dvec3(0.5, 0.4, 1)) * (radius / std::sin(22.5 * std::numbers::pi / 180));
    scene_.camera.world_from_camera = glm::inverse(*pbrt::look_at(middle + from, middle, {0, 1, 0}));
    // Seen by a right hand: x to the right.
    scene_.camera.world_from_camera[0] = -scene_.camera.world_from_camera[0];
    scene_.camera.where = where_;
    diagnostics_.note(where_, "the scene has no camera: all of it is seen from before and above");
  }

  void add_light(int number, const glm::dmat4& world_from_node) {
    if (number < 0 || static_cast<std::size_t>(number) >= model_.lights.size())
      throw InputError(where_, "a light is not there");
    const tinygltf::Light& light = model_.lights[static_cast<std::size_t>(number)];
    const Rgb color = light.color.size() == 3 ? Rgb(light.color[0], light.color[1], light.color[2]) : Rgb(1);
    const Rgb power = glm::max(color * light.intensity, Rgb(0));
    if (!(power.x + power.y + power.z > 0)) return;
    const Point position(world_from_node[3]);
    const glm::dvec3 direction = -glm::normalize(glm::dvec3(world_from_node[2]));
    if (light.range > 0) diagnostics_.note(where_, "the range of a light is ignored: it shines as far as it does");
    if (light.type == "directional") {
      scene_.lights.push_back({DistantLightDescription{-direction, power}, where_});
    } else if (light.type == "point") {
      scene_.lights.push_back({PointLightDescription{position, power}, where_});
    } else if (light.type == "spot") {
      SpotLightDescription spot{position, direction, power};
      spot.outer = std::clamp(light.spot.outerConeAngle, 1e-3, std::numbers::pi);
      spot.inner = std::clamp(light.spot.innerConeAngle, 0.0, spot.outer);
      scene_.lights.push_back({spot, where_});
    } else {
      diagnostics_.unsupported(where_, "a light of type " + in_quotes(light.type));
    }
  }

  const tinygltf::Model& model_;
  SourcePosition where_;
  SceneDescription& scene_;
  Diagnostics& diagnostics_;
  Materials materials_;
  bool has_camera_ = false;
};

}  // namespace
}  // namespace gltf

SceneDescription read_gltf_scene(const std::filesystem::path& file, Diagnostics& diagnostics) {
  const SourcePosition where{std::make_shared<const std::string>(file.string()), 1};
  tinygltf::TinyGLTF loader;
  loader.SetImageLoader(gltf::keep_bytes, nullptr);
  tinygltf::Model model;
  std::string error, warning;
  bool is_read = false;
  try {
    is_read = file.extension() == ".glb" ? loader.LoadBinaryFromFile(&model, &error, &warning, file.string())
                                         : loader.LoadASCIIFromFile(&model, &error, &warning, file.string());
  } catch (const std::exception& thrown) {
    error = thrown.what();
  }
  if (!is_read) {
    std::replace(error.begin(), error.end(), '\n', ' ');
    throw InputError(where, "this is no glTF 2.0 file that can be read: " + error);
  }
  SceneDescription scene;
  scene.film.file_name = file.stem().string() + ".exr";
  scene.materials.push_back({DiffuseDescription{}, where, {}});
  add_file(scene, file);
  const auto add_named = [&](const std::string& uri) {
    if (uri.empty() || uri.starts_with("data:")) return;
    std::string name;
    for (std::size_t i = 0; i < uri.size(); ++i) {
      unsigned char code = 0;
      const bool is_escape = uri[i] == '%' && i + 2 < uri.size() &&
                             std::from_chars(&uri[i + 1], &uri[i + 1] + 2, code, 16).ptr == &uri[i + 1] + 2;
      name += is_escape ? static_cast<char>(code) : uri[i];
      if (is_escape) i += 2;
    }
    add_file(scene, file.parent_path() / name);
  };
  for (const tinygltf::Buffer& buffer : model.buffers) add_named(buffer.uri);
  for (const tinygltf::Image& image : model.images) add_named(image.uri);
  gltf::Reader(model, where, scene, diagnostics).read();
  return scene;
}

}  // namespace gmis::tools

#else

namespace gmis::tools {

bool can_read_gltf() {
  return false;
}

SceneDescription read_gltf_scene(const std::filesystem::path& file, Diagnostics&) {
  throw InputError(file.string() +
                   ": this program was built without the library tinygltf, which reads glTF: use a .pbrt file");
}

}  // namespace gmis::tools

#endif
