#include "guided_directions/guided_bsdf.hpp"

#include <array>
#include <cmath>
#include <optional>
#include <vector>

#include "gmis/core/concept_diagnostics.hpp"
#include "gmis/core/density_tests.hpp"
#include "gmis/core/random.hpp"
#include "gmis/scene/bsdf.hpp"
#include "guided_directions/direction_guide.hpp"
#include "support/catch.hpp"
#include "support/seed.hpp"

// Guided BSDFs alone: built-in materials with one learned lobe more, against quadrature, counts of
// samples, and the same density asked from the other end.

namespace {

using gmis::TransportMode;
using T = double;
using V = gmis::Vec3<T>;
using Own = gmis::scene::SurfaceBsdf<T>;
using Lobe = gmis::LearnedLobe<T>;
using Bsdf = gmis::Guided<Own, Lobe>;
using Table = gmis::SquareTable<T>;

static_assert(gmis::IsBsdfWithLobes<Bsdf>());
static_assert(sizeof(Bsdf) == sizeof(Own) + sizeof(void*));  // vertices hold it

constexpr std::array modes{TransportMode::radiance, TransportMode::importance};

TransportMode other(TransportMode mode) {
  return mode == TransportMode::radiance ? TransportMode::importance : TransportMode::radiance;
}

/// A cell around one axis with uneven tables: for either mode and side, but none for importance at
/// the back.
struct Cell {
  std::array<Table, 4> tables;
  gmis::GuideCell<T> cell;

  Cell(int axis, T sign, std::uint64_t seed) {
    gmis::Philox source(seed);
    cell.axis = axis;
    cell.sign = sign;
    for (std::size_t place = 0; place < 4; ++place) {
      std::array<double, Table::size> masses{};
      for (double& mass : masses) mass = std::pow(gmis::uniform<double>(source), 6.0);
      tables[place] = Table(masses, 0.02);
      if (place != gmis::GuideCell<T>::place(false, TransportMode::importance)) cell.tables[place] = &tables[place];
    }
  }
  Cell(const Cell&) = delete;
  Cell& operator=(const Cell&) = delete;
};

using Material = Own::Material;
struct Named {
  const char* name;
  Material material;
};
/// The materials that a guide may meet: with and without a delta lobe, on one side and on both.
std::vector<Named> materials() {
  using namespace gmis::scene;
  return {{"diffuse", make_diffuse<T>({0.7, 0.5, 0.3})},
          {"phong", make_phong<T>({0.3, 0.3, 0.3}, {0.4, 0.4, 0.4}, 12)},
          {"rough conductor", make_conductor<T>({0.2, 0.9, 1.1}, {3.9, 2.4, 2.2}, 0.5)},
          {"smooth coat", make_coated_diffuse<T>({0.6, 0.4, 0.2}, 1.5, 0)},
          {"thin sheet", make_diffuse_transmission<T>({0.4, 0.3, 0.2}, {0.3, 0.3, 0.3})},
          {"rough glass", make_dielectric<T>(1.5, 0.4)}};
}

// A shading normal that is not the axis of the cell: some of its hemisphere is under the surface.
const V normal = glm::normalize(V(0.3, 0.9, -0.2));
const std::array<V, 2> origins{glm::normalize(V(0.5, 0.7, 0.4)), glm::normalize(V(-0.4, -0.8, 0.3))};

/// True where two numbers are equal but for rounding.
bool agree(double a, double b) {
  return std::abs(a - b) <= 1e-9 * std::max(std::abs(a), std::abs(b)) + 1e-12;
}

V uniform_direction(gmis::Philox& source) {
  const double u = gmis::uniform<double>(source);
  return gmis::square_to_sphere(gmis::Vec2<T>(u, gmis::uniform<double>(source)));
}

}  // namespace

