// What docs/your-renderer.md shows beside the examples.
#include <array>
#include <cmath>
#include <span>

#include "adapters/agreement.hpp"
#include "bring_your_own/adapter.hpp"
#include "bring_your_own/outdoors.hpp"
#include "bring_your_own/world.hpp"
#include "gmis/check/check_scene.hpp"
#include "gmis/core/density_tests.hpp"
#include "gmis/core/warp.hpp"
#include "support/catch.hpp"
#include "support/seed.hpp"

namespace {

/// A meadow: the ground, a ball, a leaf above them with holes in it.
theirs::World meadow(int columns, int rows, double leaf_alpha, adapter::Leaf& leaf) {
  theirs::World world;
  const auto ground = std::make_shared<theirs::Matt>(theirs::Vector{0.6, 0.6, 0.5});
  const auto green = std::make_shared<theirs::Matt>(theirs::Vector{0.2, 0.6, 0.2});
  world.shapes.push_back({ground, nullptr, false, {-3, 0, -3}, {0, 0, 6}, {6, 0, 0}});
  world.shapes.push_back({ground, nullptr, true, {0.8, 0.5, 0.3}, {}, {}, 0.5});
  world.shapes.push_back({green, nullptr, false, {-1.5, 1, -1}, {0, 0, 2}, {2, 0, 0}});
  world.add_lamp({-2, 0.5, 1}, {0.5, 0, 0}, {0, 0.5, 0}, {6, 5, 4});
  world.eye = {{0, 1.8, -6}, {-1, 0, 0}, {0, 1, 0}, {0, 0, 1}, 0.45, 0.45 * rows / columns, columns, rows};
  leaf = {green.get(), leaf_alpha};
  return world;
}

/// Velvet that is brighter seen along the surface than lit along it: not reciprocal. g(arriving,
/// leaving) is the share of light from `arriving` that leaves along `leaving`, per steradian,
/// without the cosine.
class OneWayVelvet {
 public:
  using Spectrum = glm::dvec3;
  explicit OneWayVelvet(const glm::dvec3& normal) : normal_(normal) {}
  [[nodiscard]] gmis::BsdfValue<Spectrum> evaluate(const glm::dvec3& to_prev, const glm::dvec3& to_next,
                                                   gmis::TransportMode mode) const {
    const double prev = glm::dot(normal_, to_prev), next = glm::dot(normal_, to_next);
    if (!(prev * next > 0)) return {};
    // Light goes from to_next to to_prev for radiance, and the other way for importance.
    const double g = mode == gmis::TransportMode::radiance ? scattered(to_next, to_prev) : scattered(to_prev, to_next);
    return {Spectrum(g), {{std::abs(next) / gmis::pi<double>}, {std::abs(prev) / gmis::pi<double>}}};
  }
  [[nodiscard]] std::optional<gmis::ScatterSample<Spectrum>> sample(const glm::dvec3& to_prev, double,
                                                                    const glm::dvec2& uv,
                                                                    gmis::TransportMode mode) const {
    const glm::dvec3 side = glm::dot(normal_, to_prev) > 0 ? normal_ : -normal_;
    const glm::dvec3 to_next = gmis::Frame<double>::around(side).to_world(gmis::square_to_cosine_hemisphere(uv));
    const auto f = evaluate(to_prev, to_next, mode);
    if (!(f.pdf.forward.value > 0)) return std::nullopt;
    return gmis::ScatterSample<Spectrum>{to_next, f.value * gmis::pi<double>, f.pdf};
  }
  [[nodiscard]] bool is_purely_delta() const { return false; }
  [[nodiscard]] Spectrum albedo() const { return Spectrum(0.5); }

 private:
  [[nodiscard]] double scattered(const glm::dvec3&, const glm::dvec3& leaving) const {
    return 0.75 * (1 - std::abs(glm::dot(normal_, leaving)) / 2) / gmis::pi<double>;
  }
  glm::dvec3 normal_;
};
static_assert(gmis::IsBsdf<OneWayVelvet>());

}  // namespace

TEST_CASE("outdoors: a sky and a leaf with holes, by two integrators without bias", "[long]") {
  adapter::Leaf leaf;
  const theirs::World world = meadow(20, 16, 0.6, leaf);
  const adapter::Sky sky({0.8, 0.9, 1.2}, {0, 0, 0}, 7);
  const adapter::OutdoorScene scene(world, sky, leaf);
  gmis::SceneCheckSettings settings;
  settings.seed = gmis_test::seed(1);
  CHECK(gmis::check_scene(scene, settings).text() == "");
  using Scene = adapter::OutdoorScene;
  const auto a = gmis_test::tiles_of<gmis::Engine<Scene>>(scene, gmis::integrators::bpt, 2, 150);
  const auto b = gmis_test::tiles_of<gmis::PathTracer<Scene>>(scene, gmis::integrators::pt, 3, 300);
  gmis_test::check_same_picture(a, b);
}

TEST_CASE("a sky whose disk does not cover the border of the scene is named") {
  adapter::Leaf leaf;
  const theirs::World world = meadow(20, 16, 0.6, leaf);  // its ground reaches 4.2 from the center
  gmis::SceneCheckSettings settings;
  settings.seed = gmis_test::seed(4);
  const adapter::Sky sky({0.8, 0.9, 1.2}, {0, 0, 0}, 2.5);
  const auto findings = gmis::check_scene(adapter::OutdoorScene(world, sky, leaf), settings);
  REQUIRE(findings.broken().size() == 1);
  CHECK(findings.broken().front().convention == gmis::Convention::emission_disk);
}

