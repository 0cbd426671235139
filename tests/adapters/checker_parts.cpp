// The statistics of the adapter checks, against quadrature and against samplers whose density is
// known.
#include <cmath>
#include <optional>
#include <vector>

#include "gmis/check/check_scene.hpp"
#include "gmis/check/check_surface.hpp"
#include "gmis/check/density_test.hpp"
#include "gmis/check/findings.hpp"
#include "gmis/check/scatter_statistics.hpp"
#include "support/catch.hpp"
#include "support/message_of.hpp"
#include "support/seed.hpp"
#include "transport/furnace_scene.hpp"

using namespace gmis;
using V = Vec3<double>;

namespace {

/// GGX half vectors of roughness alpha around z, mirrored directions for light from `to_prev`, by
/// their definition [Walter et al. 2007, eq. 33, 35]. The stated density is `factor` times the true
/// one.
struct RoughMirror {
  using Spectrum = double;
  double alpha = 0.04, factor = 1, weight_factor = 1;
  bool misses_a_side = false;

  [[nodiscard]] double density(const V& to_prev, const V& to_next) const {
    if (to_next.z <= 0) return 0;
    const V half = glm::normalize(to_prev + to_next);
    const double cos2 = half.z * half.z, a2 = alpha * alpha;
    const double slope = (1 - cos2) / cos2;
    const double d = 1 / (pi<double> * a2 * cos2 * cos2 * (1 + slope / a2) * (1 + slope / a2));
    return d * half.z / (4 * std::abs(glm::dot(half, to_prev)));
  }
  /// f |cos| is the true density: the surface reflects all that is not lost below the horizon.
  [[nodiscard]] BsdfValue<double> evaluate(const V& to_prev, const V& to_next, TransportMode) const {
    const double p = density(to_prev, to_next);
    if (!(p > 0)) return {};
    return {p / to_next.z, {{factor * p}, {factor * density(to_next, to_prev)}}};
  }
  [[nodiscard]] std::optional<ScatterSample<double>> sample(const V& to_prev, double, const Vec2<double>& uv,
                                                            TransportMode mode) const {
    const double tan = alpha * std::sqrt(uv.x / (1 - uv.x)), cosine = 1 / std::sqrt(1 + tan * tan);
    const V half(cosine * tan * std::cos(2 * pi<double> * uv.y), cosine * tan * std::sin(2 * pi<double> * uv.y),
                 cosine);
    const V to_next = reflect_about(to_prev, half);
    const auto f = evaluate(to_prev, to_next, mode);
    if (!(f.pdf.forward.value > 0) || (misses_a_side && to_next.y < 0)) return std::nullopt;
    return ScatterSample<double>{to_next, weight_factor * f.value * to_next.z / f.pdf.forward.value, f.pdf};
  }
  [[nodiscard]] bool is_purely_delta() const { return false; }
  [[nodiscard]] double albedo() const { return 1; }
};
static_assert(Bsdf<RoughMirror>);

/// A diffuse surface, of whose albedo the compact form keeps a share.
class Compacted {
 public:
  using Spectrum = double;
  struct Compact {
    using Whole = Compacted;
    double albedo;
  };
  explicit Compacted(double kept_share) : kept_share_(kept_share) {}
  Compacted(const Compact& kept, const SurfacePoint<double>&) : albedo_(kept.albedo) {}

  [[nodiscard]] BsdfValue<double> evaluate(const V& to_prev, const V& to_next, TransportMode) const {
    if (to_prev.z <= 0 || to_next.z <= 0) return {};
    return {albedo_ / pi<double>, {{to_next.z / pi<double>}, {to_prev.z / pi<double>}}};
  }
  [[nodiscard]] std::optional<ScatterSample<double>> sample(const V& to_prev, double, const Vec2<double>& uv,
                                                            TransportMode mode) const {
    const V to_next = square_to_cosine_hemisphere(uv);
    const auto f = evaluate(to_prev, to_next, mode);
    if (!(f.pdf.forward.value > 0)) return std::nullopt;
    return ScatterSample<double>{to_next, albedo_, f.pdf};
  }
  [[nodiscard]] bool is_purely_delta() const { return false; }
  [[nodiscard]] double albedo() const { return albedo_; }
  [[nodiscard]] Compact compact() const { return {kept_share_ * albedo_}; }

