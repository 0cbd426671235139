#pragma once

#include <algorithm>
#include <array>
#include <concepts>
#include <cstddef>
#include <cstdint>

#include "gmis/core/argument_error.hpp"
#include "gmis/transport/splitting/children.hpp"
#include "gmis/transport/splitting/gmis_sampler.hpp"

namespace gmis {

/// Splits every non-specular vertex of a light tree into M = kN children, for N lobes and k rounds,
/// while the tree's budget of samples lasts [Liu, Algorithm 1]. Models `SplitPolicy`.
///
/// Two numbers are kept apart: the number of children that are drawn, and the *nominal* number c
/// that enters the weights. c is the mean number drawn at vertices of one kind (`split_kind`),
/// measured over separate light trees, which contribute nothing to the picture.
/// `TreeBudget::softened` draws one child from the mixture of all lobes where the rest of the
/// budget is too small for a full split. The decision precedes the draw, so it is unbiased.
template <std::floating_point T>
class QueueSplit {
 public:
  using Settings = GmisSampler;              ///< scheme, rounds and budget
  static constexpr bool is_measured = true;  ///< c is measured over separate trees

  /// Counts vertices and the children drawn there, by the kind of the vertex.
  class Tally {
   public:
    /// Counts a vertex with this BSDF and the children drawn there.
    template <Bsdf B>
    constexpr void count(const B& bsdf, int drawn) noexcept {
      const auto kind = static_cast<std::size_t>(split_kind(bsdf));
      ++vertices_[kind];
      children_[kind] += static_cast<std::uint64_t>(drawn);
    }
    /// Adds the vertices and children that `other` has counted.
    Tally& operator+=(const Tally& other) noexcept {
      for (std::size_t kind = 0; kind < vertices_.size(); ++kind) {
        vertices_[kind] += other.vertices_[kind];
        children_[kind] += other.children_[kind];
      }
      return *this;
    }
    /// Mean number of children drawn at a vertex of this kind; 1 when no vertex or no child was
    /// counted.
    [[nodiscard]] constexpr T mean_children(std::size_t kind) const noexcept {
      if (vertices_[kind] == 0 || children_[kind] == 0) return T(1);
      return static_cast<T>(static_cast<double>(children_[kind]) / static_cast<double>(vertices_[kind]));
    }

   private:
    std::array<std::uint64_t, split_kinds> vertices_{}, children_{};
  };

  /// c is 1 for every kind of vertex until `freeze`. Rounds are clamped to [1, 1024].
  explicit QueueSplit(const Settings& settings)
      : scheme_(settings.scheme),
        budget_(settings.budget),
        rounds_(std::clamp(settings.rounds, 1, 1024)),
        is_cut_(settings.at_end_of_budget == TreeBudget::cut) {
    nominal_.fill(T(1));
  }

  /// Refuses settings that light trees over BSDFs of type `B` cannot be traced with.
  template <Bsdf B>
  static void validate(const Settings& settings, int max_depth) {
    constexpr double most_keys = 1 << 24;  // a vertex key has 24 bits (core/random.hpp)
    require_argument(settings.budget >= 1 && (settings.budget + 1.0) * max_depth < most_keys,
                     "GmisSampler::budget must be 1 or more, and below 2^24 when multiplied by max_depth");
    require_argument(BsdfWithLobes<B> || settings.rounds > 1,
                     "the scene's BSDF names no lobes and GmisSampler::rounds is 1: no vertex would be split. "
                     "Model gmis::BsdfWithLobes, choose more rounds, or use Engine<Scene>");
  }

  /// Sets the nominal numbers of children to the means of `tally`.
  constexpr void freeze(const Tally& tally) noexcept {
    for (std::size_t kind = 0; kind < nominal_.size(); ++kind) nominal_[kind] = tally.mean_children(kind);
  }

  /// c of the path weights at a light vertex, without the continuation probability.
  template <Bsdf B>
  [[nodiscard]] constexpr T nominal_children(const B& bsdf) const noexcept {
    return nominal_[static_cast<std::size_t>(split_kind(bsdf))];
  }
  /// Samples that one light tree may draw before it stops splitting.
  [[nodiscard]] constexpr int budget() const noexcept { return budget_; }
  /// True when a tree with this many samples left drops its queue.
  [[nodiscard]] constexpr bool stops_at(int remaining) const noexcept { return is_cut_ && remaining <= 0; }

  /// Draws the children of a light vertex and calls `visit(step)` for each child that goes on.
  /// Returns the number of samples drawn, which the budget pays for even where a child does not go
  /// on.
  template <Bsdf B, UniformSource Source, class Visit>
  int expand(const ScatteringVertex<B>& at, int remaining, Source& source, Visit&& visit) const {
    const int full = std::max(1, rounds_ * split_kind(at.bsdf)), planned = full > remaining && !is_cut_ ? 1 : full;
    const int drawn = is_cut_ ? std::min(planned, std::max(remaining, 0)) : planned;
    draw_children(scheme_, at, planned, drawn, source, visit);
    return drawn;
  }

 private:
  Scheme scheme_;
  int budget_, rounds_;
  bool is_cut_;
  std::array<T, split_kinds> nominal_;
};

}  // namespace gmis
