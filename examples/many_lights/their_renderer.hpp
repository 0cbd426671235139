#pragma once

#include <algorithm>
#include <cmath>
#include <glm/glm.hpp>
#include <limits>
#include <optional>
#include <vector>

/// \file
/// An existing renderer, which knows nothing of gmis. It renders towns at night: patches that are
/// diffuse on both sides, and many lamps. Single precision, z up. A grid over the town knows which
/// lamps matter in each of its cells.

namespace town {

using glm::vec3;

/// A parallelogram: a corner, two sides, and the colour of both faces.
struct Patch {
  vec3 corner, side_a, side_b, colour;
  [[nodiscard]] vec3 normal() const { return glm::normalize(glm::cross(side_a, side_b)); }
};

/// A ball that shines.
struct Lamp {
  vec3 center;
  float radius;
  vec3 radiance;
  [[nodiscard]] float power() const { return radius * radius * (radiance.x + radiance.y + radiance.z); }
};

/// For every cell of a grid over the ground: the lamps in the order of their numbers, with
/// cumulative probabilities. The probabilities follow the light that reaches the middle of the
/// cell; a tenth is by power alone, so that no lamp has the probability 0.
class LampGrid {
 public:
  LampGrid() = default;
  LampGrid(const std::vector<Lamp>& lamps, glm::vec2 low, glm::vec2 high, int cells)
      : low_(low), size_((high - low) / static_cast<float>(cells)), cells_(cells), lamps_(lamps.size()) {
    for (int i = 0; i < cells * cells; ++i) {
      const glm::vec2 middle =
          low + size_ * glm::vec2(static_cast<float>(i % cells) + 0.5F, static_cast<float>(i / cells) + 0.5F);
      const auto light_at_middle = [&](const Lamp& lamp) {
        const vec3 offset = lamp.center - vec3(middle, 0.0F);
        return lamp.power() / (glm::dot(offset, offset) + 0.3F * glm::dot(size_, size_));
      };
      float power = 0, light = 0, below = 0;
      for (const Lamp& lamp : lamps) power += lamp.power(), light += light_at_middle(lamp);
      for (const Lamp& lamp : lamps)
        sums_.push_back(below += 0.1F * lamp.power() / power + 0.9F * light_at_middle(lamp) / light);
      sums_.back() = 1.0F;
    }
  }
  /// The lamp that the number `u` in [0, 1) stands for, at a place.
  [[nodiscard]] std::size_t pick(const vec3& place, float u) const {
    const auto* const first = cell_at(place);
    return std::min(static_cast<std::size_t>(std::upper_bound(first, first + lamps_, u) - first), lamps_ - 1);
  }
  [[nodiscard]] float probability(std::size_t lamp, const vec3& place) const {
    const auto* const first = cell_at(place);
    return first[lamp] - (lamp > 0 ? first[lamp - 1] : 0.0F);
  }

 private:
  [[nodiscard]] const float* cell_at(const vec3& place) const {
    const glm::ivec2 cell = glm::clamp(glm::ivec2((glm::vec2(place) - low_) / size_), 0, cells_ - 1);
    return &sums_[static_cast<std::size_t>(cell.y * cells_ + cell.x) * lamps_];
  }
  glm::vec2 low_{}, size_{};
  int cells_ = 0;
  std::size_t lamps_ = 0;
  std::vector<float> sums_;
};

struct Eye {
  vec3 position, right, up, forward;  ///< unit
  float half_width, half_height;      ///< of the picture at distance 1
  int columns, rows;                  ///< rows from above
};

struct Town {
  std::vector<Patch> patches;
  std::vector<Lamp> lamps;
  LampGrid grid;
  Eye eye;

  struct Meeting {
    float distance;
    vec3 normal, colour;
    const Lamp* lamp;
  };
  [[nodiscard]] std::optional<Meeting> first(const vec3& origin, const vec3& way, float farthest) const {
    std::optional<Meeting> nearest;
    const auto meet = [&](float t, const auto& make) {
      if (!(t > 1e-4F && t < farthest)) return;
      farthest = t;
      nearest = make();
    };
    for (const Patch& patch : patches) {
      const vec3 n = glm::cross(patch.side_a, patch.side_b);
      const float towards = glm::dot(way, n);
      if (towards == 0) continue;  // along the patch
      const float t = glm::dot(patch.corner - origin, n) / towards;
      const vec3 at = origin + t * way - patch.corner;
      const float u = glm::dot(glm::cross(at, patch.side_b), n), v = glm::dot(glm::cross(patch.side_a, at), n);
      if (u >= 0 && v >= 0 && u <= glm::dot(n, n) && v <= glm::dot(n, n))
        meet(t, [&] { return Meeting{t, glm::normalize(n), patch.colour, nullptr}; });
    }
    for (const Lamp& lamp : lamps) {
      const vec3 out = origin - lamp.center;
      const float b = glm::dot(out, way), d = lamp.radius * lamp.radius - glm::dot(out - b * way, out - b * way);
      if (d < 0) continue;
      for (const float t : {-b + std::sqrt(d), -b - std::sqrt(d)})
        meet(t, [&] { return Meeting{t, (out + t * way) / lamp.radius, vec3(0), &lamp}; });
    }
    return nearest;
  }
};

/// A street between two walls, with `count` lamps along it: every seventh one is bright.
inline Town make_town(int count, int columns, int rows) {
  Town town;
  const vec3 stone(0.6F, 0.55F, 0.5F), brick(0.6F, 0.3F, 0.2F);
  const float length = 2.0F * static_cast<float>(count);
  town.patches = {{{-4, 0, 0}, {8, 0, 0}, {0, length, 0}, stone},
                  {{-4, 0, 0}, {0, length, 0}, {0, 0, 3}, brick},
                  {{4, 0, 0}, {0, 0, 3}, {0, length, 0}, brick}};
  for (int i = 0; i < count; ++i)
    town.lamps.push_back(
        {{i % 2 == 0 ? -2.5F : 2.5F, 2.0F * static_cast<float>(i) + 1.0F, 1.0F + 0.1F * static_cast<float>(i % 5)},
         0.2F,
         (i % 7 == 3 ? 20.0F : 4.0F) * vec3(1.0F, 0.8F, 0.4F + 0.1F * static_cast<float>(i % 3))});
  town.grid = LampGrid(town.lamps, {-4, 0}, {4, length}, 2 * count);
  const vec3 forward = glm::normalize(vec3(0, 1, -0.25F));
  town.eye = {{0, -2, 3}, {1, 0, 0}, glm::cross(vec3(1, 0, 0), forward),
              forward,    0.6F,      0.6F * static_cast<float>(rows) / static_cast<float>(columns),
              columns,    rows};
  return town;
}

}  // namespace town
