#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <optional>

#include "gmis/transport/lobe_proposals.hpp"
#include "gmis/transport/scatter.hpp"
#include "gmis/transport/settings.hpp"

#include "gmis/transport/vertex.hpp"

/// \file
/// How many children a vertex of a light tree has, and how they are drawn. A policy is `Split::Policy<T>`; the nominal
/// number of children that enters the weights is a function of the vertex alone (its kind: how many lobes it has),
/// measured by a pilot and frozen, because a camera subpath cannot know how much of a light tree's budget was left.

namespace gmis {

/// One child everywhere: a light tree is a path.
struct NoSplit {
  static constexpr bool splits = false;

  template <std::floating_point T>
  struct Policy {
    Policy() = default;
    explicit Policy(const RenderSettings&) {}
    template <Bsdf B>
    [[nodiscard]] static constexpr T nominal_children(const B&) noexcept {
      return T(1);
    }
  };
};

namespace detail {

inline constexpr int split_kinds = 17;  // by number of lobes; more count as the last

template <Bsdf B>
[[nodiscard]] int split_kind(const B& bsdf) noexcept {
  if constexpr (BsdfWithLobes<B>)
    return std::clamp(static_cast<int>(bsdf.lobe_count()), 0, split_kinds - 1);
  else
    return bsdf.is_purely_delta() ? 0 : 1;
}

}  // namespace detail

/// Splits every non-specular vertex into M = kN children while the tree's budget of samples lasts. The vertices wait in
/// a queue, first come first served. `drops_queue` is the paper's rule as printed: at the end of the budget whatever
/// waits is dropped, which loses energy. Otherwise nothing is dropped: where what remains does not allow a full split,
/// one child is drawn from the mixture. That is decided before the draw, so it is unbiased.
template <bool drops_queue>
struct QueueSplit {
  static constexpr bool splits = true;

  template <std::floating_point T>
  class Pilot {
   public:
    template <Bsdf B>
    void count(const B& bsdf, int drawn) {
      const auto kind = static_cast<std::size_t>(detail::split_kind(bsdf));
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
    /// The mean number of children drawn at a vertex of this kind; 1 where none was seen.
    [[nodiscard]] T mean_children(std::size_t kind) const {
      if (vertices_[kind] == 0 || children_[kind] == 0) return T(1);
      return static_cast<T>(static_cast<double>(children_[kind]) / static_cast<double>(vertices_[kind]));
    }

   private:
    std::array<std::uint64_t, detail::split_kinds> vertices_{}, children_{};
  };

  template <std::floating_point T>
  class Policy {
   public:
    Policy() { nominal_.fill(T(1)); }
    explicit Policy(const RenderSettings& settings)
        : scheme_(settings.scheme), rounds_(std::max(1, settings.rounds)), budget_(settings.light_tree_budget) {
      nominal_.fill(T(1));
    }

    void freeze(const Pilot<T>& pilot) {
      for (std::size_t kind = 0; kind < nominal_.size(); ++kind) nominal_[kind] = pilot.mean_children(kind);
    }

    /// c of the path weights, without survival.
    template <Bsdf B>
    [[nodiscard]] T nominal_children(const B& bsdf) const noexcept {
      return nominal_[static_cast<std::size_t>(detail::split_kind(bsdf))];
    }

    [[nodiscard]] int budget() const noexcept { return budget_; }
    [[nodiscard]] static constexpr bool stops_at(int remaining) noexcept { return drops_queue && remaining <= 0; }

    /// Draws the children of `at`, of which the tree may still have `remaining`; calls `visit(step)` for each that
    /// survives and returns how many samples were drawn.
    template <class Vertex, UniformSource Source, class Visit>
    int expand(const Vertex& at, int remaining, Source& source, Visit&& visit) const {
      const T survival = survival_probability(at.bsdf);
      const int planned = planned_children(at.bsdf);
      if (planned > remaining && !drops_queue) return draw_singles(at, survival, 1, 1, source, visit);
      const int drawn = std::min(planned, std::max(remaining, 0));
      if constexpr (BsdfWithLobes<decltype(at.bsdf)>)
        if (at.bsdf.lobe_count() > 1) return draw_rounds(at, survival, planned, drawn, source, visit);
      return draw_singles(at, survival, planned, drawn, source, visit);
    }

   private:
    template <Bsdf B>
    [[nodiscard]] int planned_children(const B& bsdf) const noexcept {
      if (bsdf.is_purely_delta()) return 1;
      return rounds_ * std::max(1, detail::split_kind(bsdf));
    }

    /// `drawn` of `planned` independent children from the mixture of all lobes.
    template <class Vertex, UniformSource Source, class Visit>
    static int draw_singles(const Vertex& at, T survival, int planned, int drawn, Source& source, Visit&& visit) {
      for (int i = 0; i < drawn; ++i)
        if (auto step =
                scatter(at.bsdf, at.point, at.to_prev, TransportMode::importance, survival, at.children, source)) {
          if (planned > 1) step->weight = step->weight * (T(1) / static_cast<T>(planned));
          visit(*step);
        }
      return drawn;
    }

    template <class Vertex, UniformSource Source, class Visit>
    int draw_rounds(const Vertex& at, T survival, int planned, int drawn, Source& source, Visit&& visit) const {
      int left = drawn;
      for (int round = 0; round < rounds_; ++round)
        sample_lobes(scheme_, at.bsdf, at.to_prev, TransportMode::importance, source,
                     [&](const Vec3<T>& to_next, T denominator) {
                       const T u_survival = uniform<T>(source);
                       if (left-- <= 0 || u_survival >= survival) return;
                       const auto f = at.bsdf.evaluate(at.to_prev, to_next, TransportMode::importance);
                       const T cosine = scattering_cosine(at.point, at.to_prev, to_next, TransportMode::importance);
                       const auto weight = f.value * (cosine / (denominator * static_cast<T>(planned) * survival));
                       if (is_black(weight)) return;
                       visit(Step<typename Vertex::S>{to_next, weight, at.children.forward * f.pdf.forward.value,
                                                      at.children.reverse * f.pdf.reverse.value, false});
                     });
      return drawn;
    }

    Scheme scheme_ = Scheme::N3;
    int rounds_ = 1;
    int budget_ = 20;
    std::array<T, detail::split_kinds> nominal_;
  };
};

using BudgetedSplit = QueueSplit<false>;
using PaperSplit = QueueSplit<true>;

}  // namespace gmis