 private:
  double albedo_ = 0.8, kept_share_ = 1;
};
static_assert(BsdfWithCompactForm<Compacted>);

Findings statistics_of(const RoughMirror& bsdf, double cosine, std::uint64_t seed) {
  Philox source(gmis_test::seed(seed));
  detail::ScatterStatistics<double> statistics;
  const V to_prev(std::sqrt(1 - cosine * cosine), 0, cosine);
  statistics.draw(bsdf, V(0, 0, 1), to_prev, TransportMode::importance, 8192, source);
  Findings findings;
  statistics.judge(findings, 1e-7);
  return findings;
}

}  // namespace

TEST_CASE("the scale of the density of a narrow lobe is seen at every angle") {
  std::uint64_t seed = 1;
  for (const double alpha : {0.003, 0.01, 0.04, 0.12, 0.5})
    for (const double cosine : {0.95, 0.6, 0.3}) {
      INFO("alpha " << alpha << ", cosine " << cosine);
      CHECK(statistics_of({alpha, 1}, cosine, seed++).text() == "");
      for (const double factor : {0.43, 0.6, 1.7, 2.7})
        CHECK(statistics_of({alpha, factor}, cosine, seed++).is_broken(Convention::bsdf_distribution));
    }
}

TEST_CASE("the mean weight of a lobe with a tail is judged at every width and angle") {
  std::uint64_t seed = 200;
  for (const double alpha : {1e-4, 1e-3, 0.01, 0.1})
    for (const double cosine : {0.95, 0.3}) {
      INFO("alpha " << alpha << ", cosine " << cosine);
      // The tail beyond what 24 caps hold has another share of the light with each seed.
      for (int i = 0; i < 10; ++i) CHECK(statistics_of({alpha}, cosine, seed++).text() == "");
      for (const double factor : {0.8, 1.2})
        CHECK(statistics_of({alpha, 1, factor}, cosine, seed++).is_broken(Convention::bsdf_mean_weight));
      if (cosine < 0.5)  // aslant all caps reach over to the side without samples
        CHECK(statistics_of({alpha, 1, 1, true}, cosine, seed++).is_broken(Convention::bsdf_mean_weight));
    }
}

TEST_CASE("a compact form that stands for another BSDF is named") {
  const SurfacePoint<double> point{V(0, 0, 0), V(0, 0, 1), V(0, 0, 1)};
  for (const double kept_share : {1.0, 0.9}) {
    const auto bsdf_for = [&](const V&) { return std::optional(Compacted(kept_share)); };
    Philox source(gmis_test::seed(600));
    Findings findings;
    SurfaceCheck<decltype(bsdf_for), double, Philox>(bsdf_for, point, glm::normalize(V(0.3, 0.2, 0.7)), source,
                                                     findings)
        .run(16);
    CHECK(findings.tried(Convention::bsdf_compact) > 30);
    if (kept_share == 1.0) {
      CHECK(findings.text() == "");
      continue;
    }
    REQUIRE(findings.broken().size() == 1);
    CHECK(findings.broken().front().convention == Convention::bsdf_compact);
  }
}

namespace {
/// Scatters uniformly over the hemisphere with the density p = 1/2π, which is symmetric: f is
/// .7 p / |cos| of the direction that light arrives from in the mode of the call. With `as_delta`
/// it calls that a delta lobe.
struct Fuzz {
  using Spectrum = double;
  bool as_delta;
  static constexpr double density = 1 / (2 * pi<double>);
  [[nodiscard]] BsdfValue<double> evaluate(const V& to_prev, const V& to_next, TransportMode mode) const {
    if (as_delta || to_prev.z <= 0 || to_next.z <= 0) return {};
    return {0.7 * density / (mode == TransportMode::radiance ? to_next : to_prev).z, {{density}, {density}}};
  }
  [[nodiscard]] std::optional<ScatterSample<double>> sample(const V& to_prev, double, const Vec2<double>& uv,
                                                            TransportMode mode) const {
    const double sine = std::sqrt(1 - uv.x * uv.x), turn = 2 * pi<double> * uv.y;
    const V to_next(sine * std::cos(turn), sine * std::sin(turn), uv.x);
    if (as_delta) return ScatterSample<double>{to_next, 0.7, {{1.0}, {1.0}}, true, 1.0};
    const double weight = mode == TransportMode::radiance ? 0.7 : 0.7 * to_next.z / to_prev.z;
    return ScatterSample<double>{to_next, weight, {{density}, {density}}, false, 1.0};
  }
  [[nodiscard]] bool is_purely_delta() const { return as_delta; }
  [[nodiscard]] double albedo() const { return 0.7; }
};
}  // namespace

