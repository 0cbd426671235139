#include "guided_directions/learn_directions.hpp"

#include <array>
#include <cmath>
#include <cstring>
#include <vector>

#include "gmis/core/random.hpp"
#include "gmis/core/statistics.hpp"
#include "gmis/scene.hpp"
#include "gmis/transport/engine/engine.hpp"
#include "gmis/transport/state/integrators.hpp"
#include "support/backward_executor.hpp"
#include "support/catch.hpp"
#include "support/seed.hpp"
#include "transport/built_in_engines.hpp"
#include "transport/furnace_scene.hpp"
#include "transport/mean_of_iterations.hpp"
#include "transport/quads.hpp"

// Guided directions in built-in scenes: pictures keep their energy, and lobes point to where light
// and importance come from.

namespace {

using Scene = gmis::scene::BvhScene<float>;
using Builder = gmis::scene::SceneBuilder<float>;
using Guide = gmis::DirectionGuide<float>;
using Guided = gmis::GuidedScene<Scene>;
using gmis::TransportMode;
using gmis_test::add_quad;
using V = gmis::Vec3<double>;

/// A closed room with a lamp, balls of several materials, a mirror, a curtain that lets light
/// through, and a point light.
Scene make_room() {
  Builder builder;
  const auto white = builder.add_material(gmis::scene::make_diffuse({0.7, 0.7, 0.7}));
  const auto red = builder.add_material(gmis::scene::make_diffuse({0.7, 0.2, 0.1}));
  const auto black = builder.add_material(gmis::scene::make_diffuse({0, 0, 0}));
  const auto mirror = builder.add_material(gmis::scene::make_mirror({0.8, 0.8, 0.8}));
  const auto glossy = builder.add_material(gmis::scene::make_phong({0.3, 0.3, 0.3}, {0.4, 0.4, 0.4}, 12));
  const auto coated = builder.add_material(gmis::scene::make_coated_diffuse({0.5, 0.5, 0.5}, 1.5, 0));
  const auto curtain = builder.add_material(gmis::scene::make_diffuse_transmission({0.3, 0.3, 0.3}, {0.4, 0.4, 0.4}));
  for (const double side : {-1.0, 1.0}) {
    add_quad(builder, red, {side, 0, 0}, {0, 1, 0}, {0, 0, 1});
    add_quad(builder, white, {0, side, 0}, {1, 0, 0}, {0, 0, 1});
    add_quad(builder, white, {0, 0, side}, {1, 0, 0}, {0, 1, 0});
  }
  builder.add_sphere({-0.5, -0.6, 0.4}, 0.35, glossy);
  builder.add_sphere({0.5, -0.7, 0.2}, 0.3, coated);
  add_quad(builder, mirror, {0.6, 0, 0.8}, {0.2, 0, -0.1}, {0, 0.3, 0});
  add_quad(builder, curtain, {-0.1, 0.3, 0}, {0.4, 0, 0}, {0, 0.05, 0.5});
  add_quad(builder, black, {0, 0.98, 0.1}, {0.3, 0, 0}, {0, 0, 0.3}, gmis::scene::AreaEmission{{9, 9, 9}, true});
  builder.add_point_light({0.7, -0.4, -0.7}, {0.3, 0.3, 0.3});
  builder.set_camera(gmis::scene::look_at({0, 0, -0.95}, {0, -0.1, 0}, {0, 1, 0}, 80, {24, 24}));
  return builder.build();
}

template <class Executor = gmis::SerialExecutor>
Guide learn(const Scene& scene, std::uint64_t seed, Executor executor = {}) {
  return gmis::learn_directions(scene, {seed, 6, 2, 4096}, executor);
}

using gmis_test::Mean;

template <class Method, class Scene_>
Mean mean_of(const Scene_& scene, const gmis::SampleCounts& counts, std::uint64_t seed, int iterations) {
  gmis::RenderSettings settings;
  settings.counts = counts;
  settings.max_depth = 6;
  settings.seed = seed;
  gmis::Engine<Scene_, Method> engine(scene, settings);
  const Mean mean = gmis_test::mean_of_iterations(engine, iterations);
  CHECK(engine.counters().rejected() == 0);
  return mean;
}

template <class Method>
void check_energy(const char* name, const Scene& scene, const Guide& guide, const gmis::SampleCounts& counts,
                  double level) {
  const Guided guided(scene, guide);
  const Mean truth = mean_of<Method>(scene, counts, gmis_test::seed(51), 500);
  const Mean with_guide = mean_of<Method>(guided, counts, gmis_test::seed(52), 500);
  const double error = std::hypot(truth.standard_error, with_guide.standard_error);
  // Merging is biased a little, in its own way with each set of weights.
  const double bias = counts.merges ? 0.003 : 0.0;
  const double quantile = gmis::normal_quantile(1 - level / 2);
  CAPTURE(name, with_guide.value / truth.value, error / truth.value);
  CHECK(std::abs(with_guide.value - truth.value) < quantile * error + bias * truth.value);
  CHECK(quantile * error < 0.03 * truth.value);  // so that 3 % shows
}

}  // namespace

