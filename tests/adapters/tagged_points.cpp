#include <array>
#include <cmath>
#include <numeric>
#include <utility>
#include <vector>

#include "bring_your_own/adapter.hpp"
#include "gmis/check/check_scene.hpp"
#include "gmis/core/scene_like.hpp"
#include "gmis/core/warp.hpp"
#include "support/catch.hpp"
#include "support/fewer.hpp"
#include "support/seed.hpp"
#include "transport/technique_estimates.hpp"

// A renderer in which the point alone does not say what absorbs and what shines there: a lamp of
// four textured tiles, sheets of paper that part two liquids. The tag of a point is the number of
// its shape. Light subpaths, camera subpaths, next events, splats and connections against
// quadrature: each of them must bring the tag of either end.

namespace {

using adapter::ours, adapter::Point, adapter::Spectrum, adapter::to_theirs;
using glm::dvec2, glm::dvec3;
using gmis::Technique;

constexpr double pi = theirs::pi;
constexpr std::size_t first_tile = 3, tile_count = 4;
constexpr double height_of_camera = 0.3, half_window = 0.5;

/// Colours, liquids and light of a shape.
struct Look {
  Spectrum reflected{0}, transmitted{0};        ///< albedos
  Spectrum above{0}, below{0};                  ///< absorbed per length, on either side; the normal points to `above`
  Spectrum shine{0};                            ///< radiance at the middle of a tile
  std::array<double, tile_count> preference{};  ///< of next events here: probabilities of the tiles
};

/// A floor, two sheets side by side above it, four tiles above these; one look more than shapes,
/// for the camera between the floor and the sheets.
struct House {
  std::vector<theirs::Shape> shapes;
  std::vector<Look> looks;
  double camera_looks = 1;  ///< up, or down where −1

  explicit House(double towards) : camera_looks(towards) {
    const Spectrum lower(0.9, 0.5, 0.2), upper(2.0, 1.1, 0.4);
    const auto add = [&](const theirs::Vector& corner, const theirs::Vector& a, const theirs::Vector& b, Look look) {
      shapes.push_back({nullptr, nullptr, false, corner, a, b});
      looks.push_back(std::move(look));
    };
    const std::array<double, tile_count> alike{0.25, 0.25, 0.25, 0.25};
    add({-1, -1, 0}, {2, 0, 0}, {0, 2, 0}, {Spectrum(0.7), {}, lower, {}, {}, alike});
    add({-1, -1, 0.6}, {1, 0, 0}, {0, 2, 0}, {Spectrum(0.2), Spectrum(0.6), upper, lower, {}, {0.4, 0.1, 0.4, 0.1}});
    add({0, -1, 0.6}, {1, 0, 0}, {0, 2, 0}, {Spectrum(0.5), Spectrum(0.3), upper, lower, {}, {0.1, 0.2, 0.3, 0.4}});
    for (int i = 0; i < 4; ++i)  // they face down
      add({0.8 * (i % 2) - 0.8, 0.8 * (i / 2) - 0.8, 1.2}, {0, 0.8, 0}, {0.8, 0, 0},
          {{}, {}, upper, {}, Spectrum(2.0 + 4.0 * i, 5, 3), {}});
    looks.push_back({{}, {}, lower, lower, {}, {}});
  }
  [[nodiscard]] std::optional<std::pair<std::size_t, dvec3>> first(const gmis::Ray<double>& ray) const {
    std::optional<std::pair<std::size_t, dvec3>> nearest;
    double farthest = ray.t_max;
    for (std::size_t i = 0; i < shapes.size(); ++i)
      if (const auto t = shapes[i].meet(to_theirs(ray.origin), to_theirs(ray.direction), farthest)) {
        farthest = *t;
        nearest = {i, ray.origin + *t * ray.direction};
      }
    return nearest;
  }
  [[nodiscard]] Point point_at(std::size_t shape, const dvec3& position) const {
    const dvec3 normal = ours(shapes[shape].normal_at({}));
    return {position, normal, normal, 1e-9, static_cast<std::uint32_t>(shape)};
  }
  /// Radiance of a tile: a ramp along its first side.
  [[nodiscard]] Spectrum texture(std::size_t shape, const dvec3& position) const {
    const theirs::Shape& tile = shapes[shape];
    const double s = glm::dot(position - ours(tile.corner), ours(tile.side_a)) / theirs::dot(tile.side_a, tile.side_a);
    return looks[shape].shine * (0.25 + 1.5 * s);
  }
};

/// Diffuse on both sides; light passes, too.
class Paper {
 public:
  using Spectrum = adapter::Spectrum;
  Paper(const Look& look, const dvec3& normal)
      : reflected_(look.reflected), transmitted_(look.transmitted), normal_(normal) {}
  [[nodiscard]] gmis::BsdfValue<Spectrum> evaluate(const dvec3& to_prev, const dvec3& to_next,
                                                   gmis::TransportMode) const {
    const double prev = glm::dot(normal_, to_prev), next = glm::dot(normal_, to_next);
    const bool reflects = prev * next > 0;
    const double share = (reflects ? share_reflected() : 1 - share_reflected()) / pi;
    return {(reflects ? reflected_ : transmitted_) / pi, {{share * std::abs(next)}, {share * std::abs(prev)}}};
  }
  [[nodiscard]] std::optional<gmis::ScatterSample<Spectrum>> sample(const dvec3& to_prev, double u, const dvec2& uv,
                                                                    gmis::TransportMode mode) const {
    const double side = (glm::dot(normal_, to_prev) > 0) == (u < share_reflected()) ? 1 : -1;
    const dvec3 to_next = gmis::Frame<double>::around(side * normal_).to_world(gmis::square_to_cosine_hemisphere(uv));
    const auto f = evaluate(to_prev, to_next, mode);
    const double cosine = std::abs(glm::dot(normal_, to_next));
    if (!(f.pdf.forward.value > 0)) return std::nullopt;
    return gmis::ScatterSample<Spectrum>{to_next, f.value * cosine / f.pdf.forward.value, f.pdf};
  }
  [[nodiscard]] bool is_purely_delta() const { return false; }
  [[nodiscard]] Spectrum albedo() const { return reflected_ + transmitted_; }

