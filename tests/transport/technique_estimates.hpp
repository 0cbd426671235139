#pragma once

#include <array>
#include <cmath>
#include <cstddef>

#include "gmis/core/statistics.hpp"
#include "support/catch.hpp"
#include "support/series.hpp"
#include "transport/shifted_lattice.hpp"
#include "transport/ways.hpp"

namespace gmis_test {

/// The image mean (of one channel) that each technique gives by itself, with the weight 1, and what
/// all of them give together, by number of edges.
class TechniqueEstimates {
 public:
  static constexpr std::size_t most_edges = 12;

  /// The light along paths of `edges` edges, as one technique alone estimates it.
  [[nodiscard]] const Series& alone(gmis::Technique technique, int edges) const {
    return alone_[static_cast<std::size_t>(technique)][static_cast<std::size_t>(edges)];
  }
  /// The light along paths of `edges` edges, by all techniques with their weights.
  [[nodiscard]] const Series& together(int edges) const { return together_[static_cast<std::size_t>(edges)]; }
  /// The image.
  [[nodiscard]] const Series& image() const { return image_; }

  template <class Engine>
  void add(const Engine& engine) {
    using S = typename Engine::S;
    const double share = 1.0 / static_cast<double>(engine.frame().size());
    std::array<std::array<double, most_edges + 1>, 5> alone{};
    std::array<double, most_edges + 1> together{};
    engine.for_each_contribution([&](const gmis::Contribution<S>& record) {
      const int edges = record.id.s + record.id.t - (record.id.technique == gmis::Technique::merge ? 2 : 1);
      const double value = share * static_cast<double>(gmis::SpectrumTraits<S>::channel(record.value, 0));
      alone[static_cast<std::size_t>(record.id.technique)][static_cast<std::size_t>(edges)] += value;
      together[static_cast<std::size_t>(edges)] += value * static_cast<double>(record.weight);
    });
    for (std::size_t technique = 0; technique < 5; ++technique)
      for (std::size_t edges = 1; edges <= most_edges; ++edges) alone_[technique][edges].add(alone[technique][edges]);
    for (std::size_t edges = 1; edges <= most_edges; ++edges) together_[edges].add(together[edges]);
    double mean = 0.0;
    for (const S& pixel : engine.frame())
      mean += share * static_cast<double>(gmis::SpectrumTraits<S>::channel(pixel, 0));
    image_.add(mean);
  }

 private:
  std::array<std::array<Series, most_edges + 1>, 5> alone_;
  std::array<Series, most_edges + 1> together_;
  Series image_;
};

template <class Integrator, class Source = ShiftedLattice, class Scene>
[[nodiscard]] TechniqueEstimates estimate(const Scene& scene, const ways::Settings& settings, int iterations) {
  typename Integrator::template Engine<Scene, Source> engine(scene, Integrator::settings(settings));
  engine.keep_contributions(true);
  gmis::SerialExecutor executor;
  TechniqueEstimates estimates;
  for (int i = 0; i < iterations; ++i) {
    engine.iterate(executor);
    estimates.add(engine);
  }
  CHECK(engine.counters().rejected_non_finite + engine.counters().rejected_negative == 0);
  return estimates;
}

/// Level of one comparison so that a hundred of them raise a false alarm in a thousandth of the
/// runs.
inline const double single_level = gmis::sidak_level(1e-3, 100);

/// Is the estimate compatible with the closed form? `power`: the relative standard error must be
/// below this, so that the test means something. `bias`: relative, of merging.
inline void check_closed_form(const char* what, const Series& series, double truth, double power, double bias = 0.0) {
  const double off = series.mean() - truth;
  const double beyond = std::copysign(std::max(0.0, std::abs(off) - bias * truth), off);
  const auto test = gmis::t_test(truth + beyond, series.standard_error(), series.count(), truth);
  CAPTURE(what, series.mean(), truth, series.mean() / truth - 1.0, series.standard_error() / truth, test.statistic);
  // An estimate without noise may be off by rounding.
  CHECK((test.passes(single_level) || std::abs(off) < 1e-5 * truth));
  CHECK(series.standard_error() < power * truth);
}

}  // namespace gmis_test