TEST_CASE("a sound lobe whose modes differ by cosines passes; called a delta lobe, it is named") {
  const SurfacePoint<double> point{V(0, 0, 0), V(0, 0, 1), V(0, 0, 1)};
  for (const bool as_delta : {false, true}) {
    const auto bsdf_for = [&](const V&) { return std::optional(Fuzz{as_delta}); };
    Philox source(gmis_test::seed(610));
    Findings findings;
    const V to_prev = glm::normalize(V(0.3, 0.2, 0.7));
    for (int i = 0; i < 8; ++i)
      SurfaceCheck<decltype(bsdf_for), double, Philox>(bsdf_for, point, to_prev, source, findings).run(16);
    CHECK(findings.tried(Convention::bsdf_cosine) + findings.tried(Convention::bsdf_delta) > 100);
    CHECK(findings.is_broken(Convention::bsdf_delta) == as_delta);
    if (!as_delta) CHECK(findings.text() == "");
  }
}

namespace {
/// Two delta lobes, mirrored and straight through, of which the first is made with probability
/// `chosen` and states `stated`.
struct Pane {
  using Spectrum = double;
  double chosen, stated;
  [[nodiscard]] BsdfValue<double> evaluate(const V&, const V&, TransportMode) const { return {}; }
  [[nodiscard]] std::optional<ScatterSample<double>> sample(const V& to_prev, double u, const Vec2<double>&,
                                                            TransportMode) const {
    const bool is_mirrored = u < chosen;
    const double stated_here = is_mirrored ? stated : 1 - chosen;
    return ScatterSample<double>{
        is_mirrored ? reflect_about(to_prev, V(0, 0, 1)) : -to_prev, 1.0, {{stated_here}, {stated_here}}, true, 1.0};
  }
  [[nodiscard]] bool is_purely_delta() const { return true; }
  [[nodiscard]] double albedo() const { return 1; }
};
static_assert(Bsdf<Pane>);
}  // namespace