TEST_CASE("Guided directions keep the energy, with every technique") {
  const Scene scene = make_room();
  const Guide guide = learn(scene, gmis_test::seed(50));
  REQUIRE(guide.cells().size() > 20);
  const double level = gmis::sidak_level(1e-3, 3);
  check_energy<gmis::CameraSide>("pt", scene, guide, gmis::integrators::pt, level);
  check_energy<gmis::BothSides>("bpt", scene, guide, gmis::integrators::bpt, level);
  check_energy<gmis::BothSides>("vcm", scene, guide, gmis::integrators::vcm, level);
}

TEST_CASE("A furnace with a guide that points anywhere: the closed form") {
  // L (1 − a^D)/(1 − a), whatever the guide. It is made of incidences that no light brought: at
  // each of a few places mostly from one direction.
  using Furnace = gmis_test::FurnaceScene<double>;
  constexpr double albedo = 0.7, radiance = 2;
  constexpr int depth = 6;
  const Furnace furnace(albedo, radiance, 16, 2);
  gmis::Philox source(gmis_test::seed(57));
  std::vector<gmis::Incidence<double>> incidences;
  for (int place = 0; place < 200; ++place) {
    const auto [u, v, x, y] = gmis::uniforms<double, 4>(source);
    const V position = gmis::square_to_sphere(gmis::Vec2<double>(u, v));
    const V to = gmis::square_to_cosine_hemisphere(gmis::Vec2<double>(x, y));
    for (int i = 0; i < 200; ++i) {
      const auto [p, q] = gmis::uniforms<double, 2>(source);
      const V near = to + 0.3 * gmis::square_to_sphere(gmis::Vec2<double>(p, q));
      incidences.push_back({position, -position, glm::normalize(gmis::Frame<double>::around(-position).to_world(near)),
                            1.0, i % 2 == 0 ? TransportMode::radiance : TransportMode::importance});
    }
  }
  const gmis::DirectionGuide<double> guide(incidences);
  REQUIRE(guide.cells().size() > 30);
  const gmis::GuidedScene<Furnace> guided(furnace, guide);
  const double expected = radiance * (1 - std::pow(albedo, depth)) / (1 - albedo);
  const double quantile = gmis::normal_quantile(1 - gmis::sidak_level(1e-3, 2) / 2);
  for (const bool is_two_sided : {false, true}) {
    const Mean mean = is_two_sided ? mean_of<gmis::BothSides>(guided, gmis::integrators::bpt, gmis_test::seed(58), 400)
                                   : mean_of<gmis::CameraSide>(guided, gmis::integrators::pt, gmis_test::seed(59), 400);
    CAPTURE(is_two_sided, mean.value / expected, mean.standard_error / expected);
    CHECK(std::abs(mean.value - expected) < quantile * mean.standard_error);
    CHECK(quantile * mean.standard_error < 0.02 * expected);  // so that 2 % shows
  }
}