 private:
  [[nodiscard]] double share_reflected() const {
    return reflected_.x > 0 ? reflected_.x / (reflected_.x + transmitted_.x) : 0.5;
  }
  Spectrum reflected_, transmitted_;
  dvec3 normal_;
};
static_assert(gmis::IsBsdf<Paper>());

/// All tiles: one light. Its own samples have the tags of their tiles, as hits have.
class TiledLamp {
 public:
  using Spectrum = adapter::Spectrum;
  /// `tags`: its samples have tags; a mistake where not.
  explicit TiledLamp(const House& house, bool tags = true) : house_(&house), tags_(tags) {}
  [[nodiscard]] bool is_delta() const { return false; }
  [[nodiscard]] bool is_infinite() const { return false; }
  [[nodiscard]] gmis::Emitted<Spectrum> emitted(const Point& origin, const dvec3& direction) const {
    const double cosine = glm::dot(origin.geometric_normal, direction);
    if (cosine <= 0) return {};
    return {house_->texture(origin.tag, origin.position), {1 / (tile_count * tile_area), cosine / pi}};
  }
  [[nodiscard]] std::optional<gmis::EmissionSample<Spectrum>> sample_emission(const dvec2& uv_origin,
                                                                              const dvec2& uv_direction) const {
    const auto tile = std::min(static_cast<std::size_t>(tile_count * uv_origin.x), tile_count - 1);
    const Point origin = point_of_tile(tile, {tile_count * uv_origin.x - static_cast<double>(tile), uv_origin.y});
    const auto frame = gmis::Frame<double>::around(origin.geometric_normal);
    const dvec3 direction = frame.to_world(gmis::square_to_cosine_hemisphere(uv_direction));
    const auto emission = emitted(origin, direction);
    if (!(emission.density.first > 0)) return std::nullopt;
    return gmis::EmissionSample<Spectrum>{origin, direction, emission.radiance * pi * tile_area * double(tile_count),
                                          emission.density};
  }
  [[nodiscard]] std::optional<gmis::NextEventSample<Spectrum>> sample_next_event(const Point& from, dvec2 uv) const {
    const auto& preference = house_->looks[from.tag].preference;
    std::size_t tile = 0;
    while (tile + 1 < tile_count && uv.x >= preference[tile]) uv.x -= preference[tile++];
    const Point origin = point_of_tile(tile, {std::min(uv.x / preference[tile], 1.0), uv.y});
    const dvec3 offset = origin.position - from.position;
    const double distance_squared = glm::dot(offset, offset);
    const dvec3 to_light = offset / std::sqrt(distance_squared);
    const auto emission = emitted(origin, -to_light);
    if (!(emission.density.first > 0)) return std::nullopt;
    const double density = next_event_density(origin, -to_light, from);
    const double per_steradian = density * distance_squared / glm::dot(origin.geometric_normal, -to_light);
    return gmis::NextEventSample<Spectrum>{origin, to_light, emission.radiance / per_steradian, density,
                                           emission.density};
  }
  [[nodiscard]] double next_event_density(const Point& origin, const dvec3&, const Point& from) const {
    return house_->looks[from.tag].preference[origin.tag - first_tile] / tile_area;
  }

