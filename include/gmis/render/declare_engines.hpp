#pragma once

#include "gmis/render/automatic_request.hpp"
#include "gmis/render/render.hpp"

/// \file
/// Two lines by which a project compiles the engines of its scene once, in one of its files, and
/// not in every file that renders. Both stand outside of all namespaces.
///
/// - `GMIS_DECLARE_ENGINES(MyScene)`: in the header that declares the scene, after its definition.
/// - `GMIS_DEFINE_ENGINES(MyScene)`: in one source file.

/// The engines of this scene, with their pilot and `automatic_request`, are compiled in another
/// file.
#define GMIS_DECLARE_ENGINES(...)                                                                                 \
  extern template gmis::RenderRequest gmis::automatic_request(const __VA_ARGS__&, const gmis::Budget&, int,       \
                                                              gmis::RenderSettings);                              \
  extern template gmis::EngineMaker<typename __VA_ARGS__::Spectrum> gmis::engines_with_pilot(const __VA_ARGS__&); \
  extern template class gmis::RenderRun<typename __VA_ARGS__::Spectrum>

/// Compiles the engines of this scene here.
#define GMIS_DEFINE_ENGINES(...)                                                                           \
  template gmis::RenderRequest gmis::automatic_request(const __VA_ARGS__&, const gmis::Budget&, int,       \
                                                       gmis::RenderSettings);                              \
  template gmis::EngineMaker<typename __VA_ARGS__::Spectrum> gmis::engines_with_pilot(const __VA_ARGS__&); \
  template class gmis::RenderRun<typename __VA_ARGS__::Spectrum>
