#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <vector>

#include <glm/glm.hpp>

#include "gmis/scene/scene_builder.hpp"

namespace gmis_test {

/// Adds the parallelogram with this centre and these two half sides. Its front is towards a × b.
template <class T>
void add_quad(gmis::scene::SceneBuilder<T>& builder, std::size_t material, const glm::dvec3& centre,
              const glm::dvec3& a, const glm::dvec3& b, const std::optional<gmis::scene::AreaEmission>& emission = {}) {
  const std::vector<glm::dvec3> corners{centre - a - b, centre + a - b, centre + a + b, centre - a + b};
  const std::vector<std::array<int, 3>> halves{{0, 1, 2}, {0, 2, 3}};
  builder.add_mesh({corners, halves}, material, emission);
}

}  // namespace gmis_test