 private:
  static constexpr double tile_area = 0.64;
  [[nodiscard]] Point point_of_tile(std::size_t tile, const dvec2& at) const {
    const theirs::Shape& shape = house_->shapes[first_tile + tile];
    Point result = house_->point_at(first_tile + tile, ours(shape.corner + at.x * shape.side_a + at.y * shape.side_b));
    if (!tags_) result.tag = first_tile;
    return result;
  }
  const House* house_;
  bool tags_;
};
static_assert(gmis::IsLight<TiledLamp>());

/// Parallel rays from the plane of the camera, straight up or down.
class Window {
 public:
  using Spectrum = adapter::Spectrum;
  explicit Window(const House& house)
      : forward_(0, 0, house.camera_looks), tag_(static_cast<std::uint32_t>(house.shapes.size())) {}
  [[nodiscard]] glm::ivec2 resolution() const { return {pixels, pixels}; }
  [[nodiscard]] bool has_parallel_rays() const { return true; }
  [[nodiscard]] bool has_lens() const { return false; }
  [[nodiscard]] std::optional<gmis::CameraSample<Spectrum>> sample_ray(glm::ivec2 pixel, const dvec2& uv,
                                                                       const dvec2&) const {
    return gmis::CameraSample<Spectrum>{at((dvec2(pixel) + uv) * side - half_window), forward_, Spectrum(1), density};
  }
  [[nodiscard]] std::optional<gmis::CameraProjection<Spectrum>> project(const dvec3& point, const dvec2&) const {
    const dvec2 film = (dvec2(point) + half_window) / side;
    const glm::ivec2 pixel(glm::floor(film));
    if (!((point.z - height_of_camera) * forward_.z > 0) || glm::any(glm::lessThan(pixel, glm::ivec2(0))) ||
        glm::any(glm::greaterThanEqual(pixel, glm::ivec2(pixels))))
      return std::nullopt;
    return gmis::CameraProjection<Spectrum>{pixel, at(dvec2(point)), -forward_, Spectrum(1), density};
  }

 private:
  static constexpr int pixels = 16;
  static constexpr double side = 2 * half_window / pixels, density = 1 / (side * side);
  /// The tag says in which liquid the camera is.
  [[nodiscard]] Point at(const dvec2& place) const { return {dvec3(place, height_of_camera), {}, {}, 0, tag_}; }
  dvec3 forward_;
  std::uint32_t tag_;
};
static_assert(gmis::IsCamera<Window>());

class PaperHouse {
 public:
  using Spectrum = adapter::Spectrum;
  using Bsdf = Paper;
  using Light = TiledLamp;
  using Camera = Window;
  explicit PaperHouse(const House& house, bool lamp_has_tags = true)
      : house_(&house), lamp_(house, lamp_has_tags), camera_(house) {}
  [[nodiscard]] std::optional<gmis::Hit<double, Bsdf, Light>> intersect(const gmis::Ray<double>& ray) const {
    const auto met = house_->first(ray);
    if (!met) return std::nullopt;
    const auto [shape, position] = *met;
    const Point point = house_->point_at(shape, position);
    return gmis::Hit<double, Bsdf, Light>{point, Paper(house_->looks[shape], point.geometric_normal),
                                          shape >= first_tile ? &lamp_ : nullptr};
  }
  [[nodiscard]] bool visible(const gmis::Ray<double>& ray) const { return !house_->first(ray); }
  [[nodiscard]] gmis::LightChoice<double, Light> sample_light(double) const { return {&lamp_, 1}; }
  [[nodiscard]] double selection_probability(const Light&) const { return 1; }
  [[nodiscard]] std::array<const Light*, 0> infinite_lights() const { return {}; }
  [[nodiscard]] const Camera& camera() const { return camera_; }

