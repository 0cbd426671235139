#include "support/pbrt/transform.hpp"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/mat3x3.hpp>
#include <glm/matrix.hpp>
#include <numbers>
#include <utility>

#include "support/pbrt/smooth_shapes.hpp"

namespace gmis::tools::pbrt {

Transform translation(const glm::dvec3& by) {
  Transform m(1);
  m[3] = glm::dvec4(by, 1);
  return m;
}

Transform scaling(const glm::dvec3& by) {
  Transform m(1);
  for (int i = 0; i < 3; ++i) m[i][i] = by[i];
  return m;
}

Transform rotation(double degrees, const glm::dvec3& axis) {
  const glm::dvec3 a = glm::normalize(axis);
  const double angle = degrees * std::numbers::pi / 180;
  const double sine = std::sin(angle), cosine = std::cos(angle);
  Transform m(1);
  for (int column = 0; column < 3; ++column) {
    glm::dvec3 unit(0);
    unit[column] = 1;
    m[column] = glm::dvec4(unit * cosine + glm::cross(a, unit) * sine + a * (a[column] * (1 - cosine)), 0);
  }
  return m;
}

std::optional<Transform> look_at(const Point& eye, const Point& target, const glm::dvec3& up) {
  const glm::dvec3 view = target - eye;
  if (!(glm::length(view) > 0) || !(glm::length(up) > 0)) return {};
  const glm::dvec3 forward = glm::normalize(view);
  const glm::dvec3 right = glm::cross(glm::normalize(up), forward);
  if (glm::length(right) < 1e-9) return {};
  const glm::dvec3 x = glm::normalize(right);
  const glm::dvec3 y = glm::cross(forward, x);
  // The inverse of a rotation is its transpose; written out, so that no rounding reaches the last
  // row.
  Transform camera_from_world = glm::transpose(Transform(glm::dmat3(x, y, forward)));
  camera_from_world[3] = glm::dvec4(-glm::dot(x, eye), -glm::dot(y, eye), -glm::dot(forward, eye), 1);
  return camera_from_world;
}

Point transform_point(const Transform& m, const Point& p) {
  return Point(m * glm::dvec4(p, 1));
}
glm::dvec3 transform_vector(const Transform& m, const glm::dvec3& v) {
  return glm::dvec3(m * glm::dvec4(v, 0));
}

bool is_invertible_affine(const Transform& m) {
  for (int column = 0; column < 4; ++column)
    for (int row = 0; row < 4; ++row)
      if (!std::isfinite(m[column][row])) return false;
  if (m[0][3] != 0 || m[1][3] != 0 || m[2][3] != 0 || m[3][3] != 1) return false;
  const double volume = std::abs(glm::determinant(glm::dmat3(m)));
  const double box = glm::length(glm::dvec3(m[0])) * glm::length(glm::dvec3(m[1])) * glm::length(glm::dvec3(m[2]));
  return volume > 1e-12 * box && std::isfinite(volume);
}

bool swaps_handedness(const Transform& m) {
  return glm::determinant(glm::dmat3(m)) < 0;
}

std::optional<double> similarity_scale(const Transform& m, double tolerance) {
  const glm::dvec3 x(m[0]), y(m[1]), z(m[2]);
  const double scale = std::cbrt(std::abs(glm::determinant(glm::dmat3(m))));
  const double square = scale * scale;
  const auto differs = [&](double dot, double wanted) { return !(std::abs(dot - wanted) <= tolerance * square); };
  if (differs(glm::dot(x, x), square) || differs(glm::dot(y, y), square) || differs(glm::dot(z, z), square)) return {};
  if (differs(glm::dot(x, y), 0) || differs(glm::dot(y, z), 0) || differs(glm::dot(x, z), 0)) return {};
  return scale;
}

std::optional<Transform> made_similarity(const Transform& m) {
  const std::optional<double> scale = similarity_scale(m, 4e-3);  // of squares and products: 1e-3 of the axes
  if (!scale) return {};
  // The polar decomposition by Newton's iteration: R ← (R + R⁻ᵀ)/2 ends at the nearest orthogonal
  // matrix.
  glm::dmat3 axes = glm::dmat3(m) / *scale;
  for (int step = 0; step < 8; ++step) axes = (axes + glm::transpose(glm::inverse(axes))) * 0.5;
  Transform result(axes * *scale);
  result[3] = m[3];
  return result;
}

namespace {

/// Turns every triangle to the side that its vertex normals point to.
void face_forward(MeshDescription& mesh) {
  if (mesh.normals.empty()) return;
  for (auto& [a, b, c] : mesh.triangles) {
    const auto at = [&](int i) { return mesh.positions[static_cast<std::size_t>(i)]; };
    const auto normal = [&](int i) { return mesh.normals[static_cast<std::size_t>(i)]; };
    const glm::dvec3 wound = glm::cross(at(b) - at(a), at(c) - at(a));
    if (glm::dot(wound, normal(a) + normal(b) + normal(c)) < 0) std::swap(b, c);
  }
}

/// The sphere as a mesh, which may become an ellipsoid.
ShapeDescription stretchable(ShapeDescription shape) {
  const SphereDescription sphere = std::get<SphereDescription>(shape.geometry);
  MeshDescription mesh = mesh_of(PartialSphere{sphere.radius, -sphere.radius, sphere.radius, 360});
  for (Point& p : mesh.positions) p = sphere.axes * p + sphere.center;
  for (glm::dvec3& n : mesh.normals) n = sphere.axes * (sphere.normal_points_inward ? -n : n);
  if ((glm::determinant(sphere.axes) < 0) != sphere.normal_points_inward)
    for (auto& triangle : mesh.triangles) std::swap(triangle[1], triangle[2]);
  shape.geometry = std::move(mesh);
  return shape;
}

}  // namespace

std::optional<ShapeDescription> transformed(ShapeDescription shape, const Transform& m) {
  const bool is_flat = !is_invertible_affine(m);
  if (auto* sphere = std::get_if<SphereDescription>(&shape.geometry)) {
    if (is_flat) return {};
    const std::optional<double> scale = similarity_scale(m);
    if (!scale) return transformed(stretchable(shape), m);
    sphere->center = transform_point(m, sphere->center);
    sphere->radius *= *scale;
    sphere->axes = glm::dmat3(m) * sphere->axes / *scale;
    return shape;
  }
  auto& mesh = std::get<MeshDescription>(shape.geometry);
  for (Point& p : mesh.positions) p = transform_point(m, p);
  if (swaps_handedness(m))
    for (auto& triangle : mesh.triangles) std::swap(triangle[1], triangle[2]);
  if (is_flat) mesh.normals.clear();
  if (!mesh.normals.empty()) {
    const glm::dmat3 normal_matrix = glm::transpose(glm::inverse(glm::dmat3(m)));
    for (glm::dvec3& n : mesh.normals) n = glm::normalize(normal_matrix * n);
    face_forward(mesh);
  }
  return shape;
}

}  // namespace gmis::tools::pbrt
