#include "gmis/transport/replay/replay.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>
#include <optional>
#include <vector>

#include "gmis/scene.hpp"
#include "support/catch.hpp"
#include "support/seed.hpp"
#include "transport/furnace_scene.hpp"
#include "transport/provoking_scene.hpp"
#include "transport/ways.hpp"

namespace {

using Scene = gmis_test::FurnaceScene<float>;
using gmis_test::Provocation;
using gmis_test::ProvokingScene;

constexpr int size = 10;
constexpr float albedo = 0.7F;

gmis::RenderSettings settings() {
  gmis::RenderSettings result;
  result.max_depth = 5;
  result.radius = 0.1;
  result.seed = gmis_test::seed(8);
  return result;
}

template <class Record>
bool are_same(const Record& a, const Record& b) {
  return a.pixel == b.pixel && a.id.technique == b.id.technique && a.id.s == b.id.s && a.id.t == b.id.t &&
         std::memcmp(&a.value, &b.value, sizeof a.value) == 0 &&
         std::memcmp(&a.weight, &b.weight, sizeof a.weight) == 0;
}

/// Whether a contribution names its other end exactly where its technique has one.
template <class Spectrum>
bool has_other_end(const gmis::ReplayedContribution<Spectrum>& made) {
  switch (made.contribution.id.technique) {
    case gmis::Technique::next_event:
      return made.position.has_value() && !made.light_vertex.has_value();
    case gmis::Technique::connect:
    case gmis::Technique::merge:
      return made.position.has_value() && made.light_vertex.has_value();
    default:
      return !made.position.has_value() && !made.light_vertex.has_value();
  }
}

/// The replayed paths of an iteration, summed up: all but the contributions that reached the film.
struct Replayed {
  std::uint64_t non_finite = 0, negative = 0, zero_densities = 0;
  std::uint64_t escapes = 0, lit_escapes = 0;    ///< rays that left the scene, and contributions made there
  std::vector<gmis::RejectedPath> rejected;      ///< paths with a rejection, light trees first
  gmis::Counters counters, counters_of_the_run;  ///< rejections are the last three
  std::vector<gmis::RejectedPath> rejected_by_the_run;
};

/// Every path of `iteration` replayed, against what a run that got there kept.
template <class I, class SceneType>
Replayed replay_all(const SceneType& scene, const gmis::RenderSettings& render_settings, std::uint32_t iteration,
                    std::optional<gmis::PixelBounds> crop = {}) {
  using Spectrum = typename SceneType::Spectrum;
  CAPTURE(iteration);
  gmis::SerialExecutor executor;
  typename I::template Engine<SceneType> engine(scene, I::settings(render_settings), crop);
  engine.keep_contributions(true);
  for (std::uint32_t i = 0; i < iteration; ++i) engine.iterate(executor);
  std::vector<gmis::Contribution<Spectrum>> expected;
  engine.for_each_contribution([&](const auto& record) { expected.push_back(record); });
  REQUIRE(expected.size() > 100);

  Replayed result;
  result.counters_of_the_run = engine.counters();
  result.rejected_by_the_run.assign(engine.rejections().paths().begin(), engine.rejections().paths().end());
  typename I::template Engine<SceneType> replayed(scene, I::settings(render_settings), crop);
  replayed.prepare_replay(executor, iteration);
  CHECK(replayed.counts().connections == engine.counts().connections);
  CHECK(replayed.counts().extends_camera == engine.counts().extends_camera);
  std::size_t next = 0;
  const auto check_path = [&](gmis::PathKind kind, std::size_t number) {
    const auto path = gmis::replay(replayed, kind, static_cast<std::uint32_t>(number));
    REQUIRE(path.name == gmis::PathName{kind, iteration, static_cast<std::uint32_t>(number)});
    REQUIRE(path.vertices_per_tree == engine.vertices_per_tree());
    REQUIRE(path.radius == engine.merge_radius(iteration));
    REQUIRE(path.counts.connections == engine.counts().connections);
    for (std::size_t i = 1; i < path.vertices.size(); ++i) {
      const auto& here = path.vertices[i];
      REQUIRE(here.parent < i);
      const auto& parent = path.vertices[here.parent];
      REQUIRE(here.depth == parent.depth + 1);
      REQUIRE_FALSE(parent.is_at_infinity);
      if (here.is_at_infinity) {
        ++result.escapes;
        REQUIRE(here.point.position == gmis::Vec3<float>(0.0F));
        REQUIRE(here.density == 0.0F);
        REQUIRE(here.forward > 0.0F);
        REQUIRE_FALSE(here.weights.has_value());
        REQUIRE(glm::length(here.to_prev) == Approx(1.0F).epsilon(1e-5));
        REQUIRE_FALSE(scene.intersect(gmis::leave(parent.point, -here.to_prev)).has_value());
      } else {
        REQUIRE(glm::dot(glm::normalize(parent.point.position - here.point.position), here.to_prev) > 0.999F);
      }
    }
    Spectrum sum(0.0F);
    gmis::RejectedPath rejected{path.name, 0, gmis::RejectionCause::zero_pdf, {}};
    for (const auto& made : path.contributions) {
      REQUIRE(made.vertex < path.vertices.size());
      REQUIRE(has_other_end(made));
      if (made.rejected) {
        const bool is_negative = *made.rejected == gmis::RejectionCause::negative;
        ++(is_negative ? result.negative : result.non_finite);
        if (++rejected.count == 1) rejected.cause = *made.rejected, rejected.technique = made.contribution.id;
        continue;
      }
      REQUIRE(next < expected.size());
      REQUIRE(are_same(made.contribution, expected[next++]));
      sum += made.contribution.value * made.contribution.weight;
      if (path.vertices[made.vertex].is_at_infinity) ++result.lit_escapes;
    }
    for (const auto& zero : path.zero_densities) {
      REQUIRE(zero.vertex < path.vertices.size());
      ++result.zero_densities;
      if (++rejected.count == 1) rejected.technique = zero.technique;
    }
    if (rejected.count > 0) result.rejected.push_back(rejected);
    result.counters += path.counters;
    if (kind == gmis::PathKind::camera) {
      REQUIRE(path.pixel_sum == sum);
    }
  };
  for (std::size_t tree = 0; tree < replayed.light_tree_count(); ++tree) check_path(gmis::PathKind::light, tree);
  const glm::ivec2 resolution = scene.camera().resolution();
  const gmis::PixelBounds part = crop.value_or(gmis::PixelBounds{{0, 0}, resolution});
  for (int y = part.lower.y; y < part.upper.y; ++y)
    for (int x = part.lower.x; x < part.upper.x; ++x)
      check_path(gmis::PathKind::camera, static_cast<std::size_t>(y * resolution.x + x));
  CHECK(next == expected.size());
  return result;
}

/// In the closed furnace, where all is right.
template <class I>
void check_replay(const gmis::RenderSettings& render_settings, std::uint32_t iteration, int lobes = 1,
                  std::optional<gmis::PixelBounds> crop = {}) {
  const Replayed all = replay_all<I>(Scene(albedo, 1.0F, size, lobes), render_settings, iteration, crop);
  CHECK(all.rejected.empty());
  CHECK(all.non_finite + all.negative + all.zero_densities == 0);
}

/// In a furnace whose surfaces or lights do wrong (`ProvokingScene`): the first iteration, each of
/// whose rejections has a name.
template <class I>
void check_replay_of_rejected(Provocation what, float bad) {
  CAPTURE(static_cast<int>(what), bad);
  const Replayed all = replay_all<I>(ProvokingScene(size, {what, bad, nullptr, 0.5F}), settings(), 1);
  const gmis::Counters& run = all.counters_of_the_run;
  CHECK(run.rejected() > 10);  // so that there is something to see: 25 of 100 paths and more
  CHECK(all.non_finite == run.rejected_non_finite);
  CHECK(all.negative == run.rejected_negative);
  CHECK(all.zero_densities == run.rejected_zero_pdf);
  CHECK(all.counters.rejected_non_finite == run.rejected_non_finite);
  CHECK(all.counters.rejected_negative == run.rejected_negative);
  CHECK(all.counters.rejected_zero_pdf == run.rejected_zero_pdf);
  CHECK(all.counters.contributions == run.contributions);
  // The run keeps the names of the first paths.
  REQUIRE(all.rejected_by_the_run.size() == std::min(all.rejected.size(), gmis::RejectionLog::capacity));
  for (std::size_t i = 0; i < all.rejected_by_the_run.size(); ++i) {
    const gmis::RejectedPath &mine = all.rejected[i], &its = all.rejected_by_the_run[i];
    CAPTURE(i, mine.path.number, its.path.number);
    CHECK(mine.path == its.path);
    CHECK(mine.count == its.count);
    CHECK(mine.cause == its.cause);
    REQUIRE(mine.technique.has_value() == its.technique.has_value());
    if (!mine.technique) continue;
    CHECK(mine.technique->technique == its.technique->technique);
    CHECK(mine.technique->s == its.technique->s);
    CHECK(mine.technique->t == its.technique->t);
  }
}

/// A furnace without the part of its wall where x is above 0.3, and nothing beyond.
class OpenFurnace : public Scene {
 public:
  using Scene::Scene;
  [[nodiscard]] auto intersect(const gmis::Ray<float>& ray) const {
    auto hit = Scene::intersect(ray);
    if (hit && hit->point.position.x > 0.3F) hit.reset();
    return hit;
  }
};

/// A ball on a floor under a sky of one radiance.
gmis::scene::BvhScene<float> outdoors() {
  gmis::scene::SceneBuilder<float> builder;
  const auto grey = builder.add_material(gmis::scene::make_diffuse({0.5, 0.6, 0.7}));
  const std::vector<glm::dvec3> corners{{-4, -1, -4}, {4, -1, -4}, {4, -1, 4}, {-4, -1, 4}};
  builder.add_mesh({corners, std::vector<std::array<int, 3>>{{0, 1, 2}, {0, 2, 3}}}, grey);
  builder.add_sphere({0, 0, 0}, 1, grey);
  builder.add_environment({0.8, 0.9, 1.0});
  builder.set_camera(gmis::scene::look_at({0, 0.5, -4}, {0, 0, 0}, {0, 1, 0}, 50, {12, 9}));
  return builder.build();
}

}  // namespace