TEST_CASE("What is learned of directions depends on the seed alone, not on who does which part of the work when") {
  const Scene scene = make_room();
  const Guide forwards = learn(scene, 3), backwards = learn(scene, 3, gmis_test::BackwardExecutor()),
              others = learn(scene, 4);
  REQUIRE(forwards.cells().size() == backwards.cells().size());
  REQUIRE(forwards.cells().size() > 20);
  bool differs = forwards.cells().size() != others.cells().size();
  for (std::size_t i = 0; i < forwards.cells().size(); ++i)
    for (std::size_t place = 0; place < 4; ++place) {
      const auto *a = forwards.cells()[i].tables[place], *b = backwards.cells()[i].tables[place];
      REQUIRE((a == nullptr) == (b == nullptr));
      if (a != nullptr) CHECK(a->bins() == b->bins());
      if (a != nullptr && !differs)
        differs = others.cells()[i].tables[place] == nullptr || a->bins() != others.cells()[i].tables[place]->bins();
    }
  CHECK(differs);
}

TEST_CASE("With an empty guide, and where it has no lobe, pictures have the same bits") {
  const Scene scene = make_room();
  const Guide empty;
  const Guided guided(scene, empty);
  gmis::RenderSettings settings;
  settings.max_depth = 5;
  gmis::SerialExecutor executor;
  gmis::Engine<Scene> plain(scene, settings);
  gmis::Engine<Guided> other(guided, settings);
  for (int i = 0; i < 2; ++i) plain.iterate(executor), other.iterate(executor);
  CHECK(std::memcmp(plain.frame().data(), other.frame().data(), plain.frame().size_bytes()) == 0);
}

TEST_CASE("What has a narrow lobe is not guided, nor what is purely delta") {
  const Scene scene = make_room();
  const Guide guide = learn(scene, gmis_test::seed(53));
  const Guided guided(scene, guide);
  gmis::Philox source(gmis_test::seed(54));
  std::array<int, 2> narrow{}, wide{};
  for (int i = 0; i < 4000; ++i) {
    const auto [u, v] = gmis::uniforms<float, 2>(source);
    const auto hit = guided.intersect(
        {-gmis::Vec3<float>(scene.statistics().world_origin), gmis::square_to_sphere(gmis::Vec2<float>(u, v))});
    if (!hit) continue;
    ++(hit->bsdf.has_narrow_lobe() ? narrow : wide)[hit->bsdf.lobe().is_empty() ? 0 : 1];
  }
  CHECK(narrow[0] > 100);
  CHECK(narrow[1] == 0);
  CHECK(wide[1] > 3000);
}

