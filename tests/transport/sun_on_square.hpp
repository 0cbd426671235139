#pragma once

#include <cmath>
#include <cstdint>

#include "gmis/core/math.hpp"
#include "gmis/core/statistics.hpp"
#include "gmis/render/render.hpp"
#include "gmis/scene/bvh_scene.hpp"
#include "gmis/scene/scene_builder.hpp"
#include "transport/quads.hpp"

// What merging loses at the edges of a surface, exactly: the sun on a square of side a, all of
// which is seen. The share g(x/r) of a disk at the distance x from an edge lies beyond the edge and
// gathers nothing; ∫ g(t) dt = 2/(3π) from 0 to 1. With ρ = r/a the loss is L(ρ) = 4 · 2/(3π) ρ − 4
// c ρ²: at a corner the part beyond both edges is not lost twice. That part is at most the product
// of the two, for in a disk large x go with small y: 0 ≤ c ≤ (2/(3π))².

namespace gmis_test::sun_on_square {

using Scene = gmis::scene::BvhScene<float>;

inline constexpr double rho = 0.05;                          ///< r_1 over the side
inline constexpr double share = 2 / (3 * gmis::pi<double>);  ///< ∫ g(t) dt
inline constexpr double truth = 0.5 / gmis::pi<double>;      ///< of every pixel

inline Scene make_scene() {
  gmis::scene::SceneBuilder<float> builder;
  const auto grey = builder.add_material(gmis::scene::make_diffuse<float>({0.5, 0.5, 0.5}));
  add_quad(builder, grey, {0, 0, 0}, {1, 0, 0}, {0, 1, 0});
  builder.add_directional_light({0, 0, 1}, {1, 1, 1});
  gmis::scene::CameraDescription camera = gmis::scene::look_at({0, 0, 1}, {0, 0, 0}, {0, 1, 0}, 90, {24, 24});
  camera.projection = gmis::scene::Projection::orthographic;
  builder.set_camera(camera);
  return builder.build();
}

/// Merging alone, for 1600 iterations, of disks that shrink as `alpha` says.
inline gmis::RenderRequest merging_alone(double alpha, std::uint64_t seed) {
  gmis::RenderRequest request;
  request.settings.counts = {4.0, 0, false, true, 1, false, false, false, 1.0};
  request.settings.max_depth = 3;
  request.settings.radius = 2 * rho;
  request.settings.alpha = alpha;
  request.settings.seed = seed;
  request.budget.iterations = 1600;
  return request;
}

/// Limit of the error of the bias of the mean that the run states. Nine large tiles make an error
/// with as many degrees of freedom. With `noise`: a false alarm in 5e3 runs.
inline double sure(const gmis::RenderResult& result) {
  return gmis::student_t_quantile(1 - 0.5e-4, 9) * result.merging_bias->standard_error_of_mean;
}

/// Limit of the noise of the picture's mean, relative: a light tree hits the square or not.
inline double noise(const gmis::RenderResult& result) {
  const auto trees = static_cast<double>(result.counters.light_subpaths);
  const double hits = static_cast<double>(result.counters.photons_stored) / trees;
  return 3.9 * std::sqrt((1 - hits) / (hits * trees));
}

}  // namespace gmis_test::sun_on_square