TEST_CASE("A path replayed alone makes what it made in the run, bit by bit") {
  using namespace gmis_test::ways;
  SECTION("lt") {
    check_replay<Lt>(settings(), 3);
  }
  SECTION("vcm") {
    for (const std::uint32_t iteration : {1U, 4U, 9U}) check_replay<Vcm>(settings(), iteration);
  }
  SECTION("vcm, paired, half as many trees as pixels") {
    auto paired = settings();
    paired.counts.connects_paired_tree = true;
    paired.counts.light_paths = 0.5;
    check_replay<Vcm>(paired, 2);
  }
  SECTION("vcm, a crop") {
    check_replay<Vcm>(settings(), 8, 1, gmis::PixelBounds{{2, 1}, {9, 7}});
  }
  SECTION("gmis") {
    check_replay<Gmis>(settings(), 2, 2);
  }
}

TEST_CASE("A replayed path says what was rejected of it, and the rest is what the run kept") {
  using namespace gmis_test::ways;
  constexpr float infinity = std::numeric_limits<float>::infinity(), nan = std::numeric_limits<float>::quiet_NaN();
  SECTION("pt") {
    check_replay_of_rejected<Pt>(Provocation::value, nan);
    check_replay_of_rejected<Pt>(Provocation::value, -1.0F);
    check_replay_of_rejected<Pt>(Provocation::density, 0.0F);
    check_replay_of_rejected<Pt>(Provocation::light_density, infinity);
  }
  SECTION("vcm") {
    check_replay_of_rejected<Vcm>(Provocation::value, infinity);
    check_replay_of_rejected<Vcm>(Provocation::value, -1.0F);
    check_replay_of_rejected<Vcm>(Provocation::density, nan);
    check_replay_of_rejected<Vcm>(Provocation::light_density, 0.0F);
  }
}

