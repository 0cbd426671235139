#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "cloth.hpp"
#include "gmis/scene.hpp"
#include "scene/bsdf_checks.hpp"
#include "support/catch.hpp"
#include "support/seed.hpp"

// The material of examples/cloth.hpp, tested as CONTRIBUTING.md asks of any BSDF, and the two of
// one scene.

using namespace gmis;
using namespace gmis::scene;
using own::Cloth;
using own::ClothBsdf;
using own::make_cloth;

namespace {

using BuiltIn = SurfaceBsdf<float>;
using Mixed = EitherBsdf<BuiltIn, ClothBsdf>;
using V = Vec3<float>;

const V axis(glm::normalize(Vec3<double>(0.3, -0.5, 0.7)));

/// At `cosine` from the axis; below it when the cosine is negative.
V at_cosine(double cosine, double turn = 0.7) {
  const double sine = std::sqrt(1 - cosine * cosine);
  return V(Frame<double>::around(Vec3<double>(axis)).to_world({sine * std::cos(turn), sine * std::sin(turn), cosine}));
}

std::vector<std::pair<std::string, Cloth>> cloths() {
  return {{"velvet", make_cloth({0.3F, 0.05F, 0.1F}, {0.9F, 0.7F, 0.5F}, 0.3F)},
          {"white, r = 0.25", make_cloth({1, 1, 1}, {1, 1, 1}, 0.25F)},
          {"white, r = 0.5", make_cloth({1, 1, 1}, {1, 1, 1}, 0.5F)},
          {"white, r = 1", make_cloth({1, 1, 1}, {1, 1, 1}, 1)},
          {"sheen alone", make_cloth({0, 0, 0}, {1, 0.5F, 0.2F}, 0.4F)},
          {"base alone", make_cloth({0.8F, 0.5F, 0.2F}, {0, 0, 0}, 0.5F)}};
}

/// f by its definition, with angles, in `long double`; the share of the sheen lobe is taken from
/// the material.
Vec3<double> cloth_by_angles(const Cloth& cloth, const V& to_prev, const V& to_next) {
  using L = long double;
  const Vec3<L> n(axis), a(to_prev), b(to_next);
  const auto angle = [&](const Vec3<L>& w) { return std::acos(std::abs(glm::dot(n, w)) / glm::length(w)); };
  const L power = 1 / static_cast<L>(cloth.lobe.roughness);
  const L distribution = (2 + power) / (2 * pi<L>)*std::pow(std::sin(angle(a + b)), power);
  const L prev = std::cos(angle(a)), next = std::cos(angle(b));
  const L lobe = distribution / (4 * (prev + next - prev * next));
  const L s = std::max({cloth.sheen.x, cloth.sheen.y, cloth.sheen.z});
  const L left = (1 - s * static_cast<L>(cloth.share.at(static_cast<float>(prev)))) *
                 (1 - s * static_cast<L>(cloth.share.at(static_cast<float>(next))));
  return Vec3<double>(Vec3<L>(cloth.sheen) * lobe + Vec3<L>(cloth.base) * (left / pi<L>));
}

}  // namespace

TEST_CASE("cloth: its sampler makes its density, it is reciprocal and makes no energy", "[own]") {
  // False-alarm rate of the 30 χ² tests together: 1e-3.
  const double level = sidak_level(1e-3, 30);
  Philox source(gmis_test::seed(61));
  for (const auto& [name, cloth] : cloths()) {
    const ClothBsdf bsdf(cloth, axis, axis);
    for (const double cosine : {0.97, 0.5, 0.1, 0.02, -0.6}) {
      INFO(name << ", cos = " << cosine);
      const auto check =
          scene_test::check_at_point(bsdf, axis, at_cosine(cosine), source, 1e-5, level, {1e-4, 1e-3, 1e-4});
      CHECK(check.directions.integral > 1 - 1e-3);
    }
  }
}

TEST_CASE("cloth: f is what its definition says", "[own]") {
  Philox source(gmis_test::seed(62));
  for (const auto& [name, cloth] : cloths()) {
    const ClothBsdf bsdf(cloth, axis, axis);
    for (int i = 0; i < 500; ++i) {
      const double prev = 0.02 + 0.97 * uniform<double>(source), next = 0.02 + 0.97 * uniform<double>(source);
      const double side = uniform<double>(source) < 0.5 ? -1 : 1;
      const V a = at_cosine(side * prev), b = at_cosine(side * next, 6.3 * uniform<double>(source));
      const V f = bsdf.evaluate(a, b, TransportMode::radiance).value;
      const Vec3<double> expected = cloth_by_angles(cloth, a, b);
      // The rounding of directions of float moves sin² of the half vector by some 1e-6.
      for (int c = 0; c < 3; ++c)
        if (!(std::abs(static_cast<double>(f[c]) - expected[c]) <= 2e-5 * expected[c] + 1e-5))
          FAIL(name << ": " << f[c] << " instead of " << expected[c]);
      CHECK(is_black(bsdf.evaluate(a, -b, TransportMode::radiance).value));
    }
  }
}