  [[nodiscard]] bool has_absorption() const { return true; }
  [[nodiscard]] Spectrum transmittance(const gmis::Ray<double>& ray, const Point& from, const Point&) const {
    const Look& look = house_->looks[from.tag];
    const bool goes_up = glm::dot(ray.direction, from.geometric_normal) > 0;  // the normal points to `above`
    return glm::exp((goes_up ? look.above : look.below) * -ray.t_max);
  }

 private:
  const House* house_;
  TiledLamp lamp_;
  Window camera_;
};
static_assert(gmis::IsScene<PaperHouse>() && gmis::SceneWithAbsorptionBetween<PaperHouse>);

/// Counts the segments of which the two ends disagree about what absorbs.
class BothEnds : public gmis::SceneLike<PaperHouse> {
 public:
  using SceneLike::SceneLike;
  [[nodiscard]] Spectrum transmittance(const gmis::Ray<double>& ray, const Point& from, const Point& to) const {
    const Spectrum there = SceneLike::transmittance(ray, from, to);
    const Spectrum back = SceneLike::transmittance({ray.origin, -ray.direction, ray.t_max}, to, from);
    ++segments;
    if (there != back) ++disagreements;
    return there;
  }
  mutable std::size_t segments = 0, disagreements = 0;
};
static_assert(gmis::SceneWithAbsorptionBetween<BothEnds>);

/// Absorbs more light on the way up than on the way down: a mistake.
class OneWay : public gmis::SceneLike<PaperHouse> {
 public:
  using SceneLike::SceneLike;
  [[nodiscard]] Spectrum transmittance(const gmis::Ray<double>& ray, const Point& from, const Point& to) const {
    return SceneLike::transmittance(ray, from, to) * (ray.direction.z > 0 ? 0.8 : 1.0);
  }
};
static_assert(gmis::SceneWithAbsorptionBetween<OneWay>);

/// Nodes and weights of Gauss and Legendre on [0, 1].
std::vector<dvec2> gauss_legendre(int n) {
  std::vector<dvec2> result;
  for (int i = 0; i < n; ++i) {
    double x = std::cos(pi * (i + 0.75) / (n + 0.5)), slope = 1;
    for (int step = 0; step < 8; ++step) {
      double p = 1, before = 0;
      for (int k = 0; k < n; ++k) before = std::exchange(p, ((2 * k + 1) * x * p - k * before) / (k + 1));
      slope = n * (x * p - before) / (x * x - 1);
      x -= p / slope;
    }
    result.emplace_back((1 + x) / 2, 1 / ((1 - x * x) * slope * slope));
  }
  return result;
}
/// A point of a horizontal rectangle with its share of the area; `value`: what leaves it or arrives
/// there, in the first channel.
struct Node {
  dvec3 at;
  double area;
  std::size_t shape;
  double value = 0;
};
using Nodes = std::vector<Node>;
void add_nodes(Nodes& nodes, const dvec3& corner, const dvec3& a, const dvec3& b, std::size_t shape, int n = 20) {
  const double area = glm::length(glm::cross(a, b));
  for (const dvec2& u : gauss_legendre(n))
    for (const dvec2& v : gauss_legendre(n)) nodes.push_back({corner + u.x * a + v.x * b, area * u.y * v.y, shape});
}
/// Irradiance at `at` under nodes whose `value` is a radiance, through a liquid.
double irradiance(const dvec3& at, const Nodes& nodes, double sigma) {
  double sum = 0;
  for (const Node& node : nodes) {
    const double d = glm::distance(at, node.at), height = at.z - node.at.z;
    sum += node.value * node.area * gmis::square(height / (d * d)) * std::exp(-sigma * d);
  }
  return sum;
}

/// The means of the pictures, by the number of edges, in the first channel.
struct Truth {
  double up_2 = 0, up_4 = 0, down_3 = 0;
  explicit Truth(const House& house) {
    const double lower = house.looks[0].above.x, upper = house.looks[1].above.x;
    const auto of_shape = [&](Nodes& nodes, std::size_t i) {
      const theirs::Shape& shape = house.shapes[i];
      add_nodes(nodes, ours(shape.corner), ours(shape.side_a), ours(shape.side_b), i);
    };
    Nodes tiles, sheets, floor;
    for (std::size_t i = 0; i < tile_count; ++i) of_shape(tiles, first_tile + i);
    for (Node& node : tiles) node.value = house.texture(node.shape, node.at).x;
    for (const std::size_t i : {std::size_t{1}, std::size_t{2}}) of_shape(sheets, i);
    const auto through = [&](const Node& node) {  // radiance under a sheet, of light that passed it
      return house.looks[node.shape].transmitted.x / pi * irradiance(node.at, tiles, upper);
    };
    for (Node& node : sheets) node.value = through(node);
    of_shape(floor, 0);
    const double grey = house.looks[0].reflected.x / pi;
    for (Node& node : floor) node.value = grey * irradiance(node.at, sheets, lower);

    Nodes seen;
    for (const std::size_t i : {std::size_t{1}, std::size_t{2}})
      add_nodes(seen, {i == 1 ? -half_window : 0, -half_window, 0.6}, {half_window, 0, 0}, {0, 2 * half_window, 0}, i);
    const double window = 4 * half_window * half_window;
    for (const Node& node : seen) {
      up_2 += node.area / window * std::exp(-lower * (0.6 - height_of_camera)) * through(node);
      up_4 += node.area / window * std::exp(-lower * (0.6 - height_of_camera)) * house.looks[node.shape].reflected.x /
              pi * irradiance(node.at, floor, lower);
      const dvec3 below(node.at.x, node.at.y, 0);
      down_3 += node.area / window * std::exp(-lower * height_of_camera) * grey * irradiance(below, sheets, lower);
    }
  }
};

gmis::RenderSettings settings(int max_depth) {
  gmis::RenderSettings result;
  result.max_depth = max_depth;
  result.counts.light_paths = 1;
  result.radius = 0.03;
  result.alpha = 1.0;
  result.seed = gmis_test::seed(71);
  return result;
}

}  // namespace

