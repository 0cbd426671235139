#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <gmis/scene.hpp>
#include <vector>

/// Scenes under a sky, by which compensated next-event samples are tested and measured.
namespace sky_world {

enum class Sky : std::uint8_t { overcast, sunset, sun };
inline constexpr std::array<Sky, 3> all_skies{Sky::overcast, Sky::sunset, Sky::sun};
inline const char* name_of(Sky sky) {
  return sky == Sky::overcast ? "overcast" : sky == Sky::sunset ? "sunset" : "sun";
}

/// Latitude and longitude, 64 × 32. Overcast: three times brighter above than at the horizon.
/// Sunset: a wide glow on one side. Sun: a disk of 6 degrees that carries half of the light.
inline gmis::scene::EnvironmentImage image_of(Sky sky) {
  gmis::scene::EnvironmentImage image{{64, 32}, {}, gmis::scene::SkyMapping::latitude_longitude};
  for (int y = 0; y < 32; ++y)
    for (int x = 0; x < 64; ++x) {
      const double theta = gmis::pi<double> * (y + 0.5) / 32, phi = 2 * gmis::pi<double> * (x + 0.5) / 64;
      const glm::dvec3 w(std::sin(theta) * std::cos(phi), std::sin(theta) * std::sin(phi), std::cos(theta));
      double level = w.z < 0 ? 0.1 : (1 + 2 * w.z) / 3;
      if (sky == Sky::sunset)
        level = 0.2 + 6 * std::exp(6 * (glm::dot(w, glm::normalize(glm::dvec3(1, 0.3, 0.2))) - 1));
      if (sky == Sky::sun) level = w.z < 0 ? 0.1 : 0.5;
      if (sky == Sky::sun && glm::dot(w, glm::normalize(glm::dvec3(0.6, 0.3, 0.7))) > std::cos(0.11)) level = 60;
      image.radiance.push_back(glm::vec3(glm::dvec3(1, 0.9, 0.8) * level));
    }
  return image;
}

/// A floor, a diffuse, a glossy and a mirror sphere. z is up.
inline gmis::scene::BvhScene<float> make_scene(Sky sky, double next_event_fraction, int width) {
  gmis::scene::SceneBuilder<float> builder;
  const auto floor = builder.add_material(gmis::scene::make_diffuse({0.5, 0.5, 0.5}));
  const auto red = builder.add_material(gmis::scene::make_diffuse({0.7, 0.3, 0.2}));
  const auto glossy = builder.add_material(gmis::scene::make_coated_diffuse({0.1, 0.2, 0.5}, 1.5, 0.15));
  const auto mirror = builder.add_material(gmis::scene::make_mirror({0.9, 0.9, 0.9}));
  const std::array<glm::dvec3, 4> corners{{{-8, -8, -1}, {8, -8, -1}, {8, 8, -1}, {-8, 8, -1}}};
  const std::array<std::array<int, 3>, 2> triangles{{{0, 1, 2}, {0, 2, 3}}};
  builder.add_mesh({corners, triangles}, floor);
  builder.add_sphere({-1.6, 0, 0}, 1, red);
  builder.add_sphere({0.6, 0.2, -0.1}, 0.9, glossy);
  builder.add_sphere({2.1, -0.6, -0.4}, 0.6, mirror);
  builder.add_environment(image_of(sky), glm::dmat3(1), next_event_fraction);
  builder.set_camera(gmis::scene::look_at({0.3, -7, 1.2}, {0.2, 0, -0.2}, {0, 0, 1}, 38, {width, width * 3 / 4}));
  return builder.build();
}

}  // namespace sky_world