TEST_CASE("cloth: what the sheen lobe reflects, by closed form and by quadrature", "[own]") {
  for (const float roughness : {0.25F, 0.5F, 1.0F}) {
    const auto cloth = make_cloth({0, 0, 0}, {1, 1, 1}, roughness);
    // From straight above V is 1/4 and θ_h half of θ: with s = sin θ_h, p = 1/r,
    // E = (2 + p) ∫ s^(p + 1) (1 − 2 s²) ds from 0 to √½ = 2^(−(p + 2)/2) · 2 / (p + 4).
    const double p = 1 / static_cast<double>(roughness);
    CHECK(static_cast<double>(cloth.share.at(1)) == Approx(std::exp2(-(p + 2) / 2) * 2 / (p + 4)).epsilon(2e-3));
    Philox unused(gmis_test::seed(1));
    double mean = 0;
    constexpr int steps = 16;
    for (int i = 0; i < steps; ++i) {
      const double cosine = (i + 0.5) / steps;
      const double share = reflected_share(ClothBsdf(cloth, axis, axis), axis, at_cosine(cosine), unused, 10);
      INFO("r = " << roughness << ", cos = " << cosine);
      CHECK(static_cast<double>(cloth.share.at(static_cast<float>(cosine))) == Approx(share).epsilon(3e-3));
      mean += 2 * cosine * share / steps;
    }
    CHECK(static_cast<double>(cloth.share.mean()) == Approx(mean).epsilon(3e-3));
    CHECK(static_cast<double>(cloth.albedo.x) == Approx(mean).epsilon(3e-3));
  }
}

TEST_CASE("cloth: each lobe alone makes its density, and the lobes with their weights make the whole", "[own]") {
  // False-alarm rate of the 18 χ² tests together: 1e-3.
  const double level = sidak_level(1e-3, 18);
  Philox source(gmis_test::seed(63));
  const auto all = cloths();
  for (const auto& [name, cloth] : {all[0], all[4], all[5]}) {
    const ClothBsdf bsdf(cloth, axis, axis);
    REQUIRE(bsdf.lobe_count() == 2);
    for (const double cosine : {0.9, 0.1, -0.4}) {
      INFO(name << ", cos = " << cosine);
      const V to_prev = at_cosine(cosine);
      scene_test::check_lobes(bsdf, axis, to_prev, source, 1e-5, level);
      for (int i = 0; i < 200; ++i) {
        const V w = square_to_sphere(Vec2<float>(uniform<float>(source), uniform<float>(source)));
        std::array<float, 2> pdfs{};
        bsdf.lobe_pdfs(to_prev, w, pdfs.data());
        const float pdf = bsdf.evaluate(to_prev, w, TransportMode::radiance).pdf.forward.value;
        CHECK(pdf == Approx(bsdf.lobe_weight(0) * pdfs[0] + bsdf.lobe_weight(1) * pdfs[1]).epsilon(1e-5));
        CHECK((pdf > 0) == (pdfs[0] > 0 && pdfs[1] > 0));
      }
    }
  }
}

TEST_CASE("cloth: nothing is reflected to where the two normals disagree; edges and degenerate cases", "[own]") {
  Philox source(gmis_test::seed(64));
  const V shading = glm::normalize(axis + 0.8F * Frame<float>::around(axis).tangent);
  const auto cloth = cloths().front().second;
  const ClothBsdf bsdf(cloth, axis, shading);
  for (int i = 0; i < 5000; ++i) {
    const auto direction = [&] {
      const float x = uniform<float>(source);
      return square_to_sphere(Vec2<float>(x, uniform<float>(source)));
    };
    const V prev = direction(), next = direction();
    const bool same_side = glm::dot(prev, shading) * glm::dot(prev, axis) > 0 &&
                           glm::dot(next, shading) * glm::dot(next, axis) > 0 &&
                           glm::dot(prev, axis) * glm::dot(next, axis) > 0;
    CHECK(is_black(bsdf.evaluate(prev, next, TransportMode::importance).value) == !same_side);
    const float u = uniform<float>(source);
    const auto sample = bsdf.sample(prev, u, {uniform<float>(source), 0.3F}, TransportMode::importance);
    if (sample && !(glm::dot(prev, axis) * glm::dot(sample->to_next, axis) > 0 &&
                    glm::dot(prev, shading) * glm::dot(sample->to_next, shading) > 0))
      FAIL("sampled through the surface");
  }
  const ClothBsdf flat(cloth, {0, 0, 1}, {0, 0, 1});
  for (const float z : {0.0F, 1e-30F, 1e-7F}) {
    const V grazing(1, 0, z);
    for (const V& other : {V(0, 0, 1), V(-1, 0, z), V(1, 0, z), V(0, 1, 1e-7F)}) {
      const auto value = flat.evaluate(grazing, other, TransportMode::radiance);
      for (int c = 0; c < 3; ++c) CHECK((value.value[c] >= 0 && value.value[c] <= std::numeric_limits<float>::max()));
    }
  }
  const auto black = make_cloth({0, 0, 0}, {0, 0, 0}, 0.5F);
  const ClothBsdf nothing(black, axis, axis);
  CHECK(nothing.is_purely_delta());
  CHECK(nothing.lobe_count() == 0);
  CHECK_FALSE(nothing.sample(axis, 0.5F, {0.5F, 0.5F}, TransportMode::radiance));
  CHECK_THROWS_AS(make_cloth({0, 0, 0}, {0, 0, 0}, 0.2F), std::invalid_argument);
  CHECK_THROWS_AS(make_cloth({0, 1.1F, 0}, {0, 0, 0}, 0.5F), std::invalid_argument);
}

