#include <algorithm>
#include <complex>
#include <cstdio>
#include <limits>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "gmis/core/density_tests.hpp"
#include "gmis/scene/bsdf.hpp"
#include "support/catch.hpp"
#include "support/seed.hpp"

// Materials at the ends of their ranges, from steep to grazing, with random numbers that are 0 or
// nearly 1. A sample is finite, of unit length, on the side it says, and its weight is f |cos| /
// density; what `evaluate` says of it in double is the oracle in float. Densities integrate to the
// chance that a sample succeeds: by a rule of our own, made for lobes down to a thousandth of a
// radian. Energy is that of many samples.

using namespace gmis;
using namespace gmis::scene;

namespace {

template <std::floating_point T>
using Named = std::pair<std::string, Material<T>>;

template <std::floating_point T>
std::vector<Named<T>> reflecting_materials() {
  std::vector<Named<T>> result;
  const auto add = [&](const std::string& name, const Material<T>& m) { result.emplace_back(name, m); };
  for (const double albedo : {1e-30, 0.5, 1.0})
    add("diffuse " + std::to_string(albedo), make_diffuse<T>({albedo, albedo, albedo}));
  for (const double n : {1.0, 100.0, 1e4, 1e6}) {
    add("phong " + std::to_string(n), make_phong<T>({0.3, 0.3, 0.3}, {0.6, 0.6, 0.6}, n));
    add("phong alone " + std::to_string(n), make_phong<T>({0, 0, 0}, {1, 1, 1}, n));
  }
  for (const double alpha : {1e-3, 0.003, 0.03, 0.3, 1.0}) {
    const std::string with = " alpha " + std::to_string(alpha);
    add("metal" + with, make_conductor<T>({0.2, 0.9, 1.1}, {3.9, 2.4, 2.2}, alpha));
    add("perfect metal, separable" + with, make_conductor<T>({0, 0, 0}, {1e6, 1e6, 1e6}, alpha, Masking::separable));
    add("coat" + with, make_coated_diffuse<T>({0.8, 0.8, 0.8}, 1.5, alpha));
    add("thin coat" + with, make_coated_diffuse<T>({1, 1, 1}, 1.0001, alpha));
    add("thick coat over black" + with, make_coated_diffuse<T>({0, 0, 0}, 3, alpha));
  }
  return result;
}

template <std::floating_point T>
std::vector<Named<T>> glasses() {
  std::vector<Named<T>> result;
  for (const double eta : {0.5, 1.0, 1.0001, 1.5, 3.0})
    for (const double alpha : {0.0, 1e-4, 1e-3, 0.03, 0.3, 1.0})
      result.emplace_back("glass " + std::to_string(eta) + " alpha " + std::to_string(alpha),
                          make_dielectric<T>(eta, alpha));
  result.emplace_back("mirror", make_mirror<T>({1, 1, 1}));
  result.emplace_back("black mirror", make_mirror<T>({0, 0, 0}));
  result.emplace_back("black", make_diffuse<T>({0, 0, 0}));
  result.emplace_back("smooth metal", make_conductor<T>({0.2, 0.9, 1.1}, {3.9, 2.4, 2.2}, 1e-4));
  result.emplace_back("smooth coat", make_coated_diffuse<T>({0.8, 0.8, 0.8}, 1.5, 1e-4));
  return result;
}

/// Thin sheets, and metals under coats.
template <std::floating_point T>
std::vector<Named<T>> layers() {
  std::vector<Named<T>> result;
  for (const double reflectance : {0.0, 1e-30, 0.5})
    for (const double transmittance : {1e-30, 0.5, 1.0})
      result.emplace_back(
          "sheet " + std::to_string(result.size()),
          make_diffuse_transmission<T>(Vec3<double>(reflectance * (1 - transmittance)), Vec3<double>(transmittance)));
  for (const double alpha : {0.0, 1e-3, 0.03, 1.0})
    for (const double coat : {0.0, 1e-3, 0.3, 1.0})
      for (const double eta : {1.0001, 1.5, 3.0})
        result.emplace_back(
            "metal " + std::to_string(alpha) + " under " + std::to_string(coat) + " of " + std::to_string(eta),
            make_coated_conductor<T>({0.2, 0.9, 1.1}, {3.9, 2.4, 2.2}, alpha, eta, coat));
  return result;
}

/// In [0, 1), often at or near an end.
template <std::floating_point T>
T hard_uniform(Philox& source) {
  const T u = uniform<T>(source);
  const auto kind = static_cast<int>(uniform<double>(source) * 8);
  if (kind == 0) return T(0);
  if (kind == 1) return T(1) - std::numeric_limits<T>::epsilon() / T(2);
  if (kind == 2) return u * T(1e-6);
  if (kind == 3) return std::min(T(1) - u * T(1e-6), T(1) - std::numeric_limits<T>::epsilon() / T(2));
  return u;
}

/// At this cosine from +z, anywhere around it.
template <std::floating_point T>
Vec3<T> at_cosine(T cosine, T turn) {
  const T sine = std::sqrt(T(1) - cosine * cosine);
  return {sine * std::cos(turn), sine * std::sin(turn), cosine};
}

/// 10^-x, x up to 6; and 1 itself.
template <std::floating_point T>
T hard_cosine(Philox& source) {
  const T x = uniform<T>(source);
  return x < T(0.05) ? T(1) : std::pow(T(10), T(-6) * x * uniform<T>(source));
}

/// How many rounding errors a density or a value may be off, for one in each of the two directions:
/// what the half vector magnifies where it nearly vanishes, and then the lobe's width, a facet seen
/// edge-on, and Fresnel's reflectance, which is vertical where total reflection begins.
template <std::floating_point T>
double condition(const Material<T>& material, const Vec3<T>& a, const Vec3<T>& b) {
  if (material.kind == Material<T>::Kind::phong) return static_cast<double>(material.exponent) + 1;
  double width = 1;
  for (const T alpha : {material.alpha, material.base_alpha})
    if (alpha > T(0)) width = std::min(width, static_cast<double>(alpha));
  const bool reflects = a.z * b.z > T(0);
  const double other_side = static_cast<double>(a.z > T(0) ? material.eta : T(1) / material.eta);
  const double eta = reflects ? 1 : other_side;
  const glm::dvec3 one = glm::normalize(glm::dvec3(a)), other = glm::normalize(glm::dvec3(b)), sum = one + eta * other;
  const double length = glm::length(sum);
  const double facet = std::min(std::abs(glm::dot(sum, one)), std::abs(glm::dot(sum, other))) / length;
  double slope = 1 / width + 1 / (facet * facet);
  if (reflects && other_side < 1) {
    const double transmitted = std::sqrt(std::abs(1 - (1 - facet * facet) / (other_side * other_side)));
    const double least = std::sqrt(static_cast<double>(std::numeric_limits<T>::epsilon()));
    slope += facet / (other_side * other_side * std::max(transmitted, least));
  }
  return 1 + (1 + eta) / length * slope;
}

template <std::floating_point T>
void check_samples(const std::vector<Named<T>>& materials, int count) {
  const auto wide = [] {
    auto all = reflecting_materials<double>();
    for (auto& glass : glasses<double>()) all.push_back(std::move(glass));
    for (auto& layer : layers<double>()) all.push_back(std::move(layer));
    return all;
  }();
  Philox source(gmis_test::seed(521));
  std::uint64_t drawn = 0;
  double worst_weight = 0, worst_density = 0;
  for (const auto& [name, material] : materials) {
    // The same in double.
    const auto oracle =
        std::find_if(wide.begin(), wide.end(), [&wanted = name](const auto& m) { return m.first == wanted; });
    REQUIRE(oracle != wide.end());
    for (int i = 0; i < count; ++i) {
      const Vec3<T> normal(0, 0, 1);
      const SurfaceBsdf<T> bsdf(material, normal, normal);
      const T side = i % 2 == 0 ? T(1) : T(-1);
      const T turn = T(6.28) * uniform<T>(source);
      const Vec3<T> to_prev = at_cosine(side * hard_cosine<T>(source), turn);
      const TransportMode mode = i % 4 < 2 ? TransportMode::radiance : TransportMode::importance;
      const T u = hard_uniform<T>(source);
      const Vec2<T> uv(hard_uniform<T>(source), hard_uniform<T>(source));
      const auto sample = bsdf.sample(to_prev, u, uv, mode);
      if (!sample) continue;
      ++drawn;
      // Only where it is needed: there are many samples.
      const auto where = [&, &of = name] {
        std::ostringstream text;
        text << of << ", cos " << to_prev.z << ", u " << u << ", uv " << uv.x << ' ' << uv.y << ": ";
        return text.str();
      };
      for (int c = 0; c < 3; ++c)
        if (!(std::isfinite(sample->weight[c]) && sample->weight[c] >= T(0)))
          FAIL(where() << "weight " << sample->weight[c]);
      if (!(std::abs(glm::length(sample->to_next) - T(1)) < T(2e-6)))
        FAIL(where() << "length " << glm::length(sample->to_next));
      const T forward = sample->pdf.forward.value, reverse = sample->pdf.reverse.value;
      if (!(std::isfinite(forward) && forward > T(0) && std::isfinite(reverse) && reverse >= T(0)))
        FAIL(where() << "densities " << forward << ", " << reverse);
      if (sample->is_delta) {
        if (!(forward <= T(1) && reverse <= T(1))) FAIL(where() << "chances " << forward << ", " << reverse);
        continue;
      }
      // What the sampler says is what evaluate says, and that is what it says in double.
      const auto value = bsdf.evaluate(to_prev, sample->to_next, mode);
      const T weight = value.value.x * std::abs(sample->to_next.z);
      if (!(std::abs(weight - sample->weight.x * forward) <= T(1e-4) * weight))
        FAIL(where() << "weight against f " << weight);
      if (!(value.pdf.forward.value == forward))
        FAIL(where() << "density " << forward << " against " << value.pdf.forward.value);
      // No single sample carries more than a few times the light: densities are those of the lobes
      // that f has.
      const T scale = mode == TransportMode::importance || sample->eta == T(1) ? T(1) : sample->eta * sample->eta;
      worst_weight = std::max(worst_weight, static_cast<double>(sample->weight.x * scale));
      // Facets seen edge-on, at the rim of the square of `uv`, leave as little.
      if (uv.x > T(0.99)) continue;
      // Phong's lobe ends at 90° from the mirror direction, where a rounding error is all that is
      // left of its density.
      const Vec3<T> mirrored(-to_prev.x, -to_prev.y, to_prev.z);
      if (material.kind == Material<T>::Kind::phong && glm::dot(mirrored, sample->to_next) < T(0.05)) continue;
      const auto exact =
          SurfaceBsdf<double>(oracle->second, {0, 0, 1}, {0, 0, 1})
              .evaluate(glm::normalize(glm::dvec3(to_prev)), glm::normalize(glm::dvec3(sample->to_next)), mode);
      const double error = std::abs(static_cast<double>(forward) / exact.pdf.forward.value - 1);
      const double roundings = error / (static_cast<double>(std::numeric_limits<T>::epsilon()) *
                                        condition(material, to_prev, sample->to_next));
      worst_density = std::max(worst_density, roundings);
      if (!(roundings < 100)) FAIL(where() << "density off by " << error << ", " << roundings << " roundings");
    }
  }
  std::printf("%s: %zu materials, %llu samples, largest weight %.3g, densities off by %.3g roundings\n",
              sizeof(T) == 4 ? "float" : "double", materials.size(), static_cast<unsigned long long>(drawn),
              worst_weight, worst_density);
  CHECK(drawn > 100U * materials.size());
  CHECK(worst_weight < 10.5);
}

TEMPLATE_TEST_CASE("hostile: samples of materials at the ends of their ranges", "[hostile][materials]", float, double) {
  check_samples<TestType>(reflecting_materials<TestType>(), 1500);
  check_samples<TestType>(glasses<TestType>(), 1500);
  check_samples<TestType>(layers<TestType>(), 1500);
}

TEMPLATE_TEST_CASE("hostile: values for any two directions are finite, reciprocal and reversed", "[hostile][materials]",
                   float, double) {
  using T = TestType;
  Philox source(gmis_test::seed(522));
  auto materials = reflecting_materials<T>();
  for (auto& glass : glasses<T>()) materials.push_back(std::move(glass));
  for (auto& layer : layers<T>()) materials.push_back(std::move(layer));
  double worst = 0;
  for (const auto& [name, material] : materials) {
    const Vec3<T> normal(0, 0, 1);
    const SurfaceBsdf<T> bsdf(material, normal, normal);
    for (int i = 0; i < 1000; ++i) {
      const auto random_direction = [&] {
        const T side = uniform<T>(source) < T(0.5) ? T(1) : T(-1);
        return at_cosine(side * hard_cosine<T>(source), T(6.28) * uniform<T>(source));
      };
      const Vec3<T> a = random_direction();
      // Anywhere, or the mirror direction and near it.
      Vec3<T> b = random_direction();
      if (i % 3 == 0) b = Vec3<T>(-a.x, -a.y, a.z);
      if (i % 3 == 1) b = glm::normalize(Vec3<T>(-a.x, -a.y, a.z) + b * std::pow(T(10), T(-6) * uniform<T>(source)));
      const auto there = bsdf.evaluate(a, b, TransportMode::radiance);
      const auto back = bsdf.evaluate(b, a, TransportMode::importance);
      for (const T x : {there.value.x, there.value.y, there.value.z, there.pdf.forward.value, there.pdf.reverse.value,
                        back.value.x, back.pdf.forward.value})
        if (!(std::isfinite(x) && x >= T(0))) FAIL(name << ": value " << x << " for cosines " << a.z << " and " << b.z);
      const auto differ = [](T x, T y) {
        const T larger = std::max(x, y);
        // Where there is next to nothing, relative to what there is next to nothing.
        return static_cast<double>(std::abs(x - y) / std::max(larger, T(1e-3)));
      };
      const double difference =
          std::max({differ(there.value.x, back.value.x), differ(there.pdf.forward.value, back.pdf.reverse.value),
                    differ(there.pdf.reverse.value, back.pdf.forward.value)});
      // Half vectors of the two ways differ by their rounding.
      if (difference > 0)
        worst = std::max(
            worst, difference / (static_cast<double>(std::numeric_limits<T>::epsilon()) * condition(material, a, b)));
    }
  }
  std::printf("%s: reciprocal but for %.2g roundings\n", sizeof(T) == 4 ? "float" : "double", worst);
  CHECK(worst < 40);
}

/// ∫ pdf over the sphere, for what is drawn as reflection: by points that are even over the
/// hemisphere and others that are as dense around the mirror direction as the lobe is, weighted
/// together.
double integral_of_density(const Material<double>& material, const Vec3<double>& to_prev) {
  using Kind = Material<double>::Kind;
  const Vec3<double> normal(0, 0, 1);
  const SurfaceBsdf<double> bsdf(material, normal, normal);
  const bool is_phong = material.kind == Kind::phong, is_diffuse = material.kind == Kind::diffuse;
  const double a2 = material.alpha * material.alpha, n = material.exponent;
  const Vec3<double> mirrored(-to_prev.x, -to_prev.y, to_prev.z);
  const auto lobe_density = [&](const Vec3<double>& w) {
    if (is_phong) return (n + 1) / (2 * pi<double>)*std::pow(std::max(0.0, glm::dot(w, mirrored)), n);
    // Half vectors with density D cos: cos² = (1 − u)/(1 + (α² − 1) u).
    const Vec3<double> half = glm::normalize(w + to_prev);
    const double d = half.z * half.z * (a2 - 1) + 1;
    return half.z > 0 ? a2 / (pi<double> * d * d) * half.z / (4 * std::abs(glm::dot(half, to_prev))) : 0.0;
  };
  // A lattice without rows: of the edge of the lobe, where it dips below the horizon, a grid would
  // make too much.
  constexpr int count = 45'000;
  constexpr double even_density = 1 / (2 * pi<double>);
  double sum = 0;
  const auto add = [&](const Vec3<double>& w) {
    if (!(w.z > 0)) return;
    const double pdf = bsdf.evaluate(to_prev, w, TransportMode::radiance).pdf.forward.value;
    if (pdf > 0) sum += pdf / (even_density + (is_diffuse ? 0 : lobe_density(w)));
  };
  for (int i = 0; i < count; ++i) {
    double whole = 0;
    const double u = std::modf(0.5 + i * 0.7548776662466927, &whole);
    const double v = 2 * pi<double> * std::modf(0.5 + i * 0.5698402909980532, &whole);
    const auto around = [&](double cosine) {
      const double sine = std::sqrt(std::max(0.0, 1 - cosine * cosine));
      return Vec3<double>(sine * std::cos(v), sine * std::sin(v), cosine);
    };
    add(around(1 - u));
    if (is_diffuse) continue;
    if (is_phong) {
      add(Frame<double>::around(mirrored).to_world(around(std::pow(1 - u, 1 / (n + 1)))));
    } else {
      const Vec3<double> half = around(std::sqrt((1 - u) / (1 + (a2 - 1) * u)));
      if (glm::dot(half, to_prev) > 0) add(glm::normalize(half * (2 * glm::dot(half, to_prev)) - to_prev));
    }
  }
  return sum / count;
}

TEST_CASE("hostile: densities integrate to the chance of a sample, and no energy is made", "[hostile][materials]") {
  // 5 standard errors, some 250 comparisons: false alarms once in 7,000 runs.
  Philox source(gmis_test::seed(523));
  constexpr int samples = 10'000;
  double worst = 0;
  int cases = 0;
  for (const auto& [name, material] : reflecting_materials<double>())
    for (const double cosine : {1.0, 0.7, 0.1, 1e-3}) {
      const SurfaceBsdf<double> bsdf(material, {0, 0, 1}, {0, 0, 1});
      const Vec3<double> to_prev = at_cosine(cosine, 0.7);
      int succeeded = 0;
      double sum = 0, squares = 0;
      for (int i = 0; i < samples; ++i) {
        const double u = uniform<double>(source), x = uniform<double>(source);
        const auto sample = bsdf.sample(to_prev, u, {x, uniform<double>(source)}, TransportMode::radiance);
        if (!sample) continue;
        ++succeeded;
        sum += sample->weight.x;
        squares += sample->weight.x * sample->weight.x;
      }
      const double share = static_cast<double>(succeeded) / samples;
      const double integral = integral_of_density(material, to_prev);
      const double mean = sum / samples;
      const double error = std::sqrt(std::max(0.0, squares / samples - mean * mean) / samples);
      CAPTURE(name, cosine, share, integral, mean, error);
      ++cases;
      worst = std::max(worst, std::abs(integral - share));
      CHECK(std::abs(integral - share) < 5 * std::sqrt(share * (1 - share) / samples) + 1e-3);
      CHECK(mean < 1 + 5 * error + 1e-9);
    }
  std::printf("%d densities integrated, worst difference from the share of samples %.2g\n", cases, worst);
}

TEMPLATE_TEST_CASE("hostile: a Phong lobe of a thousandth of a radian has the width it should", "[hostile][materials]",
                   float, double) {
  // 1 − cosⁿ⁺¹ of the angle to the mirror direction is uniform: χ² over 64 equal bins, false alarms
  // 1e-4 each.
  using T = TestType;
  Philox source(gmis_test::seed(525));
  for (const double n : {1.0, 1e3, 1e6}) {
    const auto material = make_phong<T>({0, 0, 0}, {1, 1, 1}, n);
    const SurfaceBsdf<T> bsdf(material, {0, 0, 1}, {0, 0, 1});
    constexpr std::size_t bins = 64;
    constexpr int count = 100'000;
    std::vector<double> counts(bins), expected(bins, double{count} / bins);
    for (int i = 0; i < count; ++i) {
      const T x = uniform<T>(source);
      const auto w = bsdf.sample_lobe(0, {0, 0, 1}, {x, uniform<T>(source)}, TransportMode::radiance);
      // Straight up: nothing falls below the horizon but what is on it.
      const glm::dvec3 d = w ? glm::normalize(glm::dvec3(*w)) : glm::dvec3(1, 0, 0);
      const double sine2 = d.x * d.x + d.y * d.y;
      const double share = d.z > 0 ? -std::expm1((n + 1) / 2 * std::log1p(-std::min(sine2, 1 - 1e-300))) : 1.0;
      ++counts[std::min(static_cast<std::size_t>(share * bins), bins - 1)];
    }
    const auto test = chi_square_test(counts, expected);
    CAPTURE(n, test.statistic);
    CHECK(test.p_value > 1e-4);
  }
}

TEMPLATE_TEST_CASE("hostile: the value of a Phong lobe of a thousandth of a radian has digits", "[hostile][materials]",
                   float, double) {
  // (n + 2)/(2π) cosⁿ of the angle between the directions themselves, in double.
  using T = TestType;
  constexpr double n = 1e6;
  const auto material = make_phong<T>({0, 0, 0}, {1, 1, 1}, n);
  const SurfaceBsdf<T> bsdf(material, {0, 0, 1}, {0, 0, 1});
  Philox source(gmis_test::seed(526));
  for (int i = 0; i < 1000; ++i) {
    const auto [u, v, x, y] = uniforms<double, 4>(source);
    const glm::dvec3 mirrored = square_to_cosine_hemisphere(Vec2<double>{u, v});
    const Vec3<T> to_prev(-mirrored.x, -mirrored.y, mirrored.z);
    const Vec3<T> to_next(glm::normalize(mirrored + 2e-3 * glm::dvec3(x - 0.5, y - 0.5, 0)));
    const glm::dvec3 r = glm::normalize(glm::dvec3(-to_prev.x, -to_prev.y, to_prev.z)),
                     apart = r - glm::normalize(glm::dvec3(to_next));
    if (to_next.z < T(0.1)) continue;
    const double value = (n + 2) / (2 * pi<double>)*std::exp(n * std::log1p(-glm::dot(apart, apart) / 2));
    CHECK(static_cast<double>(bsdf.evaluate(to_prev, to_next, TransportMode::radiance).value.x) ==
          Approx(value).epsilon(2e4 * static_cast<double>(std::numeric_limits<T>::epsilon())));
  }
}

TEST_CASE("hostile: rough glass of index 0.5 and 3 draws what it states", "[hostile][materials]") {
  Philox source(gmis_test::seed(524));
  const double level = sidak_level(1e-3, 18);
  const Vec3<double> normal = glm::normalize(Vec3<double>(0.3, -0.5, 0.7));
  CheckSettings settings;
  settings.samples = 40'000;
  settings.bins = 200;
  settings.precision = 1e-5;
  for (const double eta : {0.5, 3.0})
    for (const double alpha : {0.15, 0.5, 1.0}) {
      const auto material = make_dielectric<double>(eta, alpha);
      const SurfaceBsdf<double> bsdf(material, normal, normal);
      for (const double cosine : {0.9, 0.2, -0.6}) {
        CAPTURE(eta, alpha, cosine);
        const auto check =
            check_bsdf(bsdf, normal, Frame<double>::around(normal).to_world(at_cosine(cosine, 0.4)), source, settings);
        CHECK(check.directions.outside == 0);
        CHECK(check.directions.test.p_value > level);
        CHECK(check.reverse_error < 5e-3);
        CHECK(check.reciprocity_error < 5e-3);
        CHECK(check.sample_error < 5e-3);
        // Radiance goes up with the square of the index.
        CHECK(check.reflected_share < std::max(1.0, cosine < 0 ? eta * eta : 1 / (eta * eta)) + 1e-3);
      }
    }
}

/// Fresnel's equations in complex numbers: total reflection is the case of a complex cosine.
long double reflectance(long double cos_incident, long double index) {
  const std::complex<long double> cos_t =
      std::sqrt(std::complex<long double>(1 - (1 - cos_incident * cos_incident) / (index * index)));
  const auto s = (cos_incident - index * cos_t) / (cos_incident + index * cos_t);
  const auto p = (index * cos_incident - cos_t) / (index * cos_incident + cos_t);
  return (std::norm(s) + std::norm(p)) / 2;
}

TEMPLATE_TEST_CASE("hostile: refraction at and around the critical angle", "[hostile][materials]", float, double) {
  using T = TestType;
  double worst = 0;
  for (const double index : {0.5, 1 / 1.0001, 1 / 1.5, 1.0 / 3, 1.0, 1.0001, 3.0}) {
    const T eta = static_cast<T>(index);
    const T critical = eta < T(1) ? std::sqrt((T(1) - eta) * (T(1) + eta)) : T(0.5);
    T cosine = critical;
    for (int step = 0; step < 400; ++step) cosine = std::nextafter(cosine, T(0));
    for (int step = 0; step < 800; ++step, cosine = std::nextafter(cosine, T(1))) {
      const auto found = fresnel_dielectric(cosine, eta);
      CAPTURE(index, cosine);
      REQUIRE(std::isfinite(found.reflectance));
      REQUIRE(found.reflectance >= T(0));
      REQUIRE(found.reflectance <= T(1));
      REQUIRE(found.cos_transmitted >= T(0));
      REQUIRE(found.cos_transmitted <= T(1));
      // The square root makes √ε of a rounding error here, and no more.
      const auto exact = static_cast<double>(
          index == 1.0 ? 0.0L : reflectance(static_cast<long double>(cosine), static_cast<long double>(eta)));
      worst = std::max(worst, std::abs(static_cast<double>(found.reflectance) - exact));

      // And the whole material, from within.
      const auto material = make_dielectric<T>(1 / index);
      const SurfaceBsdf<T> bsdf(material, {0, 0, 1}, {0, 0, 1});
      constexpr T below_one = T(1) - std::numeric_limits<T>::epsilon() / T(2);
      for (const T u : {T(0), std::min(found.reflectance, below_one), T(0.9999), below_one}) {
        const auto sample = bsdf.sample(at_cosine(-cosine, T(1)), u, {T(0.5), T(0.5)}, TransportMode::radiance);
        if (!sample) continue;
        REQUIRE(std::isfinite(sample->weight.x));
        REQUIRE(sample->pdf.forward.value > T(0));
        REQUIRE(std::abs(glm::length(sample->to_next) - T(1)) < T(2e-6));
      }
    }
  }
  std::printf("%s: reflectance off by %.2g at most near the critical angle\n", sizeof(T) == 4 ? "float" : "double",
              worst);
  CHECK(worst < 30 * std::sqrt(static_cast<double>(std::numeric_limits<T>::epsilon())));
}

}  // namespace
