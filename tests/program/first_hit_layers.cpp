#include "support/first_hit_layers.hpp"

#include <cmath>
#include <glm/geometric.hpp>

#include "support/build_scene.hpp"
#include "support/catch.hpp"
#include "support/diagnostics.hpp"
#include "support/pbrt/reader.hpp"

// What a denoiser needs of the layers: albedo linear and from 0 to 1, normals of at most unit
// length in the world on the side of the camera, and 0 where nothing is hit.

using namespace gmis::tools;

TEST_CASE("Layers of first hits are as denoisers take them") {
  // A ball of radius 1, seen from 5 units along +z, before nothing. It is lit, which no layer
  // shows.
  const std::string text = R"(
LookAt 0 0 5  0 0 0  0 1 0
Camera "perspective" "float fov" [40]
Film "rgb" "integer xresolution" [32] "integer yresolution" [32]
WorldBegin
LightSource "distant" "rgb L" [9 9 9] "point3 from" [0 0 1] "point3 to" [0 0 0]
Material "diffuse" "rgb reflectance" [.2 .5 .8]
Shape "sphere" "float radius" [1]
)";
  Diagnostics diagnostics;
  ThreadedExecutor executor(1);
  const auto scene = build_scene(read_pbrt_text(text, "ball", "", diagnostics), diagnostics);
  const auto layers = first_hit_layers(*scene, std::nullopt, executor);
  REQUIRE(layers.size() == 3);
  const Image &albedo = layers[0].image, &normal = layers[1].image, &depth = layers[2].image;
  // Half the angle of view is 20°: what is at (u, v) of the picture, from −1 to 1, lies along
  // (−u, v, −1/tan 20°), since pbrt's axes are left-handed.
  const double focal = 1 / std::tan(20 * 3.14159265358979323846 / 180);
  int within = 0, beside = 0;
  for (int y = 0; y < 32; ++y)
    for (int x = 0; x < 32; ++x) {
      const std::size_t first = albedo.index(x, y);
      for (std::size_t c = 0; c < 3; ++c) {
        CHECK(albedo.rgb[first + c] >= 0);
        CHECK(albedo.rgb[first + c] <= 1);
      }
      const glm::dvec3 n(normal.rgb[first], normal.rgb[first + 1], normal.rgb[first + 2]);
      CHECK(glm::length(n) <= 1 + 1e-6);
      const glm::dvec3 way = glm::normalize(glm::dvec3(1 - (x + .5) / 16, 1 - (y + .5) / 16, -focal));
      const double to_axis = 5 * std::sqrt(1 - way.z * way.z);  // of the pixel's middle from the ball's
      if (to_axis > 1.2) {
        ++beside;
        CHECK(albedo.rgb[first] == 0);
        CHECK(glm::length(n) == 0);
        CHECK(depth.rgb[first] == 0);
      } else if (to_axis < 0.8) {
        ++within;
        CHECK(albedo.rgb[first] == Approx(.2).margin(1e-5));
        CHECK(albedo.rgb[first + 1] == Approx(.5).margin(1e-5));
        CHECK(albedo.rgb[first + 2] == Approx(.8).margin(1e-5));
        const double t = -5 * way.z - std::sqrt(1 - to_axis * to_axis);
        const glm::dvec3 at = glm::dvec3(0, 0, 5) + t * way;
        CHECK(glm::length(n - at) < 0.02);
        CHECK(depth.rgb[first] == Approx(t).margin(0.02));
      }
    }
  CHECK(within > 60);
  CHECK(beside > 300);
}