namespace {

/// Every function of `whole` gives the bits that `part` gives. Equal; where the compiler fuses
/// multiplications and additions, which it may do otherwise in each place that a function is
/// inlined into, equal but for rounding.
bool are_equal(float a, float b) {
#ifdef __FMA__
  return std::abs(a - b) <= 1e-3F * std::max(1.0F, std::abs(b));
#else
  return a == b;
#endif
}
bool are_equal(const V& a, const V& b) {
  return are_equal(a.x, b.x) && are_equal(a.y, b.y) && are_equal(a.z, b.z);
}
bool are_equal(const std::optional<V>& a, const std::optional<V>& b) {
  return a.has_value() == b.has_value() && (!a || are_equal(*a, *b));
}

template <class Whole, class Part>
void check_is_forwarded(const Whole& whole, const Part& part, Philox& source) {
  CHECK(whole.is_purely_delta() == part.is_purely_delta());
  CHECK(whole.albedo() == part.albedo());
  CHECK(whole.lobe_count() == part.lobe_count());
  CHECK(whole.has_delta_lobes() == part.has_delta_lobes());
  CHECK(whole.lobes_have_full_support() == part.lobes_have_full_support());
  if constexpr (requires { part.is_glossy(); })
    CHECK(whole.is_glossy() == part.is_glossy());
  else
    CHECK_FALSE(whole.is_glossy());
  for (int k = 0; k < part.lobe_count(); ++k) CHECK(whole.lobe_weight(k) == part.lobe_weight(k));
  const auto random = [&] { return uniform<float>(source); };
  for (int i = 0; i < 200; ++i) {
    const float u = random(), x = random(), y = random(), z = random();
    const V prev = square_to_sphere(Vec2<float>(x, y)), next = square_to_sphere(Vec2<float>(z, random()));
    const Vec2<float> uv{random(), random()};
    for (const TransportMode mode : {TransportMode::radiance, TransportMode::importance}) {
      const auto a = whole.evaluate(prev, next, mode), b = part.evaluate(prev, next, mode);
      CHECK(are_equal(a.value, b.value));
      CHECK(are_equal(a.pdf.forward.value, b.pdf.forward.value));
      CHECK(are_equal(a.pdf.reverse.value, b.pdf.reverse.value));
      const auto drawn = whole.sample(prev, u, uv, mode), expected = part.sample(prev, u, uv, mode);
      REQUIRE(drawn.has_value() == expected.has_value());
      if (drawn) {
        CHECK(are_equal(drawn->to_next, expected->to_next));
        CHECK(are_equal(drawn->weight, expected->weight));
        CHECK(are_equal(drawn->pdf.forward.value, expected->pdf.forward.value));
        CHECK(are_equal(drawn->pdf.reverse.value, expected->pdf.reverse.value));
        CHECK(drawn->is_delta == expected->is_delta);
        CHECK(drawn->eta == expected->eta);
      }
      for (int k = 0; k < part.lobe_count(); ++k)
        CHECK(are_equal(whole.sample_lobe(k, prev, uv, mode), part.sample_lobe(k, prev, uv, mode)));
    }
    std::array<float, 2> a{-1, -1}, b{-1, -1};
    whole.lobe_pdfs(prev, next, a.data());
    part.lobe_pdfs(prev, next, b.data());
    CHECK((are_equal(a[0], b[0]) && are_equal(a[1], b[1])));
  }
}

/// Scatters nothing, and offers no lobes.
struct NoLobes {
  using Spectrum = V;
  struct Material {};
  NoLobes(const Material&, const V&, const V&) {}
  [[nodiscard]] BsdfValue<V> evaluate(const V&, const V&, TransportMode) const { return {}; }
  [[nodiscard]] std::optional<ScatterSample<V>> sample(const V&, float, const Vec2<float>&, TransportMode) const {
    return std::nullopt;
  }
  [[nodiscard]] bool is_purely_delta() const { return true; }
  [[nodiscard]] V albedo() const { return V(0); }
};
[[maybe_unused]] void add_effects_of(const NoLobes::Material&, Effects& effects) {
  effects.purely_glossy = true;
}

using Three = EitherBsdf<NoLobes, Mixed>;
static_assert(BsdfWithLobes<Mixed> && SurfaceModel<Mixed, float>);
static_assert(SurfaceModel<Three, float> && !BsdfWithLobes<Three>, "lobes only where all have them");
static_assert(SceneWithEffects<BvhScene<float, Mixed>> && SceneWithEffects<BvhScene<float, ClothBsdf>>);
static_assert(!SurfaceModel<BuiltIn, double>, "a scene of another precision");

}  // namespace

