#include "gmis/transport/splitting/children.hpp"

#include <array>
#include <cmath>
#include <cstdint>
#include <optional>
#include <vector>

#include "gmis/scene/bsdf.hpp"
#include "gmis/transport/splitting/queue_split.hpp"
#include "support/catch.hpp"
#include "support/family.hpp"
#include "support/seed.hpp"
#include "support/series.hpp"

// The children of one vertex, without an engine: a Phong surface, which has two lobes, seen along
// its normal, so that no sample of a lobe falls below the surface.

namespace {

using gmis::TransportMode;
using gmis::Vec3;
using Bsdf = gmis::scene::SurfaceBsdf<double>;
using Step = gmis::Step<Bsdf::Spectrum>;

constexpr double diffuse = 0.4, glossy = 0.3;

template <class B>
class Vertex {
 public:
  explicit Vertex(double survival) : at{bsdf, point_, axis_, TransportMode::importance, survival, {1, 1}, {1, 1}} {}

 private:
  const Vec3<double> axis_{0, 0, 1};
  const gmis::scene::Material<double> material_ =
      gmis::scene::make_phong<double>(glm::dvec3(diffuse), glm::dvec3(glossy), 8);
  const gmis::SurfacePoint<double> point_{{}, axis_, axis_};

 public:
  const B bsdf{material_, axis_, axis_};
  const gmis::ScatteringVertex<B> at;
};

void check_same(const Step& step, const Step& single, double share) {
  CHECK(step.to_next == single.to_next);
  CHECK(step.weight.x == single.weight.x * share);
  CHECK(step.forward == single.forward);
  CHECK(step.reverse == single.reverse);
}

/// Notes the mode in which the densities of its lobes are asked for.
struct WithModes : Bsdf {
  using Bsdf::Bsdf;
  void lobe_pdfs(const Vec3<double>& to_prev, const Vec3<double>& to_next, double* pdfs,
                 TransportMode mode = TransportMode::radiance) const {
    Bsdf::lobe_pdfs(to_prev, to_next, pdfs);
    asked_for = mode;
  }
  mutable std::optional<TransportMode> asked_for;
};

}  // namespace

TEST_CASE("independent children are the first of single draws, each with its share of the weight") {
  const Vertex<Bsdf> vertex(0.9);
  for (std::uint32_t round = 0; round < 100; ++round) {
    gmis::Philox alone(gmis_test::seed(3), round), together(gmis_test::seed(3), round);
    std::vector<Step> single, steps;
    for (int i = 0; i < 2; ++i)
      if (const auto step = gmis::scatter(vertex.at, alone)) single.push_back(*step);
    // Three children are no round of two lobes.
    gmis::draw_children(gmis::Scheme::N3, vertex.at, 3, 2, together, [&](const Step& step) { steps.push_back(step); });
    REQUIRE(steps.size() == single.size());
    for (std::size_t i = 0; i < steps.size(); ++i) check_same(steps[i], single[i], 1.0 / 3.0);
  }
}

TEST_CASE("rounds of children survive at their rate, and their weights add up to the albedo") {
  constexpr double survival = 0.9;
  constexpr int vertices = 25'000, planned = 4;
  const Vertex<Bsdf> vertex(survival);
  // In one of a thousand seeds a sound sampler fails.
  gmis_test::Family family(1e-3, 2 * gmis::all_schemes.size());
  for (const gmis::Scheme scheme : gmis::all_schemes) {
    gmis::Philox source(gmis_test::seed(4), static_cast<std::uint32_t>(scheme));
    double survivors = 0;
    gmis_test::Series weights;
    for (int i = 0; i < vertices; ++i) {
      double sum = 0;
      gmis::draw_children(scheme, vertex.at, planned, planned, source, [&](const Step& step) {
        survivors += 1;
        sum += step.weight.x;
      });
      weights.add(sum);
    }
    constexpr double drawn = static_cast<double>(vertices) * planned;
    CAPTURE(name_of(scheme), survivors / drawn, weights.mean(), weights.standard_error());
    CHECK(std::abs(survivors / drawn - survival) <
          family.limit(vertices) * std::sqrt(survival * (1 - survival) / drawn));
    CHECK(std::abs(weights.mean() - (diffuse + glossy)) < family.limit(vertices) * weights.standard_error());
  }
  CHECK(family.is_complete());
}

TEST_CASE(
    "where the rest of the budget is too small for a round, a softened tree draws one child, a cut one the rest") {
  const Vertex<Bsdf> vertex(1.0);
  gmis::GmisSampler settings;
  settings.rounds = 2;
  const auto expand = [&](int remaining, std::vector<Step>& steps) {
    gmis::Philox source(gmis_test::seed(5));
    return gmis::QueueSplit<double>(settings).expand(vertex.at, remaining, source,
                                                     [&](const Step& step) { steps.push_back(step); });
  };
  std::vector<Step> whole, one, rest;
  CHECK(expand(4, whole) == 4);
  CHECK(whole.size() == 4);
  CHECK(expand(3, one) == 1);
  gmis::Philox alone(gmis_test::seed(5));
  const auto single = gmis::scatter(vertex.at, alone);
  REQUIRE(single);
  REQUIRE(one.size() == 1);
  check_same(one[0], *single, 1.0);
  settings.at_end_of_budget = gmis::TreeBudget::cut;
  CHECK(expand(3, rest) == 3);
  CHECK(rest.size() == 3);
}

TEST_CASE("the densities of lobes are asked for in the mode of the vertex") {
  const Vertex<WithModes> vertex(1.0);
  std::array<double, WithModes::max_lobes> pdfs{};
  for (const TransportMode mode : {TransportMode::importance, TransportMode::radiance}) {
    gmis::LobeProposals<WithModes>(vertex.bsdf, {0, 0, 1}, mode).pdfs({0, 0, 1}, pdfs);
    CHECK(vertex.bsdf.asked_for == mode);
  }
}
