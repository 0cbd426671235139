#include "support/scene_description.hpp"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <numbers>

#include "support/load_budget.hpp"

namespace gmis::tools {

void add_file(SceneDescription& scene, const std::filesystem::path& file) {
  std::error_code error;
  if (!std::filesystem::is_regular_file(file, error)) return;
  if (std::find(scene.files.begin(), scene.files.end(), file) == scene.files.end()) scene.files.push_back(file);
}

std::size_t triangle_count(const ShapeDescription& shape) {
  const auto* mesh = std::get_if<MeshDescription>(&shape.geometry);
  return mesh == nullptr ? 1 : mesh->triangles.size();
}

std::uintmax_t bytes_of(const ShapeDescription& shape) {
  const auto* mesh = std::get_if<MeshDescription>(&shape.geometry);
  if (mesh == nullptr) return sizeof shape;
  const auto bytes = [](const auto& list) { return list.size() * sizeof list[0]; };
  return sizeof shape + bytes(mesh->positions) + bytes(mesh->normals) + bytes(mesh->triangles) + bytes(mesh->uv);
}

std::uintmax_t built_bytes_of(const ShapeDescription& shape) {
  return bytes_of(shape) + triangle_count(shape) * bytes_of_triangle;
}

double area_of(const ShapeDescription& shape) {
  if (const auto* sphere = std::get_if<SphereDescription>(&shape.geometry))
    return 4 * std::numbers::pi * sphere->radius * sphere->radius;
  const auto& mesh = std::get<MeshDescription>(shape.geometry);
  double area = 0;
  for (const auto& [a, b, c] : mesh.triangles) {
    const Point& p = mesh.positions[static_cast<std::size_t>(a)];
    area += glm::length(glm::cross(mesh.positions[static_cast<std::size_t>(b)] - p,
                                   mesh.positions[static_cast<std::size_t>(c)] - p)) /
            2;
  }
  return area;
}

std::array<double, 4> picture_window(const CameraDescription& camera, int width, int height) {
  const double angle = camera.vertical_field_of_view.value_or(camera.field_of_view);
  const double half = camera.is_orthographic ? 1 : std::tan(angle * std::numbers::pi / 360);
  std::array<double, 4> window{};
  if (camera.screen_window) {
    window = *camera.screen_window;
  } else {
    const double aspect = camera.frame_aspect_ratio.value_or(static_cast<double>(width) / height);
    const bool is_by_height = aspect > 1 || camera.vertical_field_of_view;
    const double x = is_by_height ? aspect : 1;
    const double y = is_by_height ? 1 : 1 / aspect;
    window = {-x, x, -y, y};
  }
  for (double& side : window) side *= half;
  return window;
}

}  // namespace gmis::tools