TEST_CASE("a surface of either kind does what its own BSDF does, bit by bit", "[own]") {
  Philox source(gmis_test::seed(65));
  const V shading = glm::normalize(axis + 0.2F * Frame<float>::around(axis).tangent);
  for (const auto& material :
       {make_diffuse({.5, .5, .5}), make_diffuse({0, 0, 0}), make_phong({.3, .3, .3}, {.4, .4, .4}, 30.0),
        make_mirror({.9, .9, .9}), make_dielectric(1.5), make_dielectric(1.5, .3),
        make_conductor({.2, .9, 1}, {4, 2, 2}, .2), make_coated_diffuse({.5, .5, .5}, 1.5, 0),
        make_coated_diffuse({.5, .5, .5}, 1.5, .2)}) {
    const Mixed::Material either = material;
    REQUIRE(either.first());
    CHECK_FALSE(either.second());
    check_is_forwarded(Mixed(either, axis, shading), BuiltIn(material, axis, shading), source);
  }
  for (const auto& [name, cloth] : cloths()) {
    INFO(name);
    const Mixed::Material either = cloth;
    CHECK_FALSE(either.first());
    REQUIRE(either.second());
    check_is_forwarded(Mixed(either, axis, shading), ClothBsdf(cloth, axis, shading), source);
    const Three::Material nested = cloth;  // converted twice
    CHECK(Three(nested, axis, shading).albedo() == cloth.albedo);
  }
}

TEST_CASE("a scene of two kinds has the effects of both, and its surfaces are what they were made of", "[own]") {
  const auto with = [](auto&& material) {
    SceneBuilder<float, Mixed> builder;
    builder.add_material(make_dielectric(1.5));  // no shape uses it
    builder.add_sphere({0, 0, 5}, 1, builder.add_material(material));
    builder.set_camera(look_at({0, 0, 0}, {0, 0, 1}, {0, 1, 0}, 40, {4, 4}));
    return builder.build().effects();
  };
  Effects diffuse, specular;
  diffuse.diffuse = true;
  specular.specular_reflection = true;
  CHECK(with(make_mirror({1, 1, 1})) == specular);
  CHECK(with(make_cloth({.5F, 0, 0}, {0, .5F, 0}, .5F)) == diffuse);
  CHECK(with(make_cloth({0, 0, 0}, {0, 0, 0}, .5F)) == Effects());

  SceneBuilder<float, Mixed> builder;
  const auto mirror = builder.add_material(make_mirror({1, 1, 1}));
  const auto cloth = builder.add_material(make_cloth({.5F, 0, 0}, {0, .5F, 0}, .5F));
  builder.add_sphere({0, 0, 5}, 1, mirror);
  builder.add_sphere({0, 0, -5}, 1, cloth);
  builder.set_camera(look_at({0, 0, 0}, {0, 0, 1}, {0, 1, 0}, 40, {4, 4}));
  const auto scene = builder.build();
  Effects both = diffuse;
  both.specular_reflection = true;
  CHECK(scene.effects() == both);
  const auto ahead = scene.intersect({V(0), V(0, 0, 1)}), behind = scene.intersect({V(0), V(0, 0, -1)});
  REQUIRE((ahead && behind));
  CHECK(ahead->bsdf.is_purely_delta());
  CHECK_FALSE(behind->bsdf.is_purely_delta());
  CHECK(behind->bsdf.lobe_count() == 2);

  // A scene of cloth alone, without the materials of the library.
  SceneBuilder<float, ClothBsdf> all_cloth;
  all_cloth.add_sphere({0, 0, 5}, 1, all_cloth.add_material(make_cloth({.5F, 0, 0}, {0, .5F, 0}, .5F)));
  all_cloth.set_camera(look_at({0, 0, 0}, {0, 0, 1}, {0, 1, 0}, 40, {4, 4}));
  CHECK(all_cloth.build().effects() == diffuse);
}
