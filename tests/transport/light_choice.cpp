#include <array>
#include <cmath>
#include <optional>
#include <string>

#include "gmis/core/light_choice.hpp"
#include "gmis/core/statistics.hpp"
#include "support/catch.hpp"
#include "support/seed.hpp"
#include "transport/furnace_scene.hpp"
#include "transport/mean_of_iterations.hpp"
#include "transport/ways.hpp"

// A light cut in two that next events choose between with probabilities that depend on the
// receiver: the picture is that of the whole light.

namespace {

/// The uniform furnace whose light is two: the halves of the sphere above and below the plane
/// y = 0.
class SplitFurnace {
 public:
  using Inner = gmis_test::FurnaceScene<float>;
  using Spectrum = float;
  using Bsdf = Inner::Bsdf;
  using Camera = Inner::Camera;
  using V = gmis::Vec3<float>;
  using Point = gmis::SurfacePoint<float>;

  /// Half of the sphere, which shines inwards with radiance 1.
  class Light {
   public:
    using Spectrum = float;
    explicit Light(float side) : side_(side) {}
    [[nodiscard]] bool is_delta() const { return false; }
    [[nodiscard]] bool is_infinite() const { return false; }
    [[nodiscard]] std::optional<gmis::NextEventSample<float>> sample_next_event(const Point& from,
                                                                                const gmis::Vec2<float>& uv) const {
      const Point origin = point_at(uv);
      const V offset = origin.position - from.position;
      const float distance_squared = glm::dot(offset, offset);
      if (distance_squared < 1e-8F) return std::nullopt;
      const V to_light = offset / std::sqrt(distance_squared);
      const float cosine = -glm::dot(origin.geometric_normal, to_light);
      if (cosine <= 0.0F) return std::nullopt;
      return gmis::NextEventSample<float>{
          origin, to_light, cosine / (distance_squared * density), density, {density, cosine / gmis::pi<float>}};
    }
    [[nodiscard]] std::optional<gmis::EmissionSample<float>> sample_emission(
        const gmis::Vec2<float>& uv_origin, const gmis::Vec2<float>& uv_direction) const {
      const Point origin = point_at(uv_origin);
      const V local = gmis::square_to_cosine_hemisphere(uv_direction);
      if (local.z <= 0.0F) return std::nullopt;
      return gmis::EmissionSample<float>{origin,
                                         gmis::Frame<float>::around(origin.geometric_normal).to_world(local),
                                         gmis::pi<float> / density,
                                         {density, local.z / gmis::pi<float>}};
    }
    [[nodiscard]] gmis::Emitted<float> emitted(const Point& origin, const V& direction) const {
      const float cosine = glm::dot(origin.geometric_normal, direction);
      if (cosine <= 0.0F) return {};
      return {1.0F, {density, cosine / gmis::pi<float>}};
    }
    [[nodiscard]] float next_event_density(const Point&, const V&, const Point&) const { return density; }

   private:
    static constexpr float density = 1.0F / (2.0F * gmis::pi<float>);
    [[nodiscard]] Point point_at(const gmis::Vec2<float>& uv) const {
      V p = gmis::square_to_sphere(uv);
      p.y = std::copysign(p.y, side_);
      return {p, -p, -p, 0.0F};
    }
    float side_;
  };

  explicit SplitFurnace(float albedo) : inner_(albedo, 1.0F, 16, 2) {}

  [[nodiscard]] std::optional<gmis::Hit<float, Bsdf, Light>> intersect(const gmis::Ray<float>& ray) const {
    const auto hit = inner_.intersect(ray);
    if (!hit) return std::nullopt;
    return gmis::Hit<float, Bsdf, Light>{hit->point, hit->bsdf, &lights_[hit->point.position.y < 0.0F ? 1 : 0]};
  }
  [[nodiscard]] bool visible(const gmis::Ray<float>&) const { return true; }
  [[nodiscard]] gmis::LightChoice<float, Light> sample_light(float u) const {
    const Light& light = lights_[u < 0.3F ? 0 : 1];
    return {&light, selection_probability(light)};
  }
  [[nodiscard]] float selection_probability(const Light& light) const { return &light == &lights_[0] ? 0.3F : 0.7F; }
  [[nodiscard]] gmis::LightChoice<float, Light> sample_light(const Point& from, float u) const {
    const Light& light = lights_[u < upper(from) ? 0 : 1];
    return {&light, selection_probability(light, from)};
  }
  [[nodiscard]] float selection_probability(const Light& light, const Point& from) const {
    return &light == &lights_[0] ? upper(from) : 1.0F - upper(from);
  }
  [[nodiscard]] std::array<const Light*, 0> infinite_lights() const { return {}; }
  [[nodiscard]] const Camera& camera() const { return inner_.camera(); }

 private:
  /// Between 0.05 and 0.95.
  [[nodiscard]] static float upper(const Point& from) {
    return 0.5F + 0.45F * std::sin(3.0F * from.position.x + 2.0F * from.position.y - 4.0F * from.geometric_normal.z);
  }
  Inner inner_;
  std::array<Light, 2> lights_{Light(1.0F), Light(-1.0F)};
};

static_assert(gmis::SceneWithReceiverChoice<SplitFurnace>);
static_assert(gmis::chooses_for_receiver<SplitFurnace>());
static_assert(!gmis::chooses_for_receiver<SplitFurnace::Inner>());

/// Means of pictures against the closed form of the furnace, by Student's t: one false alarm of all
/// comparisons together in a thousandth of the seeds. `bias`: what merging may be off by.
constexpr std::size_t comparisons = 24;

template <class I>
void check(double bias, gmis::RenderSettings settings = {}) {
  constexpr int iterations = 24;
  const double albedo = 0.7, level = gmis::sidak_level(1e-3, comparisons);
  const SplitFurnace scene(0.7F);
  settings.radius = 0.1;
  settings.seed = gmis_test::seed(31);
  for (const int depth : {2, 3, 6}) {
    settings.max_depth = depth;
    typename I::template Engine<SplitFurnace> engine(scene, I::settings(settings));
    const gmis_test::Mean mean = gmis_test::mean_of_iterations(engine, iterations);
    const double truth = (1.0 - std::pow(albedo, depth)) / (1.0 - albedo);
    const double error = mean.standard_error;
    CAPTURE(depth, mean.value, truth, error);
    CHECK(std::abs(mean.value - truth) <
          gmis::student_t_quantile(1.0 - level / 2.0, iterations - 1) * error + bias * truth + 1e-6);
    CHECK(error < 0.02 * truth);
    CHECK(engine.counters().rejected_non_finite + engine.counters().rejected_negative == 0);
  }
}

}  // namespace

TEST_CASE("one light cut in two, chosen for the receiver, makes the same picture") {
  using namespace gmis_test::ways;
  SECTION("pt") {
    check<Pt>(0.0);
  }
  SECTION("bpt") {
    check<Bpt>(0.0);
  }
  SECTION("vcm") {
    check<Vcm>(0.01);
  }
  SECTION("vcm_local") {
    gmis::RenderSettings settings;
    settings.counts.local_merges = true;
    check<Vcm>(0.01, settings);
  }
  for (const int connections : {2, 4}) SECTION("vcm, connections " + std::to_string(connections)) {
      gmis::RenderSettings settings;
      settings.counts.connections = connections;
      check<Vcm>(0.01, settings);
    }
  SECTION("trees that split") {
    check<Gmis>(0.01);
  }
}
