#pragma once

#include <glm/mat4x4.hpp>
#include <glm/vec3.hpp>
#include <optional>

#include "support/scene_description.hpp"

namespace gmis::tools::pbrt {

using Transform = glm::dmat4;

[[nodiscard]] Transform translation(const glm::dvec3& by);
[[nodiscard]] Transform scaling(const glm::dvec3& by);
/// About an axis of any length but zero, by `degrees`, counter-clockwise seen from its tip.
[[nodiscard]] Transform rotation(double degrees, const glm::dvec3& axis);
/// World to camera, camera space left-handed. Nothing when the eye is the target or `up` is
/// parallel to the view.
[[nodiscard]] std::optional<Transform> look_at(const Point& eye, const Point& target, const glm::dvec3& up);

[[nodiscard]] Point transform_point(const Transform& m, const Point& p);
[[nodiscard]] glm::dvec3 transform_vector(const Transform& m, const glm::dvec3& v);

/// Affine, finite, and not squashed to a plane.
[[nodiscard]] bool is_invertible_affine(const Transform& m);
[[nodiscard]] bool swaps_handedness(const Transform& m);
/// The factor by which a similarity (rotation, reflection, uniform scale, translation) scales
/// lengths; nothing when a product of two axes, over its square, is off by more than `tolerance`.
[[nodiscard]] std::optional<double> similarity_scale(const Transform& m, double tolerance = 1e-5);

/// The similarity nearest to `m`, which is one to 1e-3; nothing when `m` is farther from any.
[[nodiscard]] std::optional<Transform> made_similarity(const Transform& m);

/// Moves a shape from the space it is described in by `m`; the surface keeps the side its normals
/// point to. A sphere that `m` makes an ellipsoid becomes a mesh. Nothing when `m` flattens a
/// sphere.
[[nodiscard]] std::optional<ShapeDescription> transformed(ShapeDescription shape, const Transform& m);

}  // namespace gmis::tools::pbrt