TEST_CASE("a delta lobe that is made more or less often than it states is named") {
  std::uint64_t seed = 700;
  for (const double chosen : {0.1, 0.3, 0.5, 0.9, 1.0})
    for (const double factor : {1.0, 0.5, 0.8, 1.25, 2.0}) {
      INFO("chosen with " << chosen << ", states " << factor << " of it");
      Philox source(gmis_test::seed(seed++));
      detail::ScatterStatistics<double> here, all;
      here.draw(Pane{chosen, factor * chosen}, V(0, 0, 1), V(0.6, 0, 0.8), TransportMode::importance, 20'000, source);
      all.add(here);
      Findings findings, of_all;
      here.judge(findings, 1e-7);
      all.judge(of_all, 1e-7);
      CHECK(findings.is_broken(Convention::bsdf_delta_frequency) == (factor != 1.0));
      if (factor == 1.0) CHECK(findings.text() == "");
      // Lobes of different points have different directions.
      CHECK(of_all.tried(Convention::bsdf_delta_frequency) == 0);
    }
}

namespace {
/// Diffuse around the shading normal z. Where it does not leak, it scatters nothing between
/// directions that the geometric normal puts on another side.
struct Tilted {
  using Spectrum = double;
  V geometric;
  bool evaluate_leaks, sample_leaks;
  [[nodiscard]] bool is_lost(const V& a, const V& b) const {
    return a.z * glm::dot(geometric, a) <= 0 || b.z * glm::dot(geometric, b) <= 0;
  }
  [[nodiscard]] BsdfValue<double> evaluate(const V& to_prev, const V& to_next, TransportMode) const {
    if (to_prev.z * to_next.z <= 0 || (!evaluate_leaks && is_lost(to_prev, to_next))) return {};
    return {0.8 / pi<double>, {{std::abs(to_next.z) / pi<double>}, {std::abs(to_prev.z) / pi<double>}}};
  }
  [[nodiscard]] std::optional<ScatterSample<double>> sample(const V& to_prev, double, const Vec2<double>& uv,
                                                            TransportMode) const {
    const V to_next = std::copysign(1.0, to_prev.z) * square_to_cosine_hemisphere(uv);
    if (!sample_leaks && is_lost(to_prev, to_next)) return std::nullopt;
    return ScatterSample<double>{
        to_next, 0.8, {{std::abs(to_next.z) / pi<double>}, {std::abs(to_prev.z) / pi<double>}}};
  }
  [[nodiscard]] bool is_purely_delta() const { return false; }
  [[nodiscard]] double albedo() const { return 0.8; }
};
static_assert(Bsdf<Tilted>);
}  // namespace

TEST_CASE("light that leaks between the planes of two normals is named") {
  std::uint64_t seed = 800;
  for (const double tilt : {0.0, 0.05, 0.4})
    for (const bool evaluate_leaks : {false, true})
      for (const bool sample_leaks : {false, true})
        for (const V& from : {V(0.3, 0.2, 0.7), V(0.3, 0.2, -0.7), V(1, 0, 0.2), V(-1, 0, 0.2)}) {
          const V geometric(std::sin(tilt), 0, std::cos(tilt)), to_prev = glm::normalize(from);
          INFO("tilt " << tilt << ", evaluate " << evaluate_leaks << ", sample " << sample_leaks << ", from " << from.x
                       << " " << from.z);
          const SurfacePoint<double> point{V(0, 0, 0), geometric, V(0, 0, 1)};
          const auto bsdf_for = [&](const V&) {
            return std::optional(Tilted{geometric, evaluate_leaks, sample_leaks});
          };
          Philox source(gmis_test::seed(seed++));
          Findings findings;
          SurfaceCheck<decltype(bsdf_for), double, Philox> check(bsdf_for, point, to_prev, source, findings);
          for (int i = 0; i < 32; ++i) check.run(16);
          const bool prev_is_lost = to_prev.z * glm::dot(geometric, to_prev) < 0;
          const bool leaks = tilt > 0 && (prev_is_lost ? sample_leaks : evaluate_leaks || sample_leaks);
          // With the small tilt one sample in a thousand lies between the planes.
          if (tilt != 0.05 || evaluate_leaks || !sample_leaks)
            CHECK(findings.is_broken(Convention::bsdf_leak) == leaks);
          if (!evaluate_leaks && !sample_leaks) CHECK(findings.text() == "");
        }
}

TEST_CASE("a mixture of caps integrates to one and draws what it states") {
  Philox source(gmis_test::seed(400));
  std::vector<V> draws;
  for (int i = 0; i < 400; ++i) {
    const double u = uniform<double>(source);
    const V local = square_to_cone(Vec2<double>(u, uniform<double>(source)), 0.02);
    draws.push_back(glm::normalize(V(local.z, local.x, local.y)));
  }
  const detail::CapMixture mixture(draws, 1e-5, source);
  // The midpoint rule over 4 million cells: caps have sharp borders, each of which a row of cells
  // crosses.
  constexpr int rows = 2000, columns = 2000;
  double sum = 0;
  for (int i = 0; i < rows; ++i)
    for (int j = 0; j < columns; ++j) {
      const double x = 1 - 2 * (i + 0.5) / rows, turn = 2 * pi<double> * (j + 0.5) / columns, r = std::sqrt(1 - x * x);
      sum += mixture.density({x, r * std::cos(turn), r * std::sin(turn)});
    }
  CHECK(sum * 4 * pi<double> / (double{rows} * columns) == Approx(1).epsilon(0.01));
  // The share of draws inside the cone that holds all of `draws` has a binomial error.
  const double in_cone = [&] {
    double inside = 0;
    for (int i = 0; i < rows; ++i)
      for (int j = 0; j < columns; ++j) {
        const double x = 1 - 0.02 * (i + 0.5) / rows, turn = 2 * pi<double> * (j + 0.5) / columns;
        const double r = std::sqrt(1 - x * x);
        inside += mixture.density({x, r * std::cos(turn), r * std::sin(turn)});
      }
    return inside * 0.02 * 2 * pi<double> / (double{rows} * columns);
  }();
  constexpr int count = 100'000;
  int inside = 0;
  for (int i = 0; i < count; ++i)
    if (mixture.draw(source).x > 0.98) ++inside;
  const double share = static_cast<double>(inside) / count;
  CHECK(std::abs(share - in_cone) < 5 * std::sqrt(in_cone * (1 - in_cone) / count) + 1e-3);  // 1e-6, and the quadrature
}

TEST_CASE("a fault in one group or in one place is not lost among many cases") {
  // One group of three has 10 broken cases of 40 among 10,000.
  Findings findings;
  for (int i = 0; i < 10'000; ++i) {
    findings.look_at(1 + static_cast<std::size_t>(i % 2), {V(i, 0, 0)});
    findings.count(Convention::bsdf_weight, true);
  }
  CHECK(findings.passes());
  Findings in_a_group = findings;
  for (int i = 0; i < 40; ++i) {
    in_a_group.look_at(3, {V(i * 250.0, 1, 0), V(0, 0, 1), V(0, 1, 0)});
    in_a_group.count(Convention::bsdf_weight, i % 4 != 0, 0.5, 0.25);
  }
  REQUIRE(in_a_group.broken().size() == 1);
  CHECK(in_a_group.text().find("[10 of 10040 cases]\n") != std::string::npos);
  CHECK(in_a_group.text().find(
            "for example at (0, 1, 0), to_prev (0, 0, 1), to_next (0, 1, 0): 0.5 in place of 0.25\n") !=
        std::string::npos);
  // Twelve broken cases of a group of 5,000: side by side they are a small object, all over the
  // place they are rounding.
  Findings together = findings, scattered = findings;
  for (int i = 0; i < 12; ++i) {
    together.look_at(1, {V(5000, 0.01 * i, 3)});
    together.count(Convention::bsdf_weight, false);
    scattered.look_at(1, {V(800.5 * i, 0.01, 0)});
    scattered.count(Convention::bsdf_weight, false);
  }
  CHECK_FALSE(together.passes());
  CHECK(scattered.passes());
}

TEST_CASE("findings come with causes first") {
  Findings findings;
  findings.judge(Convention::bsdf_energy, false);
  findings.judge(Convention::bsdf_weight, false);
  findings.judge(Convention::bsdf_distribution, false, 0.5, 1.0);
  const auto broken = findings.broken();
  REQUIRE(broken.size() == 3);
  CHECK(broken[0].convention == Convention::bsdf_distribution);
  CHECK(broken[1].convention == Convention::bsdf_weight);
  CHECK(broken[2].convention == Convention::bsdf_energy);
}

TEST_CASE("a surface that absorbs everything may state any density and make no sample") {
  struct Black {
    using Spectrum = double;
    [[nodiscard]] BsdfValue<double> evaluate(const V&, const V& to_next, TransportMode) const {
      return {0.0, {{std::max(0.0, to_next.z) / pi<double>}, {0.1}}};
    }
    [[nodiscard]] std::optional<ScatterSample<double>> sample(const V&, double, const Vec2<double>&,
                                                              TransportMode) const {
      return std::nullopt;
    }
    [[nodiscard]] bool is_purely_delta() const { return false; }
    [[nodiscard]] double albedo() const { return 0; }
  };
  Philox source(gmis_test::seed(500));
  detail::ScatterStatistics<double> statistics;
  statistics.draw(Black(), V(0, 0, 1), V(0, 0.6, 0.8), TransportMode::importance, 8192, source);
  Findings findings;
  statistics.judge(findings, 1e-7);
  statistics.judge_albedo(findings);
  CHECK(findings.text() == "");
}

TEST_CASE("settings of check_scene that test nothing are refused; few samples are enough to run") {
  const gmis_test::FurnaceScene<double> scene(0.5, 2.0, 16, 1);
  const auto refusal = [&](const SceneCheckSettings& settings) {
    return gmis_test::message_of([&] { return check_scene(scene, settings); });
  };
  CHECK(refusal({.samples = 0}) == "SceneCheckSettings::samples is 0: set it to 1 at least");
  CHECK(refusal({.receivers = 0}) == "SceneCheckSettings::receivers is 0: set it to 1 at least");
  for (const double level : {0.0, 1.0, -1e-6, std::nan("")})
    CHECK(refusal({.level = level}) == "SceneCheckSettings::level is a false-alarm rate: set it between 0 and 1");
  for (const std::size_t samples : {1U, 512U, 1023U}) {
    CAPTURE(samples);
    CHECK(check_scene(scene, {.seed = gmis_test::seed(620), .samples = samples}).text() == "");
  }
}