TEMPLATE_TEST_CASE("a textured lamp and liquids between sheets, by the tags of points", "", gmis_test::ways::Pt,
                   gmis_test::ways::Bpt, gmis_test::ways::Vcm) {
  const House up(1), down(-1);
  const Truth truth(up);
  // Merging takes what arrives within its radius for what arrives at the point.
  const double bias = TestType::has(Technique::merge) ? 0.002 : 0;
  constexpr int iterations = 160 / gmis_test::fewer;
  const double power = std::sqrt(gmis_test::fewer);
  {
    const PaperHouse house(up);
    const BothEnds scene(house);
    const auto found = gmis_test::estimate<TestType>(scene, settings(4), iterations);
    gmis_test::check_closed_form("up, 2 edges", found.together(2), truth.up_2, 0.015 * power, bias);
    gmis_test::check_closed_form("up, 4 edges", found.together(4), truth.up_4, 0.05 * power, bias);
    if (TestType::has(Technique::connect))
      gmis_test::check_closed_form("connections", found.alone(Technique::connect, 4), 2 * truth.up_4, 0.03 * power);
    CHECK(scene.segments > 100'000 / gmis_test::fewer);
    CHECK(scene.disagreements == 0);
  }
  const PaperHouse house(down);
  const BothEnds scene(house);
  const auto found = gmis_test::estimate<TestType>(scene, settings(3), iterations);
  gmis_test::check_closed_form("down", found.together(3), truth.down_3, 0.015 * power, bias);
  gmis_test::check_closed_form("next events", found.alone(Technique::next_event, 3), truth.down_3, 0.03 * power);
  gmis_test::check_closed_form("emitter hits", found.alone(Technique::emitter_hit, 3), truth.down_3, 0.03 * power);
  if (TestType::has(Technique::splat))
    gmis_test::check_closed_form("splats", found.alone(Technique::splat, 3), truth.down_3, 0.03 * power);
  CHECK(scene.disagreements == 0);
}

TEST_CASE("the adapter that tags its points is sound", "[long]") {
  const House house(1);
  gmis::SceneCheckSettings check;
  check.seed = gmis_test::seed(72);
  CHECK(gmis::check_scene(PaperHouse(house), check).text() == "");
  const auto broken = gmis::check_scene(PaperHouse(house, false), check).broken();
  REQUIRE_FALSE(broken.empty());
  CHECK(broken.front().convention == gmis::Convention::light_tag);
}

TEST_CASE("a liquid that absorbs otherwise on the way back is named", "[long]") {
  const House house(1);
  const PaperHouse sound(house);
  gmis::SceneCheckSettings check;
  check.seed = gmis_test::seed(73);
  const auto broken = gmis::check_scene(OneWay(sound), check).broken();
  REQUIRE_FALSE(broken.empty());
  CHECK(broken.front().convention == gmis::Convention::transmittance);
}
