#pragma once

#include <cstdint>
#include <optional>

#include "gmis/core/attributes.hpp"
#include "gmis/transport/walk/light_subpath.hpp"

namespace gmis {

/// Traces a light subpath that does not split.
template <class Context, class Output>
class LightPath : LightSubpath<Context, Output> {
  using Base = LightSubpath<Context, Output>;
  using typename Base::Sc, typename Base::T, typename Base::Vertex;

 public:
  using typename Base::Chunk;

  LightPath(const Context& context, Output& output) : Base(context, output) {}

  /// Traces one subpath. `stored` receives the vertices for connections and merging; null keeps
  /// none.
  template <UniformSource Source>
  void trace(Source source, Chunk* stored, typename Context::Split::Tally* /*children*/ = nullptr) {
    if (this->context_.max_depth < 2) return;  // only camera subpaths make light that is seen directly
    ++this->output_.counters().light_subpaths;
    source.at_vertex(0);
    if constexpr (GuidableLight<typename Sc::Light>)
      if (this->context_.guide != nullptr) [[unlikely]] {
        follow_apart<true>(source, stored);
        return;
      }
    if constexpr (detail::is_hot_walk<Context, Output>)
      follow_flat(source, stored);
    else
      follow_apart<false>(source, stored);
  }

 private:
  /// One flat function: an iteration of photon mapping takes 6 % fewer instructions than with
  /// calls, one of vertex connection and merging 2 %.
  template <UniformSource Source>
  GMIS_FLATTEN void follow_flat(Source& source, Chunk* stored) {
    follow<false>(source, stored);
  }
  /// With a guide of emission the path is compiled apart, so that runs without one do no work for
  /// it.
  template <bool is_guided, UniformSource Source>
  GMIS_NEVER_INLINE void follow_apart(Source& source, Chunk* stored) {
    follow<is_guided>(source, stored);
  }
  template <bool is_guided, UniformSource Source>
  void follow(Source& source, Chunk* stored) {
    std::optional<Vertex> first = this->template emit<is_guided>(source);
    if (!first) return;
    Vertex& vertex = *first;
    std::uint32_t number = 0;  // number of the vertex in its path; it keys the vertex's random numbers
    for (;;) {
      source.at_vertex(++number);
      this->use(vertex, source, stored);
      if (!this->goes_on(vertex)) return;
      const auto step = scatter(this->scattering_at(vertex), source);
      if (!step) return;
      if (!this->arrive(vertex, *step)) return;
    }
  }
};

}  // namespace gmis