TEST_CASE("a sky around a place far from the origin is sound") {
  adapter::Leaf leaf;
  const theirs::World world = meadow(20, 16, 0.6, leaf);
  const glm::dvec3 far(3e6, -1e6, 2e6);
  const adapter::OutdoorScene scene(world, adapter::Sky({0.8, 0.9, 1.2}, far, 7), leaf);
  std::array<gmis::SurfacePoint<double>, 1> receivers{};
  receivers[0].position = far;
  gmis::Philox source(gmis_test::seed(5));
  const std::span<const gmis::SurfacePoint<double>> seen(receivers);
  CHECK(gmis::check_light(scene, *scene.infinite_lights()[0], seen, source).text() == "");
}

TEST_CASE("a leaf lets through what its alpha leaves") {
  adapter::Leaf leaf;
  const theirs::World world = meadow(20, 16, 0.6, leaf);
  const adapter::Sky sky({0.8, 0.9, 1.2}, {0, 0, 0}, 7);
  const adapter::OutdoorScene scene(world, sky, leaf);
  gmis::Philox source(gmis_test::seed(4));
  constexpr int rays = 40'000;
  int blocked = 0;
  for (int i = 0; i < rays; ++i) {
    // Under the part of the leaf that is not above the ball.
    const glm::dvec3 below(-1.5 + 1.6 * gmis::uniform<double>(source), 0.5, -1 + 2 * gmis::uniform<double>(source));
    const gmis::Ray<double> up{below, {0, 1, 0}};
    if (!scene.visible(up)) ++blocked;
    // From the other side the same cells are opaque.
    const gmis::Ray<double> down{below + glm::dvec3(0, 1, 0), {0, -1, 0}, 1.0};
    if (scene.visible(down) != scene.visible(up)) FAIL_CHECK("the two sides disagree at " << below.x << ' ' << below.z);
  }
  // Four fifths of 65,536 cells are opaque with the probability 0.6 each, and 40,000 rays fall on
  // them: both are binomial. 1e-6.
  const double error = std::sqrt(0.6 * 0.4 * (1.0 / rays + 1.0 / (0.8 * 65536)));
  CHECK(gmis::z_test(static_cast<double>(blocked) / rays, error, 0.6).passes(1e-6));
}

TEST_CASE("check_bsdf holds for the materials of the other renderer, and for one that is not reciprocal") {
  gmis::CheckSettings few;
  few.samples = 40'000;
  few.bins = 200;
  const theirs::Matt matt({0.6, 0.15, 0.1});
  const adapter::Bsdf bsdf(matt, {0, 0, 1});
  const glm::dvec3 normal(0, 0, 1), to_prev = glm::normalize(glm::dvec3(0.5, 0.2, 0.6));
  gmis::Philox source(gmis_test::seed(5));
  const gmis::BsdfCheck check = gmis::check_bsdf(bsdf, normal, to_prev, source, few);
  CHECK(check.passes(1e-6));

  const gmis::BsdfCheck velvet = gmis::check_bsdf(OneWayVelvet(normal), normal, to_prev, source, few);
  CHECK(velvet.passes(1e-6));
  // For radiance and importance f differs: 1 − cos/2 of either direction.
  const OneWayVelvet one_way(normal);
  const glm::dvec3 to_next = glm::normalize(glm::dvec3(-0.1, 0.1, 0.9));
  CHECK(one_way.evaluate(to_prev, to_next, gmis::TransportMode::radiance).value.x !=
        Approx(one_way.evaluate(to_prev, to_next, gmis::TransportMode::importance).value.x));
}

TEST_CASE("an engine alone, and pictures of two engines kept apart") {
  const theirs::World world = theirs::make_world(16, 12);
  const adapter::Scene scene(world);
  std::vector<glm::dvec3> picture(16 * 12);
  {
    gmis::RenderSettings settings;
    settings.counts = gmis::integrators::bpt;
    gmis::Engine<adapter::Scene> engine(scene, settings);
    gmis::SerialExecutor executor;
    for (int i = 0; i < 4; ++i) {
      engine.iterate(executor);
      for (std::size_t p = 0; p < picture.size(); ++p) picture[p] += engine.frame()[p] / 4.0;
    }
  }
  double sum = 0;
  for (const auto& pixel : picture) sum += pixel.x;
  CHECK(sum > 0);

  // Two engines with seeds of their own are independent: their pictures differ by noise, and the
  // mean of both is a picture, too.
  gmis::RenderSettings one, other;
  one.counts = gmis::integrators::pt;
  other.counts = gmis::integrators::bpt;
  one.seed = 1;
  other.seed = 2;
  gmis::Engine<adapter::Scene> first(scene, one), second(scene, other);
  gmis::SerialExecutor executor;
  first.iterate(executor);
  const std::vector<glm::dvec3> first_picture(first.frame().begin(), first.frame().end());
  second.iterate(executor);
  CHECK(std::equal(first_picture.begin(), first_picture.end(), first.frame().begin()));
  CHECK_FALSE(std::equal(first_picture.begin(), first_picture.end(), second.frame().begin()));
}
