#include <cstdio>
#include <limits>
#include <vector>

#include "gmis/core/statistics.hpp"
#include "hostile/geometry_shapes.hpp"
#include "support/catch.hpp"
#include "support/seed.hpp"

// Lights that are tiny, huge, far, touched, black, or far stronger than the others. What falls on a
// point has a closed form: of a ball π L (r/d)², of a small surface L A cos cos/d², from all around
// π L.

using namespace gmis;
using namespace gmis::scene;
using namespace hostile;
using scene_test::camera_at;
using scene_test::random_direction;
using scene_test::random_square;

namespace {

struct Sum {
  double sum = 0, squares = 0;
  int count = 0, bad = 0;

  /// Adds a sample of the irradiance at `at`; 0 where there is none.
  template <std::floating_point T>
  void add(const scene::Light<T>& light, const SurfacePoint<T>& at, Philox& source) {
    ++count;
    const auto sample = light.sample_next_event(at, random_square<T>(source));
    if (!sample) return;
    const T weight = sample->weight.x;
    if (!(std::isfinite(weight) && weight >= T(0) && std::isfinite(sample->next_event_density) &&
          sample->next_event_density > T(0) && std::abs(glm::length(sample->to_light) - T(1)) < T(1e-5)))
      ++bad;
    const double value =
        static_cast<double>(weight) * std::max(0.0, static_cast<double>(glm::dot(at.shading_normal, sample->to_light)));
    sum += value;
    squares += value * value;
  }
  [[nodiscard]] double mean() const { return sum / count; }
  [[nodiscard]] double standard_error() const {
    return std::sqrt(std::max(0.0, squares / count - mean() * mean()) / count);
  }
};

// Some 70 comparisons at 4.5 standard errors and 1e-4: a false alarm once in 2,000 runs.
void check_mean(const Sum& found, double exact, double rounding) {
  CAPTURE(found.mean(), exact, found.standard_error());
  CHECK(found.bad == 0);
  CHECK(std::abs(found.mean() - exact) < 4.5 * found.standard_error() + rounding * exact);
}

template <std::floating_point T>
SurfacePoint<T> receiver(const glm::dvec3& position, const glm::dvec3& normal) {
  return {Vec3<T>(position), Vec3<T>(normal), Vec3<T>(normal), T(0)};
}

TEMPLATE_TEST_CASE("hostile: a ball that shines, from touching it to a million radii away", "[hostile][lights]", float,
                   double) {
  using T = TestType;
  Philox source(gmis_test::seed(531));
  for (const double radius : {1e-6, 1.0, 1e6})
    for (const double distance : {1 + 1e-4, 1.01, 2.0, 1e3, 1e6}) {
      SceneBuilder<T> builder;
      builder.add_sphere({0, 0, 0}, radius, builder.add_material(make_diffuse<T>({0, 0, 0})), AreaEmission{{2, 2, 2}});
      builder.set_camera(camera_at({0, 0, 0}));
      const auto scene = builder.build();
      const T d = static_cast<T>(distance * radius);
      Sum sum;
      for (int i = 0; i < 20'000; ++i) sum.add(scene.lights()[0], receiver<T>({0, 0, d}, {0, 0, -1}), source);
      CAPTURE(radius, distance);
      const double ratio = static_cast<double>(static_cast<T>(radius)) / static_cast<double>(d);
      // From a ten-thousandth above the surface rounding takes digits of that distance, from a
      // million radii away those of the angle.
      const bool is_extreme = distance < 1.001 || distance > 1e5;
      check_mean(sum, 2 * pi<double> * ratio * ratio, std::same_as<T, double> ? 1e-9 : is_extreme ? 3e-3 : 1e-6);
    }
}

TEMPLATE_TEST_CASE("hostile: within a ball that shines, on its very surface, all around is light", "[hostile][lights]",
                   float, double) {
  using T = TestType;
  Philox source(gmis_test::seed(532));
  for (const double radius : {1e-4, 1.0, 1e6})
    for (const double far : {0.0, 10.0, 1e3}) {
      const glm::dvec3 center = glm::dvec3(0.6, -0.64, 0.48) * far * radius;
      SceneBuilder<T> builder;
      builder.add_sphere(center, radius, builder.add_material(make_diffuse<T>({0, 0, 0})), AreaEmission{{2, 2, 2}},
                         true);
      builder.set_camera(camera_at({0, 0, 0}));
      const auto scene = builder.build();
      Sum sum;
      for (int i = 0; i < 40'000; ++i) {
        const auto hit = scene.intersect({Vec3<T>(center), random_direction<T>(source)});
        REQUIRE(hit);
        sum.add(scene.lights()[0], hit->point, source);
      }
      CAPTURE(radius, far);
      // From 1,000 radii away a float knows the ball to a ten-thousandth of itself.
      check_mean(sum, 2 * pi<double>, std::same_as<T, double> ? 1e-9 : far == 1e3 ? 1e-4 : 1e-6);
    }
}

TEMPLATE_TEST_CASE("hostile: a lamp of area 1e-12, near and far", "[hostile][lights]", float, double) {
  using T = TestType;
  Philox source(gmis_test::seed(533));
  for (const double distance : {1e-3, 1.0, 1e6}) {
    // At the camera itself: coordinates have digits there.
    Mesh mesh;
    mesh.positions = {{0, 0, 0}, {2e-6, 0, 0}, {0, 1e-6, 0}};
    mesh.triangles = {{0, 1, 2}};
    SceneBuilder<T> builder;
    builder.add_mesh(mesh.shape(), builder.add_material(make_diffuse<T>({0, 0, 0})), AreaEmission{{2e12, 2e12, 2e12}});
    builder.set_camera(camera_at({0, 0, 0}));
    const auto scene = builder.build();
    REQUIRE(scene.lights().size() == 1);
    const glm::dvec3 to_receiver = glm::normalize(glm::dvec3(0.3, 0.2, 0.8));
    Sum sum;
    for (int i = 0; i < 5000; ++i) sum.add(scene.lights()[0], receiver<T>(to_receiver * distance, {0, 0, -1}), source);
    CAPTURE(distance);
    // Its middle is 0.7e-6 beside where the receiver is measured from.
    check_mean(sum, 2.0 * to_receiver.z * to_receiver.z / (distance * distance),
               2e-6 / distance + (std::same_as<T, float> ? 1e-6 : 1e-11));
  }
}

TEMPLATE_TEST_CASE("hostile: points of a lamp come from all of it, but keep off the edges of a body",
                   "[hostile][lights]", float, double) {
  using T = TestType;
  constexpr T below_one = T(1) - std::numeric_limits<T>::epsilon() / T(2), ends[] = {T(0), below_one};
  /// The smallest distance of a drawn point from each corner of the light's triangle.
  const auto nearest = [&](const scene::Light<T>& light, const std::array<glm::dvec3, 3>& corners) {
    glm::dvec3 distances(1e9);
    for (const T u : ends)
      for (const T v : ends) {
        const auto sample = light.sample_emission({u, v}, {T(0.3), T(0.6)});
        REQUIRE(sample);
        for (int k = 0; k < 3; ++k)
          distances[k] = std::min(
              distances[k], glm::length(glm::dvec3(sample->origin.position) - corners[static_cast<std::size_t>(k)]));
      }
    return distances;
  };
  const Mesh bodies[] = {
      {{{-1, 2, 1}, {2, -1, 1}, {0.5, 1.5, 1}}, {{0, 1, 2}}},  // open: it ends at its edges
      scene_test::box({-1, -1, -1}, {1, 1, 1}),
  };
  for (const Mesh& mesh : bodies) {
    const bool is_closed = mesh.triangles.size() > 1;
    SceneBuilder<T> builder;
    builder.add_mesh(mesh.shape(), builder.add_material(make_diffuse<T>({0, 0, 0})), AreaEmission{{1, 1, 1}});
    builder.set_camera(camera_at({0, 0, 0}));
    const auto scene = builder.build();
    REQUIRE(scene.lights().size() == mesh.triangles.size());
    for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
      std::array<glm::dvec3, 3> corners;
      for (std::size_t k = 0; k < 3; ++k) corners[k] = mesh.positions[static_cast<std::size_t>(mesh.triangles[i][k])];
      const glm::dvec3 found = nearest(scene.lights()[i], corners);
      const T error = scene.lights()[i].sample_emission({T(0.3), T(0.3)}, {T(0.3), T(0.6)})->origin.position_error;
      // Off an edge by 6 such errors and 8 roundings, off a corner of 45° by 2.6 times as much.
      const double off = 6 * static_cast<double>(error);
      CAPTURE(is_closed, i, found.x, found.y, found.z, error);
      for (int k = 0; k < 3; ++k) {
        CHECK(found[k] < (is_closed ? 2.7 * 3 * off : off));
        if (is_closed) CHECK(found[k] > off);
      }
    }
  }
}

TEMPLATE_TEST_CASE("hostile: on a light, at a light, in a light", "[hostile][lights]", float, double) {
  using T = TestType;
  Philox source(gmis_test::seed(534));
  SceneBuilder<T> builder;
  const auto black = builder.add_material(make_diffuse<T>({0, 0, 0}));
  Mesh mesh;
  mesh.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  mesh.triangles = {{0, 1, 2}};
  builder.add_mesh(mesh.shape(), black, AreaEmission{{1, 1, 1}, true});
  builder.add_sphere({3, 0, 0}, 1, black, AreaEmission{{1, 1, 1}, true});
  builder.add_point_light({0, 0, 5}, {1, 1, 1});
  builder.add_spot_light({0, 0, 7}, {0, 0, 1}, {1, 1, 1}, 0.1, 0.2);
  builder.set_camera(camera_at({0, 0, 0}));
  const auto scene = builder.build();
  Sum sum;
  for (const auto& light : scene.lights())
    for (const glm::dvec3 place : {glm::dvec3(0.2, 0.3, 0), {0, 0, 0}, {4, 0, 0}, {3, 0, 0}, {0, 0, 5}, {0, 0, 7}})
      for (int i = 0; i < 3000; ++i) {
        sum.add(light, receiver<T>(place, random_direction<double>(source)), source);
        const auto emission = light.sample_emission(random_square<T>(source), random_square<T>(source));
        if (emission && !(std::isfinite(emission->weight.x) && emission->density.first > T(0))) ++sum.bad;
      }
  CHECK(sum.bad == 0);
}

TEST_CASE("hostile: one pixel of the sky is 1e8 times the others", "[hostile][lights]") {
  // Its share of the light is known, and so is that of the samples.
  constexpr int side = 64;
  constexpr std::size_t bright = 64 * 30 + 20;
  std::vector<glm::vec3> pixels(side * side, glm::vec3(1));
  pixels[bright] = glm::vec3(1e8F);
  SceneBuilder<float> builder;
  builder.add_environment(EnvironmentImage{{side, side}, pixels});
  builder.set_camera(camera_at({0, 0, 0}));
  const auto scene = builder.build();
  const auto& sky = scene.lights()[0];
  Philox source(gmis_test::seed(535));
  double sum = 0;
  int in_bright = 0;
  constexpr int count = 100'000;
  for (int i = 0; i < count; ++i) {
    const auto sample = sky.sample_next_event(receiver<float>({0, 0, 0}, {0, 0, 1}), random_square<float>(source));
    REQUIRE(sample);
    REQUIRE(std::isfinite(sample->weight.x));
    REQUIRE(sample->next_event_density > 0);
    sum += static_cast<double>(sample->weight.x);
    in_bright += static_cast<double>(sample->weight.x * sample->next_event_density) > 10 ? 1 : 0;
    // What a ray that goes there would find.
    const auto seen = sky.emitted({}, -sample->to_light);
    REQUIRE(std::abs(seen.radiance.x / (sample->weight.x * sample->next_event_density) - 1) < 1e-5F);
  }
  constexpr double pixel = 4 * pi<double> / (side * side), rest = side * side - 1;
  CHECK(std::abs(sum / count / (pixel * (1e8 + rest)) - 1) < 1e-4);
  CHECK(in_bright >= count - 40);  // 4 are expected to go elsewhere
}

TEMPLATE_TEST_CASE("hostile: lights from 1e-12 to 1e12 and black ones are chosen by what they give",
                   "[hostile][lights]", float, double) {
  using T = TestType;
  SceneBuilder<T> builder;
  double total = 0;
  std::vector<double> strengths;
  for (int e = -12; e <= 12; ++e) {
    strengths.push_back(std::pow(10.0, e));
    strengths.push_back(0);
  }
  for (const double strength : strengths) {
    builder.add_point_light({0, 0, 1}, glm::dvec3(strength));
    total += strength;
  }
  builder.set_camera(camera_at({0, 0, 0}));
  const auto scene = builder.build();
  REQUIRE(scene.lights().size() == strengths.size());
  double sum = 0;
  for (std::size_t i = 0; i < strengths.size(); ++i) {
    const auto chance = static_cast<double>(scene.selection_probability(scene.lights()[i]));
    sum += chance;
    if (strengths[i] == 0) CHECK(chance == 0);
    // As near as multiples of the last place of 1 can be, of which each cell of the table rounds
    // one.
    CHECK(std::abs(chance - strengths[i] / total) <
          static_cast<double>(strengths.size()) * static_cast<double>(std::numeric_limits<T>::epsilon()));
  }
  CHECK(std::abs(sum - 1) < 1e-6);
  Philox source(gmis_test::seed(536));
  constexpr int count = 100'000;
  std::vector<int> chosen(strengths.size(), 0);
  for (int i = 0; i < count; ++i) {
    const auto choice = scene.sample_light(uniform<T>(source));
    REQUIRE(choice.light != nullptr);
    REQUIRE(choice.selection_probability > T(0));
    REQUIRE(choice.selection_probability == scene.selection_probability(*choice.light));
    ++chosen[static_cast<std::size_t>(choice.light - scene.lights().data())];
  }
  // Counts by their normal approximation; for a light that is hardly ever chosen, with the variance
  // of 10 expected choices.
  for (std::size_t i = 0; i < strengths.size(); ++i) {
    const double expected = count * strengths[i] / total;
    CAPTURE(strengths[i], chosen[i], expected);
    CHECK(std::abs(chosen[i] - expected) < 5 * std::sqrt(std::max(expected, 10.0)));
    if (strengths[i] == 0) CHECK(chosen[i] == 0);
  }
}

}  // namespace