TEST_CASE("A replayed path that leaves the scene has its last vertex at infinity, and makes what it made in the run") {
  using namespace gmis_test::ways;
  SECTION("into nothing") {
    const OpenFurnace open(albedo, 1.0F, size);
    const Replayed pt = replay_all<Pt>(open, settings(), 3), vcm = replay_all<Vcm>(open, settings(), 2);
    for (const Replayed& all : {pt, vcm}) {
      CHECK(all.escapes > 50);  // of 100 camera paths
      CHECK(all.lit_escapes == 0);
      CHECK(all.rejected.empty());
    }
  }
  SECTION("into a sky") {
    const auto scene = outdoors();
    const Replayed pt = replay_all<Pt>(scene, settings(), 3), vcm = replay_all<Vcm>(scene, settings(), 2);
    for (const Replayed& all : {pt, vcm}) {
      // A path from the camera ends in the sky at the latest when the floor does not hold it, and
      // every end there is seen to be lit.
      CHECK(all.escapes > 50);
      CHECK(all.lit_escapes == all.escapes);
      CHECK(all.rejected.empty());
    }
  }
}

TEST_CASE("What a replayed path says of its vertices") {
  const Scene scene(albedo, 1.0F, size);
  gmis::Engine<Scene> engine(scene, settings());
  gmis::SerialExecutor executor;
  constexpr double pi = 3.14159265358979;
  int vertices = 0, light_ends = 0;
  for (const std::uint32_t iteration : {6U, 7U})
    for (const gmis::PathKind kind : {gmis::PathKind::camera, gmis::PathKind::light}) {
      engine.prepare_replay(executor, iteration);
      for (std::uint32_t number = 0; number < size * size; ++number) {
        const auto path = gmis::replay(engine, kind, number);
        CAPTURE(number);
        for (std::size_t i = 1; i < path.vertices.size(); ++i) {
          const auto& here = path.vertices[i];
          REQUIRE(here.parent == i - 1);
          REQUIRE(here.depth == static_cast<int>(i));
          const auto& from = path.vertices[i - 1];
          const glm::dvec3 offset = glm::dvec3(here.point.position) - glm::dvec3(from.point.position);
          const double distance = glm::length(offset);
          const glm::dvec3 direction = offset / distance;
          REQUIRE(glm::length(glm::dvec3(here.to_prev) + direction) < 1e-3);
          const double cos_here = -glm::dot(direction, glm::dvec3(here.point.geometric_normal));
          const double cos_from = glm::dot(direction, glm::dvec3(from.point.geometric_normal));
          // One nominal child per survivor; emission and the camera's rays are certain, and so is
          // going on from the first vertex that the camera sees.
          const bool is_camera = kind == gmis::PathKind::camera;
          const double by_light = albedo, by_camera = is_camera && i == 2 ? 1.0 : 0.9 * albedo;
          double forward = (is_camera ? by_camera : by_light) * cos_from / pi;
          if (i == 1 && kind == gmis::PathKind::light) forward = cos_from / pi;
          if (i == 1 && kind == gmis::PathKind::camera) {
            const double pixel_area = 1.5 * 1.5 / (size * size);
            forward = 1.0 / (pixel_area * std::pow(direction.z, 3.0));
          }
          CHECK(here.forward == Approx(forward).epsilon(1e-3));
          CHECK(here.density == Approx(forward * cos_here / (distance * distance)).epsilon(2e-3));
          if (i >= 2) {
            const double cos_back = glm::dot(glm::dvec3(from.to_prev), glm::dvec3(from.point.geometric_normal));
            CHECK(here.reverse == Approx((is_camera ? by_light : by_camera) * cos_back / pi).epsilon(1e-3));
          }
          REQUIRE(here.weights.has_value());
          if (kind == gmis::PathKind::camera)
            CHECK(here.weights->shared.to_double() == Approx(1.0 / static_cast<double>(here.density)).epsilon(1e-5));
          ++vertices;
        }
        for (const auto& made : path.contributions) {
          if (!made.light_vertex) continue;
          const auto& [tree, depth] = *made.light_vertex;
          const auto other = gmis::replay(engine, gmis::PathKind::light, tree);
          REQUIRE(other.vertices[static_cast<std::size_t>(depth)].point.position == made.position.value());
          ++light_ends;
        }
      }
    }
  CHECK(vertices > 500);  // 1110 ± 24
  CHECK(light_ends > 100);
}
