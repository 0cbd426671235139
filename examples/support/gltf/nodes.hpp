#pragma once

#include <glm/gtc/quaternion.hpp>
#include <glm/mat4x4.hpp>
#include <optional>
#include <vector>

#include "support/gltf/document.hpp"

namespace gmis::tools::gltf {

/// The nodes of a file, as they stand or as the first animation has them at a time.
class Nodes {
 public:
  /// Throws for a node that has two parents or is its own ancestor.
  Nodes(const Document& document, std::optional<double> seconds);

  [[nodiscard]] const glm::dmat4& world_from(std::size_t node) const { return world_.at(node); }
  /// The node or one above it is not visible, by KHR_node_visibility.
  [[nodiscard]] bool is_hidden(std::size_t node) const { return is_hidden_.at(node); }
  /// The weights of morph targets, where the animation moves them; else empty.
  [[nodiscard]] const std::vector<double>& weights_of(std::size_t node) const { return weights_.at(node); }
  /// The nodes of the scene that is shown, parents first.
  [[nodiscard]] const std::vector<std::size_t>& shown() const { return shown_; }

 private:
  struct Local {
    glm::dvec3 translation{0}, scale{1};
    glm::dquat rotation{1, 0, 0, 0};
    std::optional<glm::dmat4> matrix;
  };
  void animate(const Json& animation, double seconds);
  void place_all();
  void show_scene();

  const Document& document_;
  std::vector<Local> locals_;
  std::vector<std::optional<std::size_t>> parents_;
  std::vector<std::vector<std::size_t>> children_;
  std::vector<std::vector<double>> weights_;
  std::vector<glm::dmat4> world_;
  std::vector<bool> is_hidden_;
  std::vector<std::size_t> shown_;
};

/// The value of an animation's sampler at a time, from `values` with the same number of numbers for
/// each key; before the first and after the last key the value there. `is_rotation` interpolates
/// along the sphere.
[[nodiscard]] std::vector<double> sampled(const std::vector<double>& times, const std::vector<double>& values,
                                          const std::string& interpolation, double seconds, bool is_rotation);

}  // namespace gmis::tools::gltf
