#include "gmis/transport/replay/replay.hpp"

#include <cmath>
#include <cstring>
#include <vector>

#include "support/catch.hpp"
#include "support/seed.hpp"
#include "transport/furnace_scene.hpp"
#include "transport/ways.hpp"

namespace {

using Scene = gmis_test::FurnaceScene<float>;
using Record = gmis::Contribution<float>;

constexpr int size = 10;
constexpr float albedo = 0.7F;

gmis::RenderSettings settings() {
  gmis::RenderSettings result;
  result.max_depth = 5;
  result.radius = 0.1;
  result.seed = gmis_test::seed(8);
  return result;
}

bool are_same(const Record& a, const Record& b) {
  return a.pixel == b.pixel && a.id.technique == b.id.technique && a.id.s == b.id.s && a.id.t == b.id.t &&
         std::memcmp(&a.value, &b.value, sizeof a.value) == 0 &&
         std::memcmp(&a.weight, &b.weight, sizeof a.weight) == 0;
}

/// Whether a contribution names its other end exactly where its technique has one.
bool has_other_end(const gmis::ReplayedContribution<float>& made) {
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

/// Every path of `iteration` replayed, against what a run that got there kept.
template <class I>
void check_replay(const gmis::RenderSettings& render_settings, std::uint32_t iteration, int lobes = 1,
                  std::optional<gmis::PixelBounds> crop = {}) {
  CAPTURE(iteration);
  const Scene scene(albedo, 1.0F, size, lobes);
  gmis::SerialExecutor executor;
  typename I::template Engine<Scene> engine(scene, I::settings(render_settings), crop);
  engine.keep_contributions(true);
  for (std::uint32_t i = 0; i < iteration; ++i) engine.iterate(executor);
  std::vector<Record> expected;
  engine.for_each_contribution([&](const Record& record) { expected.push_back(record); });
  REQUIRE(expected.size() > 100);

  typename I::template Engine<Scene> replayed(scene, I::settings(render_settings), crop);
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
      REQUIRE(glm::dot(glm::normalize(parent.point.position - here.point.position), here.to_prev) > 0.999F);
    }
    float sum = 0.0F;
    for (const auto& made : path.contributions) {
      REQUIRE(next < expected.size());
      REQUIRE(are_same(made.contribution, expected[next++]));
      REQUIRE(made.vertex < path.vertices.size());
      REQUIRE_FALSE(made.rejected.has_value());
      REQUIRE(has_other_end(made));
      sum += made.contribution.value * made.contribution.weight;
    }
    if (kind == gmis::PathKind::camera) {
      REQUIRE(path.pixel_sum == sum);
    }
  };
  for (std::size_t tree = 0; tree < replayed.light_tree_count(); ++tree) check_path(gmis::PathKind::light, tree);
  const gmis::PixelBounds part = crop.value_or(gmis::PixelBounds{{0, 0}, {size, size}});
  for (int y = part.lower.y; y < part.upper.y; ++y)
    for (int x = part.lower.x; x < part.upper.x; ++x)
      check_path(gmis::PathKind::camera, static_cast<std::size_t>(y * size + x));
  CHECK(next == expected.size());
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
          // One nominal child per survivor; emission and the camera's rays are certain.
          double forward = albedo * cos_from / pi;
          if (i == 1 && kind == gmis::PathKind::light) forward = cos_from / pi;
          if (i == 1 && kind == gmis::PathKind::camera) {
            const double pixel_area = 1.5 * 1.5 / (size * size);
            forward = 1.0 / (pixel_area * std::pow(direction.z, 3.0));
          }
          CHECK(here.forward == Approx(forward).epsilon(1e-3));
          CHECK(here.density == Approx(forward * cos_here / (distance * distance)).epsilon(2e-3));
          if (i >= 2) {
            const double cos_back = glm::dot(glm::dvec3(from.to_prev), glm::dvec3(from.point.geometric_normal));
            CHECK(here.reverse == Approx(albedo * cos_back / pi).epsilon(1e-3));
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
  CHECK(vertices > 500);  // 1020 ± 24
  CHECK(light_ends > 100);
}
