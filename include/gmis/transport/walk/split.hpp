#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>

#include "gmis/transport/settings.hpp"
#include "gmis/transport/walk/children.hpp"

/// \file
/// How many children a vertex has. Two numbers are kept apart: the number of children that are drawn, and the *nominal*
/// number c that enters the weights. The nominal number is a function of the vertex alone, because a subpath from the
/// other end of the path knows nothing else about the vertex.

namespace gmis {

/// Decides how an engine splits subpaths.
///
/// - `P(settings)`: constructs the policy.
/// - `P::splits_light`: whether light trees branch. A policy that splits light trees also has the members `Tally`,
///   `freeze`, `budget`, `stops_at` and `expand` of `QueueSplit`.
/// - `nominal_children(bsdf)`: c of a light subpath at a vertex, without the continuation probability; constant while
///   weights are formed.
/// - `camera_children(pixel)`: the number of children drawn at the first non-specular vertex of a camera subpath.
///   `pixel` is the index of its pixel in the frame.
/// - `nominal_camera_children()`: c of a camera subpath at its first non-specular vertex, without the continuation
///   probability.
/// - `expand_camera(at, children, source, visit)`: draws `children` children of `at` and calls `visit(step)` for each
///   child that goes on.
template <class P, class B>
concept SplitPolicy = Bsdf<B> &&
    requires(const P& policy, const B& bsdf, const ScatteringVertex<B>& at, Philox& source) {
  P(RenderSettings{});
  { P::splits_light } -> std::convertible_to<bool>;
  { policy.nominal_children(bsdf) } -> std::convertible_to<double>;
  { policy.camera_children(std::size_t{}) } -> std::convertible_to<int>;
  { policy.nominal_camera_children() } -> std::convertible_to<int>;
  policy.expand_camera(at, 1, source, [](const Step<typename B::Spectrum>&) {});
};

/// Splits camera subpaths only. Light trees are paths; the first non-specular vertex of a camera subpath has
/// `SampleCounts::camera_children` children, drawn independently of each other.
///
/// The weights are those of a subpath without splitting (c = 1). Any weights that add up to 1 are unbiased; with c = 1
/// a pilot can forecast the variance of every number of children from two children (choose/pilot.hpp).
template <std::floating_point T>
class PathSplit {
 public:
  static constexpr bool splits_light = false;

  PathSplit() = default;
  explicit PathSplit(const RenderSettings& settings) : camera_children_(settings.counts.camera_children) {}

  template <Bsdf B>
  [[nodiscard]] static constexpr T nominal_children(const B&) noexcept {
    return T(1);
  }
  [[nodiscard]] constexpr int camera_children(std::size_t) const noexcept { return camera_children_; }
  [[nodiscard]] static constexpr int nominal_camera_children() noexcept { return 1; }

  template <Bsdf B, UniformSource Source, class Visit>
  void expand_camera(const ScatteringVertex<B>& at, int children, Source& source, Visit&& visit) const {
    draw_independent_children(at, children, children, source, visit);
  }

 private:
  int camera_children_ = 1;
};

/// Splits every non-specular vertex of a light tree into M = kN children, for N lobes and k rounds, while the tree's
/// budget of samples lasts [Liu, Algorithm 1]. Vertices wait in a first-in, first-out queue.
///
/// `LightSplit::paper` is the rule as printed: the queue is dropped at the end of the budget, which loses energy.
/// `LightSplit::budgeted` drops nothing: when the rest of the budget is too small for a full split, one child is drawn
/// from the mixture of all lobes. The decision precedes the draw, so it is unbiased.
///
/// The nominal number of children is the mean number drawn at vertices of one kind (`split_kind`). It is measured over
/// separate light trees, which contribute nothing to the picture. Camera subpaths split at their first non-specular
/// vertex into `SampleCounts::camera_children` children.
template <std::floating_point T>
class QueueSplit {
 public:
  static constexpr bool splits_light = true;

  /// Counts vertices and the children drawn there, by the kind of the vertex.
  class Tally {
   public:
    template <Bsdf B>
    constexpr void count(const B& bsdf, int drawn) noexcept {
      const auto kind = static_cast<std::size_t>(split_kind(bsdf));
      ++vertices_[kind];
      children_[kind] += static_cast<std::uint64_t>(drawn);
    }
    Tally& operator+=(const Tally& other) noexcept {
      for (std::size_t kind = 0; kind < vertices_.size(); ++kind) {
        vertices_[kind] += other.vertices_[kind];
        children_[kind] += other.children_[kind];
      }
      return *this;
    }
    /// Mean number of children drawn at a vertex of this kind; 1 when no vertex or no child was counted.
    [[nodiscard]] constexpr T mean_children(std::size_t kind) const noexcept {
      if (vertices_[kind] == 0 || children_[kind] == 0) return T(1);
      return static_cast<T>(static_cast<double>(children_[kind]) / static_cast<double>(vertices_[kind]));
    }

   private:
    std::array<std::uint64_t, split_kinds> vertices_{}, children_{};
  };

  QueueSplit() : QueueSplit(RenderSettings{}) {}
  explicit QueueSplit(const RenderSettings& settings)
      : scheme_(settings.scheme),
        budget_(settings.light_tree_budget),
        rounds_(settings.light_split == LightSplit::none ? 0 : std::clamp(settings.rounds, 1, 1024)),
        camera_children_(settings.counts.camera_children),
        drops_queue_(settings.light_split == LightSplit::paper) {
    nominal_.fill(T(1));
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
  [[nodiscard]] constexpr int camera_children(std::size_t) const noexcept { return camera_children_; }
  [[nodiscard]] constexpr int nominal_camera_children() const noexcept { return camera_children_; }
  /// True when a tree with this many samples left drops its queue.
  [[nodiscard]] constexpr bool stops_at(int remaining) const noexcept { return drops_queue_ && remaining <= 0; }

  /// Draws the children of a light vertex and calls `visit(step)` for each child that goes on. Returns the number of
  /// samples drawn, which the budget pays for even where a child does not go on.
  template <Bsdf B, UniformSource Source, class Visit>
  int expand(const ScatteringVertex<B>& at, int remaining, Source& source, Visit&& visit) const {
    const int planned = std::max(1, rounds_ * split_kind(at.bsdf));
    if (planned > remaining && !drops_queue_) return draw_children(scheme_, at, 1, 1, source, visit);
    return draw_children(scheme_, at, planned, std::min(planned, std::max(remaining, 0)), source, visit);
  }

  /// Draws the children of the first non-specular vertex of a camera subpath.
  template <Bsdf B, UniformSource Source, class Visit>
  void expand_camera(const ScatteringVertex<B>& at, int children, Source& source, Visit&& visit) const {
    draw_children(scheme_, at, children, children, source, visit);
  }

 private:
  Scheme scheme_;
  int budget_, rounds_, camera_children_;
  bool drops_queue_;
  std::array<T, split_kinds> nominal_;
};

namespace detail {

/// `Split::Tally` where the policy splits light trees; otherwise a tally that counts nothing.
template <class Split, bool splits_light = Split::splits_light>
struct TallyOf {
  struct Type {
    static constexpr void count(const auto&, int) noexcept {}
    Type& operator+=(const Type&) noexcept { return *this; }
  };
};
template <class Split>
struct TallyOf<Split, true> {
  using Type = typename Split::Tally;
};

}  // namespace detail
}  // namespace gmis
