#include <algorithm>
#include <limits>
#include <vector>

#include "gmis/transport/engine/engine.hpp"
#include "gmis/transport/state/integrators.hpp"
#include "support/catch.hpp"
#include "support/seed.hpp"
#include "transport/furnace_scene.hpp"

// A BSDF with `evaluate_forward` and `sample_forward`: path tracing asks it for no reverse density,
// everything else for all.

namespace {

using Base = gmis_test::FurnaceScene<float>;

/// The furnace's BSDF. It counts which functions are called; reverse densities that were not asked
/// for are NaN.
class Bsdf {
 public:
  using Spectrum = float;
  static inline int whole = 0, forward = 0;

  explicit Bsdf(const Base::Bsdf& base) : base_(base) {}

  [[nodiscard]] gmis::BsdfValue<float> evaluate(const gmis::Vec3<float>& to_prev, const gmis::Vec3<float>& to_next,
                                                gmis::TransportMode mode) const {
    ++whole;
    return base_.evaluate(to_prev, to_next, mode);
  }
  [[nodiscard]] gmis::BsdfValue<float> evaluate_forward(const gmis::Vec3<float>& to_prev,
                                                        const gmis::Vec3<float>& to_next,
                                                        gmis::TransportMode mode) const {
    ++forward;
    auto value = base_.evaluate(to_prev, to_next, mode);
    value.pdf.reverse.value = std::numeric_limits<float>::quiet_NaN();
    return value;
  }
  [[nodiscard]] std::optional<gmis::ScatterSample<float>> sample(const gmis::Vec3<float>& to_prev, float u,
                                                                 const gmis::Vec2<float>& uv,
                                                                 gmis::TransportMode mode) const {
    ++whole;
    return base_.sample(to_prev, u, uv, mode);
  }
  [[nodiscard]] std::optional<gmis::ScatterSample<float>> sample_forward(const gmis::Vec3<float>& to_prev, float u,
                                                                         const gmis::Vec2<float>& uv,
                                                                         gmis::TransportMode mode) const {
    ++forward;
    auto sample = base_.sample(to_prev, u, uv, mode);
    if (sample) sample->pdf.reverse.value = std::numeric_limits<float>::quiet_NaN();
    return sample;
  }
  [[nodiscard]] bool is_purely_delta() const { return false; }
  [[nodiscard]] float albedo() const { return base_.albedo(); }

 private:
  Base::Bsdf base_;
};
static_assert(gmis::Bsdf<Bsdf>);

class Scene {
 public:
  using Spectrum = float;
  using Bsdf = ::Bsdf;
  using Light = Base::Light;
  using Camera = Base::Camera;

  [[nodiscard]] std::optional<gmis::Hit<float, Bsdf, Light>> intersect(const gmis::Ray<float>& ray) const {
    const auto hit = base_.intersect(ray);
    if (!hit) return std::nullopt;
    return gmis::Hit<float, Bsdf, Light>{hit->point, Bsdf(hit->bsdf), hit->light};
  }
  [[nodiscard]] bool visible(const gmis::Ray<float>& ray) const { return base_.visible(ray); }
  [[nodiscard]] gmis::LightChoice<float, Light> sample_light(float u) const { return base_.sample_light(u); }
  [[nodiscard]] float selection_probability(const Light& light) const { return base_.selection_probability(light); }
  [[nodiscard]] std::array<const Light*, 0> infinite_lights() const { return {}; }
  [[nodiscard]] const Camera& camera() const { return base_.camera(); }

 private:
  Base base_{0.7F, 1.0F, 8};
};
static_assert(gmis::Scene<Scene>);

template <class Engine, class S>
std::vector<float> picture(const S& scene, const gmis::SampleCounts& counts) {
  gmis::RenderSettings settings;
  settings.counts = counts;
  settings.max_depth = 5;
  settings.radius = 0.1;
  settings.seed = gmis_test::seed(51);
  Engine engine(scene, settings);
  gmis::SerialExecutor executor;
  engine.iterate(executor);
  return {engine.frame().begin(), engine.frame().end()};
}

}  // namespace

TEST_CASE("path tracing asks a BSDF for no reverse densities, where it offers to leave them out") {
  const Scene scene;
  const Base base(0.7F, 1.0F, 8);
  Bsdf::whole = Bsdf::forward = 0;
  const auto forward = picture<gmis::PathTracer<Scene>>(scene, gmis::integrators::pt);
  CHECK(Bsdf::whole == 0);
  CHECK(Bsdf::forward > 100);
  CHECK(forward == picture<gmis::PathTracer<Base>>(base, gmis::integrators::pt));

  Bsdf::whole = Bsdf::forward = 0;
  const auto both = picture<gmis::Engine<Scene>>(scene, gmis::integrators::bpt);
  CHECK(Bsdf::forward == 0);
  CHECK(Bsdf::whole > 100);
  CHECK(std::all_of(both.begin(), both.end(), [](float value) { return value > 0.0F && value < 100.0F; }));
}
