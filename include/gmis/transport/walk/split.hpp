#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>

#include "gmis/transport/settings.hpp"
#include "gmis/transport/walk/children.hpp"

/// \file
/// How many children a vertex has. Two numbers are kept apart: the children that are drawn, and the *nominal* number that
/// enters the weights. The nominal number is a function of the vertex alone, because a subpath from the other end cannot
/// know more.

namespace gmis {

/// How an engine splits subpaths.
///
/// - `P(settings)`.
/// - `P::splits_light`: whether light trees have more than one branch. If so, the policy also offers what `QueueSplit` has.
/// - `nominal_children(bsdf)`: of a light subpath, without survival; frozen before weights are formed.
/// - `camera_children(pixel)`: at the first non-specular vertex of the camera subpath of a pixel (its place in the frame).
/// - `nominal_camera_children()`: their number in the weights.
/// - `expand_camera(at, children, source, visit)`: draws them and calls `visit(step)` for those that go on.
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

/// Light trees are paths. The first non-specular vertex of a camera subpath has `SampleCounts::camera_children` children,
/// drawn independently of each other. The weights are those of a path that is not split: any weights that add up to 1
/// serve, and with these the saving follows from the children of one vertex alone (choose/pilot.hpp).
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
  [[nodiscard]] int camera_children(std::size_t) const noexcept { return camera_children_; }
  [[nodiscard]] static constexpr int nominal_camera_children() noexcept { return 1; }

  template <Bsdf B, UniformSource Source, class Visit>
  void expand_camera(const ScatteringVertex<B>& at, int children, Source& source, Visit&& visit) const {
    draw_independent_children(at, children, children, source, visit);
  }

 private:
  int camera_children_ = 1;
};

/// Splits every non-specular vertex of a light tree into M = kN children, for N lobes, while the tree's budget of samples
/// lasts. The vertices wait in a queue, first come first served. `LightSplit::paper` is the paper's rule as printed: at the
/// end of the budget the queue is dropped, which loses energy. With `LightSplit::budgeted` nothing is dropped: when the
/// rest of the budget does not allow a full split, one child is drawn from the mixture. The decision precedes the draw, so
/// it is unbiased.
///
/// The nominal number is the mean number of children drawn at vertices of one kind (`split_kind`), measured over trees that
/// are used for nothing else. The camera subpath is split at its first non-specular vertex, always by the same number.
template <std::floating_point T>
class QueueSplit {
 public:
  static constexpr bool splits_light = true;

  /// Counts the children drawn, by the kind of their vertex.
  class Tally {
   public:
    template <Bsdf B>
    void count(const B& bsdf, int drawn) noexcept {
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
    /// The mean number at a vertex of this kind; 1 where none was seen.
    [[nodiscard]] T mean_children(std::size_t kind) const noexcept {
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

  void freeze(const Tally& tally) noexcept {
    for (std::size_t kind = 0; kind < nominal_.size(); ++kind) nominal_[kind] = tally.mean_children(kind);
  }

  /// c of the path weights, without survival.
  template <Bsdf B>
  [[nodiscard]] T nominal_children(const B& bsdf) const noexcept {
    return nominal_[static_cast<std::size_t>(split_kind(bsdf))];
  }
  [[nodiscard]] int budget() const noexcept { return budget_; }
  [[nodiscard]] int camera_children(std::size_t) const noexcept { return camera_children_; }
  [[nodiscard]] int nominal_camera_children() const noexcept { return camera_children_; }
  [[nodiscard]] bool stops_at(int remaining) const noexcept { return drops_queue_ && remaining <= 0; }

  /// Draws the children of a light vertex and hands those that go on to `visit(step)`; returns the number of samples taken
  /// from the budget, lost ones included.
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

/// The tally of a policy that splits light trees; of another one, nothing.
template <class Split, bool splits_light = Split::splits_light>
struct TallyOf {
  struct Type {
    static void count(const auto&, int) noexcept {}
    Type& operator+=(const Type&) noexcept { return *this; }
  };
};
template <class Split>
struct TallyOf<Split, true> {
  using Type = typename Split::Tally;
};

}  // namespace detail
}  // namespace gmis