TEST_CASE("Light and importance through a slit: lobes point through it") {
  // Above a black wall with a slit a spot light shines up at a white patch, and at nothing else;
  // below the wall a camera sees the floor alone. Light comes to the floor from the patch through
  // the slit, and importance to the patch from the floor through the slit: the geometry gives the
  // directions of both. The slit is a fifth of a unit wide and 2 units off: a cosine lobe seldom
  // passes it.
  Builder builder;
  const auto white = builder.add_material(gmis::scene::make_diffuse({0.8, 0.8, 0.8}));
  const auto black = builder.add_material(gmis::scene::make_diffuse({0, 0, 0}));
  constexpr double wall = 2, top = 4, half_width = 0.1;
  add_quad(builder, white, {0, 0, 0}, {0, 0, 1}, {1, 0, 0});                   // the floor
  add_quad(builder, white, {0, top, 0}, {0, 0, 1}, {1, 0, 0});                 // the patch
  add_quad(builder, black, {-2 - half_width, wall, 0}, {0, 0, 4}, {2, 0, 0});  // the wall, left and right of the slit
  add_quad(builder, black, {2 + half_width, wall, 0}, {0, 0, 4}, {2, 0, 0});
  builder.add_spot_light({1.5, wall + 0.2, 0}, {-1.5, top - wall - 0.2, 0}, {9, 9, 9}, 0.1, 0.3);
  builder.set_camera(gmis::scene::look_at({0, 1.5, -3}, {0, 0, 0}, {0, 1, 0}, 35, {32, 32}));
  const Scene scene = builder.build();
  gmis::SerialExecutor executor;
  const Guide guide = gmis::learn_directions(scene, {gmis_test::seed(55), 5, 3, 16384}, executor);
  const Guided guided(scene, guide);

  gmis::Philox source(gmis_test::seed(56));
  struct End {
    double from, to;  ///< heights of the surface with the lobe and of the surface that it points to
    TransportMode mode;
  };
  for (const End& end : {End{0, top, TransportMode::radiance}, End{top, 0, TransportMode::importance}}) {
    int points = 0, through = 0, near = 0, through_cosine = 0, drawn = 0, to_light = 0, elsewhere = 0;
    bool has_density = true;
    const double up = end.to > end.from ? 1 : -1;
    for (int i = 0; i < 400; ++i) {
      const auto [u, v] = gmis::uniforms<float, 2>(source);
      const V at(0.3 * (2 * static_cast<double>(u) - 1), end.from + up * 0.5, 0.8 * (2 * static_cast<double>(v) - 1));
      const auto hit = guided.intersect(
          {gmis::Vec3<float>(at - V(scene.statistics().world_origin)), {0.0F, static_cast<float>(-up), 0.0F}});
      REQUIRE(hit);
      const auto& lobe = hit->bsdf.lobe();
      const bool is_front = hit->point.shading_normal.y * up > 0;
      // What comes straight from the spot light is left out: no lobe of the patch points there.
      if (end.mode == TransportMode::importance && !lobe.is_empty() &&
          lobe.share(is_front, TransportMode::radiance) > 0) {
        const V w(lobe.sample(is_front, {u, v}, TransportMode::radiance));
        ++(glm::dot(w, glm::normalize(V(1.5, wall + 0.2, 0) - at)) > 0.8 ? to_light : elsewhere);
      }
      if (lobe.is_empty() || lobe.share(is_front, end.mode) == 0) continue;
      ++points;
      // `beside`: off the edges by up to two bins, by which tables are smoothed: 1 unit, seen
      // from 2.
      const auto passes = [&](const V& w, double beside) {
        if (w.y * up <= 0) return false;
        const double along = (wall - end.from) / w.y, whole = (end.to - end.from) / w.y;
        return std::abs(at.x + w.x * along) < half_width + beside && std::abs(at.x + w.x * whole) < 1 + 2 * beside &&
               std::abs(at.z + w.z * whole) < 1 + 2 * beside;
      };
      for (int j = 0; j < 100; ++j) {
        const auto [x, y] = gmis::uniforms<float, 2>(source);
        const gmis::Vec3<float> w = lobe.sample(is_front, {x, y}, end.mode);
        has_density = has_density && lobe.pdf(is_front, w, end.mode) > 0;
        ++drawn;
        through += passes(V(w), 0);
        near += passes(V(w), 1);
        const V cosine = gmis::square_to_cosine_hemisphere(gmis::Vec2<double>(x, y));
        through_cosine += passes(V(cosine.x, up * cosine.z, cosine.y), 0);
      }
    }
    CAPTURE(end.from, points, drawn, through, near, through_cosine);
    CHECK(has_density);
    CHECK(points > 300);
    CHECK(through > 6 * through_cosine);
    CHECK(near > 0.85 * drawn);
    CHECK(to_light <= elsewhere);
  }
}