TEST_CASE("A guided BSDF: samples follow the stated density, in either mode and from either side") {
  // 6 materials, 2 modes, 2 sides, 1 χ² each.
  const double level = gmis::sidak_level(1e-3, 24);
  const Cell cell(1, T(1), gmis_test::seed(31));
  gmis::Philox source(gmis_test::seed(32));
  for (const Named& named : materials())
    for (const TransportMode mode : modes)
      for (const V& to_prev : origins) {
        const Bsdf bsdf(Own(named.material, normal, normal), normal, Lobe(&cell.cell));
        CAPTURE(named.name, static_cast<int>(mode), to_prev.y);
        double delta_share = 0;
        std::size_t mismatches = 0;
        const auto sample = [&]() -> std::optional<V> {
          const auto [u, x, y] = gmis::uniforms<T, 3>(source);
          const auto drawn = bsdf.sample(to_prev, u, {x, y}, mode);
          if (!drawn) return std::nullopt;
          if (drawn->is_delta) {
            delta_share = drawn->pdf.forward.value;
            return std::nullopt;
          }
          // What `sample` states is what `evaluate` states.
          const auto f = bsdf.evaluate(to_prev, drawn->to_next, mode);
          const double cosine = std::abs(glm::dot(normal, drawn->to_next));
          const auto forward = bsdf.sample_forward(to_prev, u, {x, y}, mode);
          const bool is_same = agree(drawn->pdf.forward.value, f.pdf.forward.value) &&
                               agree(drawn->pdf.reverse.value, f.pdf.reverse.value) &&
                               agree(drawn->weight.x, f.value.x * cosine / f.pdf.forward.value) && forward &&
                               forward->to_next == drawn->to_next && forward->weight == drawn->weight;
          if (!is_same) ++mismatches;
          return drawn->to_next;
        };
        const auto pdf = [&](const V& w) { return bsdf.evaluate(to_prev, w, mode).pdf.forward.value; };
        const gmis::CheckSettings settings{30'000, 200, 5, 1e-5};
        const auto check = gmis::check_directions(V(0, 1, 0), sample, pdf, settings);
        CAPTURE(check.integral, check.success_share, delta_share, check.test.p_value);
        CHECK(mismatches == 0);
        CHECK(check.outside == 0);
        CHECK(check.integral + delta_share < 1 + 1e-3);
        CHECK(check.test.passes(level));
      }
}

TEST_CASE("A guided diffuse BSDF: the density integrates to one but for what the lobe has under the surface") {
  const auto diffuse = gmis::scene::make_diffuse<T>({0.5, 0.5, 0.5});
  for (const int axis : {0, 1, 2})
    for (const T sign : {T(1), T(-1)}) {
      const Cell cell(axis, sign, gmis_test::seed(33));
      V along(0.0);
      along[axis] = sign;
      for (const TransportMode mode : modes) {
        const Bsdf bsdf(Own(diffuse, along, along), along, Lobe(&cell.cell));
        const V to_prev = glm::normalize(along + V(0.3, 0.2, 0.25));
        // By the midpoint rule over the square of each table's bins: all there is lies on this
        // hemisphere.
        double sum = 0;
        bool is_above = true;
        constexpr int cells = 256;
        for (int x = 0; x < cells; ++x)
          for (int y = 0; y < cells; ++y) {
            const gmis::Vec2<T> point((x + 0.5) / cells, (y + 0.5) / cells);
            const V local = gmis::square_to_octahedral_hemisphere(point);
            const V w = cell.cell.to_world(true, local);
            is_above = is_above && glm::dot(w, along) > 0;
            sum += bsdf.evaluate(to_prev, w, mode).pdf.forward.value / gmis::octahedral_hemisphere_density(local);
          }
        CHECK(is_above);
        CHECK(sum / (cells * cells) == Approx(1.0).epsilon(1e-4));
      }
    }
}

TEST_CASE("The reverse density of a guided BSDF is the forward density from the other end, in the other mode") {
  gmis::Philox source(gmis_test::seed(34));
  const Cell cell(1, T(1), gmis_test::seed(35));
  std::size_t seen = 0, deltas = 0, wrong = 0;
  const auto expect = [&](bool holds) { wrong += holds ? 0 : 1; };
  for (const Named& named : materials()) {
    CAPTURE(named.name);
    const Bsdf bsdf(Own(named.material, normal, normal), normal, Lobe(&cell.cell));
    const Own own(named.material, normal, normal);
    for (int i = 0; i < 2000; ++i) {
      const V a = uniform_direction(source), b = uniform_direction(source);
      for (const TransportMode mode : modes) {
        const auto there = bsdf.evaluate(a, b, mode), back = bsdf.evaluate(b, a, other(mode));
        const auto plain = own.evaluate(a, b, mode);
        expect(agree(there.pdf.reverse.value, back.pdf.forward.value));
        expect(bsdf.evaluate_forward(a, b, mode).pdf.forward.value == there.pdf.forward.value);
        expect(there.value == plain.value);  // guiding changes no light
        if (gmis::is_black(plain.value)) continue;
        ++seen;
        // The mixture, written down anew.
        const auto mixture = [&](double pdf, const V& from, const V& to, TransportMode of) {
          const bool is_front = glm::dot(normal, from) > 0;
          const auto* table = cell.cell.tables[gmis::GuideCell<T>::place(is_front, of)];
          if (table == nullptr) return pdf;
          const V local(to.z, to.x, is_front ? to.y : -to.y);
          double lobe = 0;
          if (local.z > 0)
            lobe = table->density(gmis::octahedral_hemisphere_to_square(local)) *
                   gmis::octahedral_hemisphere_density(local);
          return 0.5 * pdf + 0.5 * lobe;
        };
        expect(agree(there.pdf.forward.value, mixture(plain.pdf.forward.value, a, b, mode)));
        expect(agree(there.pdf.reverse.value, mixture(plain.pdf.reverse.value, b, a, other(mode))));
      }
      // Delta lobes: the selection probability of the way back.
      const auto u = gmis::uniform<T>(source);
      for (const TransportMode mode : modes) {
        const auto drawn = bsdf.sample(a, u, {0.5, 0.5}, mode);
        if (!drawn || !drawn->is_delta) continue;
        const auto returned = bsdf.sample(drawn->to_next, T(1) - T(1e-9), {0.5, 0.5}, other(mode));
        const auto plain = own.sample(a, T(1) - T(1e-9), {0.5, 0.5}, mode);
        ++deltas;
        expect(returned && returned->is_delta && agree(drawn->pdf.reverse.value, returned->pdf.forward.value));
        expect(agree(drawn->weight.x * drawn->pdf.forward.value, plain->weight.x * plain->pdf.forward.value));
      }
    }
  }
  CHECK(wrong == 0);
  CHECK(seen > 5'000);
  CHECK(deltas > 200);
}

TEST_CASE("The lobes of a guided BSDF: each is drawn with its density, in its mode") {
  // 2 modes, 2 sides, the lobe that is added.
  const double level = gmis::sidak_level(1e-3, 3);
  const Cell cell(1, T(1), gmis_test::seed(36));
  const auto phong = gmis::scene::make_phong<T>({0.3, 0.3, 0.3}, {0.4, 0.4, 0.4}, 12);
  const Bsdf bsdf(Own(phong, normal, normal), normal, Lobe(&cell.cell));
  gmis::Philox source(gmis_test::seed(37));
  REQUIRE(bsdf.lobe_count() == 3);
  CHECK(bsdf.lobe_weight(0) + bsdf.lobe_weight(1) + bsdf.lobe_weight(2) == Approx(1.0));
  const auto diffuse = gmis::scene::make_diffuse<T>({0.5, 0.5, 0.5});
  CHECK(Own(diffuse, normal, normal).lobes_have_full_support());
  CHECK_FALSE(Bsdf(Own(diffuse, normal, normal), normal, Lobe(&cell.cell)).lobes_have_full_support());
  for (const TransportMode mode : modes)
    for (const V& to_prev : origins) {
      const bool is_learned = mode == TransportMode::radiance || to_prev.y > 0;
      const auto sample = [&] {
        const T u = gmis::uniform<T>(source);
        return bsdf.sample_lobe(2, to_prev, {u, gmis::uniform<T>(source)}, mode);
      };
      CHECK(sample().has_value() == is_learned);
      const auto pdf = [&](const V& w) {
        std::array<T, 3> pdfs{};
        bsdf.lobe_pdfs(to_prev, w, pdfs.data(), mode);
        return pdfs[2];
      };
      if (!is_learned) {
        CHECK(pdf(V(0, 1, 0)) == 0.0);
        continue;
      }
      const auto check = gmis::check_directions(V(0, 1, 0), sample, pdf, {30'000, 200, 5, 1e-5});
      CAPTURE(check.integral, check.test.p_value);
      CHECK(check.integral == Approx(1.0).epsilon(1e-3));
      CHECK(check.passes(level, 1e-3));
    }
}

TEST_CASE("A guided BSDF without a lobe is the BSDF") {
  const auto phong = gmis::scene::make_phong<T>({0.3, 0.3, 0.3}, {0.4, 0.4, 0.4}, 12);
  const Own own(phong, normal, normal);
  const Bsdf bsdf(own, normal, Lobe());
  gmis::Philox source(gmis_test::seed(38));
  CHECK(bsdf.lobe_count() == own.lobe_count());
  for (int i = 0; i < 100; ++i) {
    const V a = uniform_direction(source), b = uniform_direction(source);
    const auto [u, x, y] = gmis::uniforms<T, 3>(source);
    CHECK(bsdf.evaluate(a, b, TransportMode::radiance).pdf.reverse.value ==
          own.evaluate(a, b, TransportMode::radiance).pdf.reverse.value);
    const auto drawn = bsdf.sample(a, u, {x, y}, TransportMode::importance);
    const auto plain = own.sample(a, u, {x, y}, TransportMode::importance);
    REQUIRE(drawn.has_value() == plain.has_value());
    if (drawn) CHECK((drawn->to_next == plain->to_next && drawn->weight == plain->weight));
  }
}
