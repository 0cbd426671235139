#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "gmis/transport/walk/light_subpath.hpp"

namespace gmis {

/// Traces the tree of light subpaths that starts at one emission, breadth first [Liu, Algorithm 1].
/// Vertices are stored and connected with the camera in the order in which they are made. The split
/// policy of the context decides how many children a vertex has.
template <class Context, class Output>
class LightTree : LightSubpath<Context, Output> {
  using Base = LightSubpath<Context, Output>;
  using typename Base::Sc, typename Base::S, typename Base::Vertex;
  using Tally = typename Context::Split::Tally;

 public:
  using typename Base::Chunk;

  /// Context and output must outlive this.
  LightTree(const Context& context, Output& output) : Base(context, output) {}

  /// Traces one tree. `stored` receives the vertices for connections and merging; null keeps none.
  /// `children`, unless it is null, counts the children drawn at each vertex.
  template <UniformSource Source>
  void trace(Source source, Chunk* stored, Tally* children = nullptr) {
    if (this->context_.max_depth < 2) return;  // only camera subpaths make light that is seen directly
    ++this->output_.counters().light_subpaths;
    source.at_vertex(0);
    if constexpr (GuidableLight<typename Sc::Light>)
      if (this->context_.guide != nullptr) {
        follow<true>(source, stored, children);
        return;
      }
    follow<false>(source, stored, children);
  }

 private:
  template <bool is_guided, UniformSource Source>
  void follow(Source& source, Chunk* stored, Tally* children) {
    const auto& split = this->context_.split;
    const std::optional<Vertex> first = this->template emit<is_guided>(source);
    std::uint32_t number = 0;
    int remaining = split.budget();
    queue_.clear();
    if (first) queue_.push_back(*first);
    for (std::size_t next = 0; next < queue_.size(); ++next) {
      const Vertex at = queue_[next];  // a copy, because the queue reallocates when it grows
      source.at_vertex(++number);
      this->use(at, source, stored);
      if (!this->goes_on(at) || split.stops_at(remaining)) continue;
      const int drawn = split.expand(this->scattering_at(at), remaining, source, [&](const Step<S>& step) {
        Vertex child = at;
        if (this->arrive(child, step)) queue_.push_back(child);
      });
      if (children != nullptr) children->count(at.bsdf, drawn);
      remaining -= drawn;
    }
  }

  std::vector<Vertex> queue_;  // reused for every tree, so that it stops allocating
};

}  // namespace gmis
