#include "gmis/scene/bsdf.hpp"

#include <string>
#include <utility>
#include <vector>

#include "scene/bsdf_checks.hpp"
#include "support/catch.hpp"
#include "support/seed.hpp"

using namespace gmis;
using namespace gmis::scene;

namespace {

template <std::floating_point T>
std::vector<std::pair<std::string, Material<T>>> rough_materials() {
  const glm::dvec3 copper_eta{0.2, 0.92, 1.1}, copper_k{3.9, 2.45, 2.14};
  return {{"diffuse", make_diffuse<T>({0.9, 0.5, 0.1})},
          {"phong, n = 1", make_phong<T>({0.2, 0.1, 0}, {0.5, 0.7, 0.6}, 1)},
          {"phong, n = 90", make_phong<T>({0.3, 0.3, 0.3}, {0.7, 0.4, 0.1}, 90)},
          {"phong, no diffuse lobe", make_phong<T>({0, 0, 0}, {1, 1, 1}, 20)},
          {"conductor, alpha 0.05", make_conductor<T>(copper_eta, copper_k, 0.05)},
          {"conductor, alpha 0.4", make_conductor<T>(copper_eta, copper_k, 0.4)},
          {"conductor, alpha 1, separable", make_conductor<T>(copper_eta, copper_k, 1, Masking::separable)},
          {"conductor of reflectance 1", make_conductor_of_reflectance<T>({1, 1, 1}, 0.2)},
          {"coated, alpha 0.3", make_coated_diffuse<T>({0.8, 0.5, 0.2}, 1.5, 0.3)},
          {"coated, alpha 0.1, separable", make_coated_diffuse<T>({0.5, 0.5, 0.5}, 1.8, 0.1, 0.5, Masking::separable)},
          {"coated, black base", make_coated_diffuse<T>({0, 0, 0}, 1.5, 0.2)},
          {"coated, smooth", make_coated_diffuse<T>({0.8, 0.5, 0.2}, 1.5, 0)}};
}

const Vec3<double> axis = glm::normalize(Vec3<double>(0.3, -0.5, 0.7));

/// At `cosine` from the axis; below it when the cosine is negative.
template <std::floating_point T>
Vec3<T> at_cosine(double cosine) {
  return Vec3<T>(Frame<double>::around(axis).to_world(
      {std::sqrt(1 - cosine * cosine) * 0.6, std::sqrt(1 - cosine * cosine) * 0.8, cosine}));
}

// False-alarm rate of all χ² tests of this case and the next together: 1e-3.
const double level = sidak_level(1e-3, 200);

TEMPLATE_TEST_CASE("samplers make the densities they state, reciprocal and without making energy", "[bsdf]", float,
                   double) {
  using T = TestType;
  Philox source(gmis_test::seed(41));
  const Vec3<T> normal(axis);
  for (const auto& [name, material] : rough_materials<T>()) {
    const SurfaceBsdf<T> bsdf(material, normal, normal);
    for (const double cosine : {0.97, 0.5, 0.1, -0.6}) {
      INFO(name << ", cos = " << cosine);
      scene_test::check_at_point(bsdf, normal, at_cosine<T>(cosine), source, std::same_as<T, float> ? 1e-5 : 1e-6,
                                 level, {2e-3, 5e-3, 1e-3});
    }
  }
}

TEST_CASE("each lobe alone makes its density, and the lobes with their weights make the whole", "[bsdf][lobes]") {
  using T = double;
  Philox source(gmis_test::seed(42));
  for (const auto& [name, material] : rough_materials<T>()) {
    const SurfaceBsdf<T> bsdf(material, axis, axis);
    for (const double cosine : {0.9, 0.3, -0.4}) {
      INFO(name << ", cos = " << cosine);
      const Vec3<T> to_prev = at_cosine<T>(cosine);
      scene_test::check_lobes(bsdf, axis, to_prev, source, 1e-6, level);
      if (material.kind == Material<T>::Kind::smooth_coated) continue;  // its pdf counts the delta lobe
      for (int i = 0; i < 200; ++i) {
        const Vec2<T> uv{uniform<T>(source), uniform<T>(source)};
        const Vec3<T> w = square_to_sphere(uv);
        std::array<T, 2> pdfs{};
        bsdf.lobe_pdfs(to_prev, w, pdfs.data());
        T mixture = 0;
        for (int k = 0; k < bsdf.lobe_count(); ++k) mixture += bsdf.lobe_weight(k) * pdfs[static_cast<std::size_t>(k)];
        const T pdf = bsdf.evaluate(to_prev, w, TransportMode::radiance).pdf.forward.value;
        if (!(std::abs(mixture - pdf) <= 1e-12 * pdf)) FAIL(name << ": " << mixture << " instead of " << pdf);
        // Full support: where f is not 0 no lobe is.
        if (bsdf.lobes_have_full_support() && pdf > 0)
          for (int k = 0; k < bsdf.lobe_count(); ++k)
            if (!(pdfs[static_cast<std::size_t>(k)] > 0)) FAIL(name << ": lobe " << k << " has a hole");
      }
    }
  }
}

double reflected(const SurfaceBsdf<double>& bsdf, const Vec3<double>& to_prev) {
  Philox unused(gmis_test::seed(1));
  return reflected_share(bsdf, axis, to_prev, unused, 10, 1e-8);
}

TEST_CASE("albedos with a closed form", "[bsdf][energy]") {
  // Lambert reflects its reflectance. Phong from straight above: ks (n + 2)/(2π) ∫ cosⁿ⁺¹ = ks.
  const auto lambert = make_diffuse<double>({0.9, 0.5, 0.1});
  CHECK(reflected({lambert, axis, axis}, at_cosine<double>(0.4)) == Approx(0.9).epsilon(1e-6));
  for (const double exponent : {1.0, 10.0, 200.0}) {
    const auto phong = make_phong<double>({0, 0, 0}, {0.8, 0.8, 0.8}, exponent);
    CHECK(reflected({phong, axis, axis}, axis) == Approx(0.8).epsilon(1e-5));
    for (const double cosine : {0.9, 0.5, 0.1}) CHECK(reflected({phong, axis, axis}, at_cosine<double>(cosine)) <= 0.8);
  }
  // A smooth coat: what it reflects, a delta lobe, and what comes out of the base, which is all
  // there is when the base is white. The base scatters by the cosine alone: its share by the
  // midpoint rule, to some 1e-6.
  const auto white = make_coated_diffuse<double>({1, 1, 1}, 1.5, 0);
  for (const double cosine : {0.9, 0.5, 0.1}) {
    const SurfaceBsdf<double> bsdf(white, axis, axis);
    double below = 0;
    constexpr int steps = 4000;
    for (int i = 0; i < steps; ++i) {
      const double next = (i + 0.5) / steps;
      const auto value =
          bsdf.evaluate(at_cosine<double>(cosine), at_cosine<double>(next), TransportMode::radiance).value;
      below += 2 * pi<double> * next * value.x / steps;
    }
    CHECK(below == Approx(1 - fresnel_dielectric(cosine, 1.5).reflectance).epsilon(1e-4));
  }
}

TEST_CASE("a microfacet distribution is normalised over projected area", "[bsdf][ggx]") {
  // ∫ D(h) cos dh = 1; Λ(w): ∫ D(h) max(0, w·h) dh = cos w (1 + Λ(w)) [Heitz 2014, eq. 4 and 19].
  for (const double alpha : {0.05, 0.3, 1.0}) {
    const Ggx<double> ggx{alpha};
    // tan θ = α s/(1 − s) puts the points where D is.
    const auto over_half_vectors = [&](const auto& f) {
      double sum = 0;
      constexpr int steps = 4000;
      for (int i = 0; i < steps; ++i) {
        const double s = (i + 0.5) / steps;
        const double tangent = alpha * s / (1 - s);
        const double cos_h = 1 / std::sqrt(1 + tangent * tangent), sin_h = tangent * cos_h;
        const double stretch = alpha / ((1 - s) * (1 - s)) * cos_h * cos_h / steps;
        sum += 2 * pi<double> * ggx.distribution(cos_h) * sin_h * f(cos_h, sin_h) * stretch;
      }
      return sum;
    };
    CHECK(over_half_vectors([](double cos_h, double) { return cos_h; }) == Approx(1).epsilon(1e-5));
    for (const double cosine : {0.9, 0.4, 0.05}) {
      const double sine = std::sqrt(1 - cosine * cosine);
      const double visible = over_half_vectors([&](double cos_h, double sin_h) {
        double turn = 0;
        for (int j = 0; j < 200; ++j)
          turn += std::max(0.0, cosine * cos_h + sine * sin_h * std::cos(2 * pi<double> * (j + 0.5) / 200)) / 200;
        return turn;
      });
      CHECK(visible == Approx(cosine * (1 + ggx.lambda(cosine))).epsilon(1e-4));
    }
  }
}

TEST_CASE("delta materials reflect and refract as they should, and say so", "[bsdf][delta]") {
  using T = double;
  const auto mirror = make_mirror<T>({0.9, 0.8, 0.7});
  const auto metal = make_conductor<T>({0.2, 0.9, 1.1}, {3.9, 2.4, 2.1}, 0.0005);
  const auto glass = make_dielectric<T>(1.5);
  for (const double cosine : {0.95, 0.3, -0.3}) {
    const Vec3<T> to_prev = at_cosine<T>(cosine);
    for (const auto* material : {&mirror, &metal}) {
      const SurfaceBsdf<T> bsdf(*material, axis, axis);
      CHECK(bsdf.is_purely_delta());
      CHECK(bsdf.lobe_count() == 0);
      const auto sample = bsdf.sample(to_prev, 0.5, {0.1, 0.2}, TransportMode::radiance);
      REQUIRE(sample);
      CHECK(sample->is_delta);
      CHECK(glm::length(sample->to_next - reflect_about(to_prev, axis)) < 1e-14);
      CHECK(sample->pdf.forward.value == 1);
      CHECK(sample->eta == 1);
      CHECK(is_black(bsdf.evaluate(to_prev, sample->to_next, TransportMode::radiance).value));
    }
    const SurfaceBsdf<T> bsdf(glass, axis, axis);
    const double index = cosine > 0 ? 1.5 : 1 / 1.5;
    const double reflectance = fresnel_dielectric(std::abs(cosine), index).reflectance;
    const auto reflected_part = bsdf.sample(to_prev, reflectance * 0.999, {0.1, 0.2}, TransportMode::radiance);
    REQUIRE(reflected_part);
    CHECK(glm::dot(reflected_part->to_next, axis) == Approx(cosine));
    CHECK(reflected_part->weight.x == 1);
    CHECK(reflected_part->pdf.forward.value == Approx(reflectance));
    for (const TransportMode mode : {TransportMode::radiance, TransportMode::importance}) {
      const auto refracted = bsdf.sample(to_prev, 0.999, {0.1, 0.2}, mode);
      REQUIRE(refracted);
      const double next = glm::dot(refracted->to_next, axis);
      if (reflectance == 1) {
        CHECK(next * cosine > 0);
        continue;
      }
      CHECK(next * cosine < 0);
      // Snell, tangential parts: sin = index · sin; and all in one plane.
      CHECK(glm::length(glm::cross(to_prev, axis) + index * glm::cross(refracted->to_next, axis)) < 1e-14);
      CHECK(refracted->eta == Approx(index));
      CHECK(refracted->weight.x == Approx(mode == TransportMode::radiance ? 1 / (index * index) : 1));
      CHECK(refracted->pdf.forward.value == Approx(1 - reflectance));
      // Back along the same path: the same chance, forward and reverse change places.
      const auto back = bsdf.sample(refracted->to_next, 0.999, {0.1, 0.2}, mode);
      REQUIRE(back);
      CHECK(glm::length(back->to_next - to_prev) < 1e-13);
      CHECK(back->pdf.forward.value == Approx(refracted->pdf.reverse.value));
    }
  }
}

TEST_CASE("an index of one is not there", "[bsdf][delta]") {
  const auto nothing = make_dielectric<float>(1);
  const Vec3<float> normal(axis);
  const SurfaceBsdf<float> bsdf(nothing, normal, normal);
  for (const double cosine : {1.0, 0.5, 1e-4, -0.7}) {
    const auto to_prev = at_cosine<float>(cosine);
    const auto sample = bsdf.sample(to_prev, 0.0F, {0.5F, 0.5F}, TransportMode::radiance);
    REQUIRE(sample);
    CHECK(glm::length(sample->to_next + to_prev) < 1e-6F);
    CHECK(sample->weight == Vec3<float>(1));
  }
}

TEST_CASE("a thin pane lets light pass straight on and reflects it at both of its faces", "[bsdf][delta]") {
  using T = double;
  const Vec3<T> tint{0.9, 0.5, 0.2};
  const auto pane = gmis::scene::make_thin_dielectric<T>(1.5, tint);
  const SurfaceBsdf<T> bsdf(pane, axis, axis);
  CHECK(bsdf.is_purely_delta());
  for (const double cosine : {1.0, 0.6, 0.05, -0.3}) {
    const Vec3<T> to_prev = at_cosine<T>(cosine);
    const long double face = fresnel_dielectric(std::abs(cosine), 1.5).reflectance;
    long double reflectance = face, between = (1 - face) * (1 - face) * face;  // once, twice … to and fro
    for (int k = 0; k < 2000; ++k, between *= face * face) reflectance += between;
    for (const TransportMode mode : {TransportMode::radiance, TransportMode::importance}) {
      const auto reflected_part = bsdf.sample(to_prev, 0.0, {0.1, 0.2}, mode);
      REQUIRE(reflected_part);
      CHECK(glm::length(reflected_part->to_next - reflect_about(to_prev, axis)) < 1e-14);
      CHECK(reflected_part->weight == Vec3<T>(1));
      CHECK(reflected_part->pdf.forward.value == Approx(static_cast<double>(reflectance)));
      const auto passing = bsdf.sample(to_prev, 0.9999, {0.1, 0.2}, mode);
      REQUIRE(passing);
      CHECK(passing->to_next == -to_prev);
      CHECK(passing->weight == tint);
      CHECK(passing->eta == 1);
      CHECK(passing->pdf.forward.value == Approx(static_cast<double>(1 - reflectance)));
      CHECK(passing->pdf.reverse.value == passing->pdf.forward.value);
    }
  }
}

TEST_CASE("a smooth coat is a delta lobe over a lobe that is none", "[bsdf][delta]") {
  using T = double;
  const auto coated = make_coated_diffuse<T>({0.8, 0.5, 0.2}, 1.5, 0);
  const SurfaceBsdf<T> bsdf(coated, axis, axis);
  const Vec3<T> to_prev = at_cosine<T>(0.5);
  CHECK_FALSE(bsdf.is_purely_delta());
  CHECK(bsdf.lobe_count() == 1);
  const auto sample = bsdf.sample(to_prev, 0.9999, {0.3, 0.4}, TransportMode::radiance);
  REQUIRE(sample);
  CHECK(sample->is_delta);
  // Weight times chance is the coat's reflectance, whatever the chance.
  CHECK(sample->weight.x * sample->pdf.forward.value == Approx(fresnel_dielectric(0.5, 1.5).reflectance));
  CHECK(sample->pdf.forward.value + coated.diffuse_probability == Approx(1));

  const auto bare = make_coated_diffuse<T>({0, 0, 0}, 1.5, 0);
  CHECK(SurfaceBsdf<T>(bare, axis, axis).is_purely_delta());
}

TEST_CASE("what the base under a coat gives back does not depend on the coat's roughness", "[bsdf]") {
  using T = double;
  Philox source(gmis_test::seed(44));
  const Vec3<T> reflectance(0.8, 0.5, 0.2);
  const auto rough = make_coated_diffuse<T>(reflectance, 1.5, 0.3), bare = make_coated_diffuse<T>({0, 0, 0}, 1.5, 0.3);
  const double from_outside = fresnel_diffuse_reflectance(1.5), from_inside = 1 - (1 - from_outside) / 2.25;
  for (int i = 0; i < 100; ++i) {
    const Vec2<T> first{uniform<T>(source), uniform<T>(source)}, second{uniform<T>(source), uniform<T>(source)};
    const auto frame = Frame<T>::around(axis);
    const Vec3<T> prev = frame.to_world(square_to_cosine_hemisphere(first));
    const Vec3<T> next = frame.to_world(square_to_cosine_hemisphere(second));
    const auto f = [&](const Material<T>& material) {
      return SurfaceBsdf<T>(material, axis, axis).evaluate(prev, next, TransportMode::radiance).value;
    };
    // In, and out, and any number of times to and fro in between: a geometric series.
    const double in = 1 - fresnel_dielectric(glm::dot(prev, axis), 1.5).reflectance;
    const double out = 1 - fresnel_dielectric(glm::dot(next, axis), 1.5).reflectance;
    for (int c = 0; c < 3; ++c)
      CHECK(f(rough)[c] - f(bare)[c] ==
            Approx(in * out / 2.25 * reflectance[c] / pi<T> / (1 - reflectance[c] * from_inside)).epsilon(1e-9));
  }
}

TEST_CASE("a black surface scatters nothing", "[bsdf]") {
  const auto black = make_diffuse<float>({0, 0, 0});
  const Vec3<float> normal(axis);
  const SurfaceBsdf<float> bsdf(black, normal, normal);
  CHECK(bsdf.is_purely_delta());
  CHECK(is_black(bsdf.albedo()));
  CHECK_FALSE(bsdf.sample(normal, 0.5F, {0.5F, 0.5F}, TransportMode::radiance));
}

TEST_CASE("nothing is reflected to where the two normals disagree", "[bsdf][shading]") {
  using T = double;
  Philox source(gmis_test::seed(43));
  const Vec3<T> shading = glm::normalize(axis + 0.8 * Frame<T>::around(axis).tangent);
  for (const auto& [name, material] : rough_materials<T>()) {
    const SurfaceBsdf<T> bsdf(material, axis, shading);
    for (int i = 0; i < 2000; ++i) {
      const Vec2<T> first{uniform<T>(source), uniform<T>(source)}, second{uniform<T>(source), uniform<T>(source)};
      const Vec3<T> prev = square_to_sphere(first);
      const auto sample = bsdf.sample(prev, uniform<T>(source), second, TransportMode::importance);
      if (sample && !(glm::dot(prev, axis) * glm::dot(sample->to_next, axis) > 0 &&
                      glm::dot(prev, shading) * glm::dot(sample->to_next, shading) > 0))
        FAIL(name << ": sampled through the surface");
      const Vec3<T> next = square_to_sphere(second);
      const auto value = bsdf.evaluate(prev, next, TransportMode::importance);
      const bool one_side = glm::dot(prev, axis) * glm::dot(next, axis) > 0 &&
                            glm::dot(prev, shading) * glm::dot(next, shading) > 0 &&
                            glm::dot(prev, axis) * glm::dot(prev, shading) > 0;
      if (!one_side && !is_black(value.value)) FAIL(name << ": evaluated through the surface");
    }
  }
}

TEST_CASE("what reflects only is dark from one side to the other", "[bsdf]") {
  using T = double;
  Philox source(gmis_test::seed(44));
  auto materials = rough_materials<T>();
  materials.push_back({"smooth glass", make_dielectric<T>(1.5)});
  for (const auto& [name, material] : materials) {
    const SurfaceBsdf<T> bsdf(material, axis, axis);
    CHECK(reflects_only(bsdf));
    for (int i = 0; i < 500; ++i) {
      const auto [a, b, c, d] = uniforms<T, 4>(source);
      const Vec3<T> prev = square_to_sphere(Vec2<T>{a, b}), next = square_to_sphere(Vec2<T>{c, d});
      if (glm::dot(prev, axis) * glm::dot(next, axis) > 0) continue;
      if (!is_black(bsdf.evaluate(prev, next, TransportMode::radiance).value)) FAIL(name << ": through the surface");
    }
  }
  const auto glass = make_dielectric<T>(1.5, 0.3);
  CHECK_FALSE(reflects_only(SurfaceBsdf<T>(glass, axis, axis)));
}

TEST_CASE("materials refuse what is none", "[bsdf]") {
  CHECK_THROWS_AS(make_diffuse({-0.1, 0, 0}), std::invalid_argument);
  CHECK_THROWS_AS(make_diffuse({std::nan(""), 0, 0}), std::invalid_argument);
  CHECK_THROWS_AS(make_phong({0, 0, 0}, {1, 1, 1}, -1), std::invalid_argument);
  CHECK_THROWS_AS(make_dielectric(0), std::invalid_argument);
  CHECK_THROWS_AS(make_conductor({1, 1, 1}, {1, 1, 1}, 2), std::invalid_argument);
  CHECK_THROWS_AS(make_coated_diffuse({0.5, 0.5, 0.5}, 0.9, 0.1), std::invalid_argument);
  CHECK_THROWS_AS(make_coated_diffuse({0.5, 0.5, 0.5}, 1.5, 1.1), std::invalid_argument);
  CHECK_THROWS_AS(make_coated_diffuse({0.5, 0.5, 0.5}, 1.5, 0.1, 1.1), std::invalid_argument);
  CHECK_THROWS_AS(make_phong({0, 0, 0}, {1, 1, 1}, 1.1e6), std::invalid_argument);
  CHECK_THROWS_AS(make_phong({0, 0, 0}, {-0.1, 0, 0}, 1), std::invalid_argument);
  CHECK_THROWS_AS(make_mirror({-0.1, 0, 0}), std::invalid_argument);
  CHECK_THROWS_AS(make_dielectric(100), std::invalid_argument);
  CHECK_THROWS_AS(make_dielectric(1.5, 1.1), std::invalid_argument);
  CHECK_THROWS_AS(make_dielectric(1.5, 0.1, Masking::separable, {1, 1.1, 1}), std::invalid_argument);
  CHECK_THROWS_AS(make_conductor({1, 1.1e6, 1}, {1, 1, 1}, 0.1), std::invalid_argument);
  CHECK_THROWS_AS(make_conductor({1, 1, 1}, {1, -0.1, 1}, 0.1), std::invalid_argument);
  CHECK_THROWS_AS(make_conductor_of_reflectance({-0.1, 0, 0}, 0.1), std::invalid_argument);
  CHECK_THROWS_AS(make_diffuse_transmission({0, 0, 0}, {-0.1, 0, 0}), std::invalid_argument);
  CHECK_THROWS_AS(make_coated_conductor({1, 1, 1}, {1, 1, 1}, 0.1, 0.9, 0.1), std::invalid_argument);
  CHECK_THROWS_AS(make_coated_conductor({1, 1, 1}, {1, 1, 1}, 0.1, 1.5, 1.1), std::invalid_argument);
}

}  // namespace
