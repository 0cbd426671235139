#include "gmis/scene/rough_dielectric.hpp"

#include <string>
#include <utility>
#include <vector>

#include "gmis/scene/bsdf.hpp"
#include "scene/bsdf_checks.hpp"
#include "support/catch.hpp"
#include "support/seed.hpp"

using namespace gmis;
using namespace gmis::scene;

namespace {

const Vec3<double> axis = glm::normalize(Vec3<double>(-0.4, 0.2, 0.8));

template <std::floating_point T>
std::vector<std::pair<std::string, Material<T>>> glasses() {
  return {{"1.5, alpha 0.1", make_dielectric<T>(1.5, 0.1)},
          {"1.5, alpha 0.6", make_dielectric<T>(1.5, 0.6)},
          {"1.5, alpha 0.4, separable", make_dielectric<T>(1.5, 0.4, Masking::separable)},
          {"1/1.5, alpha 0.3", make_dielectric<T>(1 / 1.5, 0.3)},
          {"2.4, alpha 1", make_dielectric<T>(2.4, 1)}};
}

/// At this signed cosine from the axis.
Vec3<double> at(double cosine, double turn = 0.9) {
  const double sine = std::sqrt(1 - cosine * cosine);
  return Frame<double>::around(axis).to_world({sine * std::cos(turn), sine * std::sin(turn), cosine});
}

// False-alarm rate of all χ² tests of this file together: 1e-3.
const double level = sidak_level(1e-3, 70);

TEMPLATE_TEST_CASE("rough glass draws with the densities it states, both ways, and makes no energy", "[bsdf][glass]",
                   float, double) {
  using T = TestType;
  Philox source(gmis_test::seed(71));
  const Vec3<T> normal(axis);
  for (const auto& [name, material] : glasses<T>()) {
    const SurfaceBsdf<T> bsdf(material, normal, normal);
    constexpr bool is_single = std::same_as<T, float>;
    for (const double cosine : is_single ? std::vector{0.4, -0.3} : std::vector{0.95, 0.4, 0.06, -0.9, -0.3}) {
      INFO(name << ", cos = " << cosine);
      scene_test::check_at_point(bsdf, normal, Vec3<T>(at(cosine)), source, is_single ? 1e-5 : 1e-6, level,
                                 {5e-3, 1e-2, 1e-3});
    }
  }
}

TEST_CASE("each lobe of rough glass alone makes its density", "[bsdf][glass][lobes]") {
  using T = double;
  Philox source(gmis_test::seed(72));
  for (const auto& [name, material] : glasses<T>()) {
    const SurfaceBsdf<T> bsdf(material, axis, axis);
    REQUIRE(bsdf.lobe_count() == 2);
    for (const double cosine : {0.7, -0.6}) {
      INFO(name << ", cos = " << cosine);
      scene_test::check_lobes(bsdf, axis, at(cosine), source, 1e-6, level);
    }
  }
}

/// ∫ over a rectangle with the angle in [0, 2π), by a fixed rule.
template <class F>
double over_turns(const F& f, double lower, double upper) {
  double sum = 0;
  constexpr int cells = 16;
  const double step = (upper - lower) / cells;
  for (int row = 0; row < cells; ++row)
    for (int column = 0; column < cells; ++column)
      sum += gmis::detail::integrate_rectangle(f, lower + step * row, lower + step * (row + 1),
                                               2 * pi<double> * column / cells, 2 * pi<double> * (column + 1) / cells,
                                               0, 1);
  return sum;
}

/// ∫ f |cos| g over the directions of one side, by quadrature over directions …
double over_directions(const SurfaceBsdf<double>& bsdf, const Vec3<double>& to_prev, TransportMode mode, bool same_side,
                       const Vec3<double>& g) {
  const double cosine = glm::dot(axis, to_prev);
  const double side = (cosine > 0) == same_side ? 1 : -1;
  const Frame<double> frame = Frame<double>::around(axis);
  const auto f = [&](double z, double angle) {
    const double radius = sqrt_or_zero(1 - z * z);
    const Vec3<double> w = frame.to_world({radius * std::cos(angle), radius * std::sin(angle), side * z});
    return bsdf.evaluate(to_prev, w, mode).value.x * z * (1 + glm::dot(g, w));
  };
  // Where a facet that refracts that way would stand upright, f jumps to 0.
  const double eta = cosine > 0 ? double(bsdf.material().eta) : 1 / double(bsdf.material().eta);
  const double jump = same_side ? 0.5 : std::min(0.999, std::abs(cosine) / eta);
  return over_turns(f, 0, jump) + over_turns(f, jump, 1);
}

/// … and over the facets that send light there: ∫ D(h) G2 |prev·h| / |prev·n| · {F or 1 − F}
/// g(next) dh, straight from the model of facets, without any density of a direction [Walter 2007,
/// eq. 4, 6 and 8].
double over_facets(double alpha, Masking masking, double eta, const Vec3<double>& to_prev, bool same_side,
                   const Vec3<double>& g) {
  const bool is_outside = glm::dot(axis, to_prev) > 0;
  const Vec3<double> normal = is_outside ? axis : -axis;
  const double index = is_outside ? eta : 1 / eta;
  const Frame<double> frame = Frame<double>::around(normal);
  const auto smith = [&](double cosine) {
    return (std::sqrt(1 + alpha * alpha * (1 / (cosine * cosine) - 1)) - 1) / 2;
  };
  const auto f = [&](double s, double angle) {
    const double tangent = alpha * s / (1 - s);
    const double cos_h = 1 / std::sqrt(1 + tangent * tangent), sin_h = tangent * cos_h;
    const Vec3<double> half = frame.to_world({sin_h * std::cos(angle), sin_h * std::sin(angle), cos_h});
    const double facet = glm::dot(half, to_prev);
    if (!(facet > 0)) return 0.0;
    const double sine2 = (1 - facet * facet) / (index * index);
    double share = fresnel_dielectric(facet, index).reflectance;
    Vec3<double> next = 2.0 * facet * half - to_prev;
    if (!same_side) {
      share = 1 - share;
      if (!(sine2 < 1)) return 0.0;
      next = (half * facet - to_prev) / index - half * std::sqrt(1 - sine2);
    }
    const double cos_next = glm::dot(next, normal) * (same_side ? 1 : -1), cos_prev = glm::dot(to_prev, normal);
    if (!(cos_next > 0)) return 0.0;
    const double a = smith(cos_prev), b = smith(cos_next);
    const double visible = masking == Masking::separable ? 1 / ((1 + a) * (1 + b)) : 1 / (1 + a + b);
    // D = α²/(π cos⁴ (α² + tan²)²), and dh = sin dθ dφ with dθ/ds = α cos²/(1 − s)².
    const double distribution =
        alpha * alpha / (pi<double> * std::pow(cos_h, 4) * square(alpha * alpha + tangent * tangent));
    return distribution * visible * facet / cos_prev * share * (1 + glm::dot(g, next)) * sin_h * alpha * cos_h * cos_h /
           square(1 - s);
  };
  return over_turns(f, 0, 1);
}

TEST_CASE("rough glass sends where its facets do, and as much", "[bsdf][glass]") {
  struct Case {
    double eta, alpha;
    Masking masking;
  };
  for (const Case c : {Case{1.5, 0.2, Masking::height_correlated}, Case{1.33, 0.7, Masking::separable},
                       Case{0.6, 0.4, Masking::height_correlated}}) {
    const auto material = make_dielectric<double>(c.eta, c.alpha, c.masking);
    const SurfaceBsdf<double> bsdf(material, axis, axis);
    for (const double cosine : {0.8, 0.35, -0.7, -0.4})
      for (const bool same_side : {true, false})
        for (const Vec3<double> g : {Vec3<double>(0), Vec3<double>(0.7, -0.2, 0.4)}) {
          CAPTURE(c.eta, c.alpha, cosine, same_side, g.x);
          const double facets = over_facets(c.alpha, c.masking, c.eta, at(cosine), same_side, g);
          const double directions = over_directions(bsdf, at(cosine), TransportMode::importance, same_side, g);
          // At the edge of total reflection the rule is right to 1e-3.
          CHECK(directions == Approx(facets).epsilon(2e-3).margin(1e-5));
        }
  }
}

TEST_CASE("metal and a rough coat reflect what their facets do", "[bsdf][metal]") {
  // A metal of index 1.5 without absorption reflects as glass does, and so does a coat on a black
  // base.
  for (const double alpha : {0.15, 0.6})
    for (const Masking masking : {Masking::height_correlated, Masking::separable}) {
      const auto metal = make_conductor<double>(glm::dvec3(1.5), glm::dvec3(0), alpha, masking);
      const auto coat = make_coated_diffuse<double>({0, 0, 0}, 1.5, alpha, 1, masking);
      for (const double cosine : {0.9, 0.3}) {
        const Vec3<double> g(0.7, -0.2, 0.4);
        const double facets = over_facets(alpha, masking, 1.5, at(cosine), true, g);
        for (const auto* material : {&metal, &coat}) {
          const SurfaceBsdf<double> bsdf(*material, axis, axis);
          const double directions = over_directions(bsdf, at(cosine), TransportMode::radiance, true, g);
          CHECK(directions == Approx(facets).epsilon(2e-3));
        }
      }
    }
}

TEST_CASE("radiance and importance differ by the square of the index, and are each other's reverse", "[bsdf][glass]") {
  Philox source(gmis_test::seed(73));
  for (const auto& [name, material] : glasses<double>()) {
    const SurfaceBsdf<double> bsdf(material, axis, axis);
    int crossings = 0;
    double worst = 0;
    const auto compare = [&](double a, double b) { worst = std::max(worst, std::abs(a - b) / (a + b)); };
    for (int i = 0; i < 2000; ++i) {
      const Vec2<double> first{uniform<double>(source), uniform<double>(source)};
      const Vec2<double> second{uniform<double>(source), uniform<double>(source)};
      const Vec3<double> prev = square_to_sphere(first);
      const auto sample = bsdf.sample(prev, uniform<double>(source), second, TransportMode::radiance);
      if (!sample) continue;
      const bool crosses = glm::dot(prev, axis) * glm::dot(sample->to_next, axis) < 0;
      crossings += crosses ? 1 : 0;
      // Index on the side of the next direction over that of the previous one.
      const double index = !crosses ? 1 : glm::dot(prev, axis) > 0 ? double(material.eta) : 1 / double(material.eta);
      CHECK(sample->eta == Approx(index));
      const auto radiance = bsdf.evaluate(prev, sample->to_next, TransportMode::radiance);
      const auto importance = bsdf.evaluate(prev, sample->to_next, TransportMode::importance);
      const auto back = bsdf.evaluate(sample->to_next, prev, TransportMode::radiance);
      if (!(importance.value.x > 0)) continue;
      compare(radiance.value.x * index * index, importance.value.x);
      compare(back.value.x, importance.value.x);
      compare(radiance.pdf.forward.value, importance.pdf.forward.value);
      compare(radiance.pdf.reverse.value, back.pdf.forward.value);
      compare(sample->weight.x * sample->pdf.forward.value,
              radiance.value.x * std::abs(glm::dot(sample->to_next, axis)));
    }
    INFO(name);
    CHECK(crossings > 300);
    CHECK(worst < 1e-9);
  }
}

TEST_CASE("glass that is hardly rough does what smooth glass does", "[bsdf][glass]") {
  const auto rough = make_dielectric<double>(1.5, 0.002), smooth = make_dielectric<double>(1.5, 0.0005);
  REQUIRE(rough.kind == Material<double>::Kind::rough_dielectric);
  REQUIRE(smooth.kind == Material<double>::Kind::dielectric);
  CHECK(make_dielectric<float>(1, 0.5).kind == Material<float>::Kind::dielectric);
  Philox source(gmis_test::seed(74));
  for (const double cosine : {0.9, 0.5, -0.95}) {
    const Vec3<double> to_prev = at(cosine);
    const double reflectance = fresnel_dielectric(std::abs(cosine), cosine > 0 ? 1.5 : 1 / 1.5).reflectance;
    for (const double u : {reflectance * 0.9, reflectance * 1.1}) {
      const auto mirrored = SurfaceBsdf<double>(smooth, axis, axis).sample(to_prev, u, {}, TransportMode::radiance);
      REQUIRE(mirrored);
      // Median facet: uv.x = 1/2 is within an angle of α of the normal.
      for (int i = 0; i < 10; ++i) {
        const Vec2<double> uv(0.5 * uniform<double>(source), uniform<double>(source));
        const auto found = SurfaceBsdf<double>(rough, axis, axis).sample(to_prev, u, uv, TransportMode::radiance);
        REQUIRE(found);
        CHECK(glm::length(found->to_next - mirrored->to_next) < 0.01);
        CHECK(found->weight.x == Approx(mirrored->weight.x).epsilon(1e-3));
      }
    }
  }
}

TEST_CASE("in single precision a nearly smooth surface keeps its density", "[bsdf][glass]") {
  // The oracle is the same formula in double precision, at directions that are exactly
  // representable in both.
  Philox source(gmis_test::seed(75));
  const Vec3<float> normal(0, 0, 1);
  for (const float alpha : {0.001F, 0.01F}) {
    const auto glass = make_dielectric<float>(1.5, double(alpha));
    const auto exact = make_dielectric<double>(1.5, double(alpha));
    const auto metal = make_conductor<float>({1, 1, 1}, {2, 2, 2}, double(alpha));
    const auto exact_metal = make_conductor<double>({1, 1, 1}, {2, 2, 2}, double(alpha));
    double worst = 0;
    for (int i = 0; i < 500; ++i) {
      const Vec2<float> first{uniform<float>(source), uniform<float>(source)};
      const Vec2<float> uv(uniform<float>(source) * 0.9F, uniform<float>(source));
      const float u = uniform<float>(source);
      const Vec3<float> prev = square_to_cosine_hemisphere(first);
      if (prev.z < 0.1F) continue;
      const auto compare = [&](const Material<float>& m, const Material<double>& d) {
        const auto sample = SurfaceBsdf<float>(m, normal, normal).sample(prev, u, uv, TransportMode::radiance);
        if (!sample) return;
        const Vec3<double> p = glm::normalize(Vec3<double>(prev)), n = glm::normalize(Vec3<double>(sample->to_next));
        const auto value = SurfaceBsdf<double>(d, {0, 0, 1}, {0, 0, 1}).evaluate(p, n, TransportMode::radiance);
        worst = std::max(worst, std::abs(1 - double(sample->pdf.forward.value) / value.pdf.forward.value));
      };
      compare(glass, exact);
      compare(metal, exact_metal);
    }
    CAPTURE(alpha);
    CHECK(worst < 0.02);
  }
}

}  // namespace
