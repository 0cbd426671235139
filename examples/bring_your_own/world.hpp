#pragma once

#include "their_renderer.hpp"

namespace theirs {

/// A room without a front: walls, a glass ball, two lamps of unlike power.
inline World make_world(int columns, int rows) {
  World world;
  const auto white = std::make_shared<Matt>(Vector{0.75, 0.7, 0.65});
  const auto red = std::make_shared<Matt>(Vector{0.6, 0.15, 0.1});
  const auto glass = std::make_shared<Glass>(1.5);
  const auto add = [&](const auto& material, const Vector& corner, const Vector& a, const Vector& b) {
    world.shapes.push_back({material, nullptr, false, corner, a, b});
  };
  add(white, {-2, 0, -2}, {0, 0, 4}, {4, 0, 0});  // floor
  add(white, {-2, 0, 2}, {0, 4, 0}, {4, 0, 0});   // back
  add(red, {-2, 0, -2}, {0, 4, 0}, {0, 0, 4});    // right
  world.shapes.push_back({glass, nullptr, true, {0.3, 0.8, 0}, {}, {}, 0.8});
  world.shapes.push_back({red, nullptr, true, {-1.1, 0.5, 0.6}, {}, {}, 0.5});
  world.add_lamp({-0.5, 3.9, -0.5}, {1, 0, 0}, {0, 0, 1}, {9, 9, 8});
  world.add_lamp({1.9, 1.5, 0}, {0, 0, 0.5}, {0, 0.5, 0}, {4, 6, 8});
  world.eye = {{0, 1.8, -6}, {-1, 0, 0}, {0, 1, 0}, {0, 0, 1}, 0.45, 0.45 * rows / columns, columns, rows};
  return world;
}

}  // namespace theirs
