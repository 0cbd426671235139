#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>

#include "gmis/transport/children.hpp"
#include "gmis/transport/settings.hpp"
#include "gmis/transport/tuning.hpp"

/// \file
/// How many children a vertex of a light tree has, and how they are drawn. A policy is `Split::Policy<T>`; the nominal
/// number of children that enters the weights is a function of the vertex alone (its kind: how many lobes it has),
/// measured by a pilot and frozen, because a camera subpath cannot know how much of a light tree's budget was left.

namespace gmis {

/// One child everywhere: a light tree is a path.
struct NoSplit {
  static constexpr bool splits_light = false, splits_camera = false;

  template <std::floating_point T>
  struct Policy {
    Policy() = default;
    explicit Policy(const RenderSettings&) {}
    static constexpr void plan(const Tuning&) noexcept {}
    template <Bsdf B>
    [[nodiscard]] static constexpr T nominal_children(const B&) noexcept {
      return T(1);
    }
  };
};

/// The first non-specular vertex of a camera subpath has `RenderSettings::camera_children` children, drawn independently
/// of each other; light trees are paths. The weights are those of a path that is not split: any weights that add up to 1
/// will do, and with these what splitting saves follows from the children of one vertex alone (pilot.hpp).
struct CameraSplit {
  static constexpr bool splits_light = false, splits_camera = true;

  template <std::floating_point T>
  class Policy {
   public:
    Policy() = default;
    explicit Policy(const RenderSettings&) {}
    void plan(const Tuning& tuning) noexcept { camera_children_ = tuning.camera_children; }
    template <Bsdf B>
    [[nodiscard]] static constexpr T nominal_children(const B&) noexcept {
      return T(1);
    }
    [[nodiscard]] static constexpr int nominal_camera_children() noexcept { return 1; }
    /// Of the camera subpath of a pixel, by its place in the frame.
    [[nodiscard]] int camera_children(std::size_t) const noexcept { return camera_children_; }

    template <Bsdf B, UniformSource Source, class Visit>
    void expand_camera(const ScatteringVertex<B>& at, int children, Source& source, Visit&& visit) const {
      draw_independent_children(at, children, children, source, visit);
    }

   private:
    int camera_children_ = 1;
  };
};

/// Splits every non-specular vertex into the planned number of children (by default M = kN, for N lobes) while the
/// tree's budget of samples lasts. The vertices wait in a queue, first come first served. `drops_queue` is the paper's
/// rule as printed: at the end of the budget whatever waits is dropped, which loses energy. Otherwise nothing is
/// dropped: where what remains does not allow a full split, one child is drawn from the mixture. That is decided before
/// the draw, so it is unbiased.
///
/// The camera subpath is split at its first non-specular vertex, always by the same number: no pilot is needed there.
template <bool drops_queue>
struct QueueSplit {
  static constexpr bool splits_light = true, splits_camera = true;

  template <std::floating_point T>
  class Pilot {
   public:
    template <Bsdf B>
    void count(const B& bsdf, int drawn) {
      const auto kind = static_cast<std::size_t>(split_kind(bsdf));
      ++vertices_[kind];
      children_[kind] += static_cast<std::uint64_t>(drawn);
    }
    Pilot& operator+=(const Pilot& other) {
      for (std::size_t kind = 0; kind < vertices_.size(); ++kind) {
        vertices_[kind] += other.vertices_[kind];
        children_[kind] += other.children_[kind];
      }
      return *this;
    }
    [[nodiscard]] bool has_seen(std::size_t kind) const noexcept { return vertices_[kind] > 0; }
    /// The mean number of children drawn at a vertex of this kind; 1 where none was seen.
    [[nodiscard]] T mean_children(std::size_t kind) const {
      if (vertices_[kind] == 0 || children_[kind] == 0) return T(1);
      return static_cast<T>(static_cast<double>(children_[kind]) / static_cast<double>(vertices_[kind]));
    }

   private:
    std::array<std::uint64_t, split_kinds> vertices_{}, children_{};
  };

  template <std::floating_point T>
  class Policy {
   public:
    Policy() { nominal_.fill(T(1)); }
    explicit Policy(const RenderSettings& settings) : scheme_(settings.scheme), budget_(settings.light_tree_budget) {
      nominal_.fill(T(1));
    }

    void plan(const Tuning& tuning) noexcept {
      planned_ = tuning.light_children;
      camera_children_ = tuning.camera_children;
    }
    void freeze(const Pilot<T>& pilot) {
      for (std::size_t kind = 0; kind < nominal_.size(); ++kind) nominal_[kind] = pilot.mean_children(kind);
    }

    /// c of the path weights, without survival.
    template <Bsdf B>
    [[nodiscard]] T nominal_children(const B& bsdf) const noexcept {
      return nominal_[static_cast<std::size_t>(split_kind(bsdf))];
    }
    [[nodiscard]] int budget() const noexcept { return budget_; }
    [[nodiscard]] int camera_children(std::size_t) const noexcept { return camera_children_; }
    /// As many as enter the weights.
    [[nodiscard]] int nominal_camera_children() const noexcept { return camera_children_; }
    [[nodiscard]] bool stops_at(int remaining) const noexcept { return drops_queue && remaining <= 0; }

    /// Draws the children of a light vertex and hands those that go on to `visit(step)`; returns how many samples that
    /// took of the budget, lost ones included.
    template <Bsdf B, UniformSource Source, class Visit>
    int expand(const ScatteringVertex<B>& at, int remaining, Source& source, Visit&& visit) const {
      const int planned = planned_[static_cast<std::size_t>(split_kind(at.bsdf))];
      if (planned > remaining && !drops_queue) return draw_children(scheme_, at, 1, 1, source, visit);
      return draw_children(scheme_, at, planned, std::min(planned, std::max(remaining, 0)), source, visit);
    }

    /// Draws the children of the first non-specular vertex of a camera subpath.
    template <Bsdf B, UniformSource Source, class Visit>
    void expand_camera(const ScatteringVertex<B>& at, int children, Source& source, Visit&& visit) const {
      draw_children(scheme_, at, children, children, source, visit);
    }

   private:
    Scheme scheme_ = Scheme::N3;
    int budget_ = 20;
    int camera_children_ = 1;
    std::array<std::int16_t, split_kinds> planned_ = Tuning{}.light_children;
    std::array<T, split_kinds> nominal_;
  };
};

using BudgetedSplit = QueueSplit<false>;
using PaperSplit = QueueSplit<true>;

}  // namespace gmis
