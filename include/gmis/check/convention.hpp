#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string_view>

/// \file
/// The conventions between a renderer and the engine (core/concepts.hpp, core/interaction.hpp) that
/// the checks of adapters test, in words.

namespace gmis {

/// A convention of the interface between a renderer and the engine. `sentence_of` says it in words.
/// The order is that of causes: what breaks one of them often breaks some of those after it, and
/// seldom one before it.
enum class Convention : std::uint8_t {
  camera_ray_unit,
  camera_pixel,
  camera_to_camera,
  camera_two_densities,
  camera_two_weights,
  camera_density,
  camera_filter,
  hit_normal_unit,
  hit_normal_hemisphere,
  hit_on_ray,
  hit_range,
  hit_normal_turned,
  hit_normal_slant,
  hit_same_surface,
  visible_false,
  visible_true,
  transmittance,
  effects,
  light_value,
  light_choice,
  light_frequency,
  receiver_choice,
  receiver_frequency,
  receiver_reach,
  light_infinite_list,
  light_not_hit,
  light_tag,
  next_event_direction,
  next_event_two_densities,
  next_event_distribution,
  emission_unit,
  emission_two_densities,
  emission_origin_distribution,
  emission_direction_distribution,
  emission_disk,
  light_delta_densities,
  next_event_emission_density,
  emitted_radiance,
  next_event_weight,
  emission_weight,
  emission_intensity,
  guided_numbers,
  guided_start,
  bsdf_unit,
  bsdf_world,
  bsdf_value,
  bsdf_through,
  bsdf_eta,
  bsdf_two_densities,
  bsdf_delta,
  bsdf_delta_frequency,
  bsdf_two_reverse_densities,
  bsdf_distribution,
  bsdf_cosine,
  bsdf_weight,
  bsdf_forward,
  bsdf_compact,
  bsdf_mean_weight,
  bsdf_reverse,
  bsdf_reciprocity,
  bsdf_energy,
  bsdf_delta_adjoint,
  bsdf_delta_reverse,
  bsdf_reflects_only,
  bsdf_leak,
  bsdf_albedo,
  bsdf_albedo_share,
  bsdf_albedo_of_point,
};
/// How many conventions there are.
inline constexpr std::size_t convention_count = static_cast<std::size_t>(Convention::bsdf_albedo_of_point) + 1;

/// The convention, which member breaks it, and the usual mistakes.
[[nodiscard]] constexpr std::string_view sentence_of(Convention convention) noexcept {
  constexpr std::array<std::string_view, convention_count> sentences{
      "Camera::sample_ray: the direction must have unit length",
      "Camera::project must find the pixel whose ray passes the point (x to the right, y down, from the upper "
      "left): it finds another one, so one of the two members flips an axis or shifts pixels",
      "CameraProjection::to_camera must be the unit vector from the point to the lens",
      "Camera: project and sample_ray must state the same density for the same ray",
      "Camera: project and sample_ray must state the same weight for the same ray",
      "Camera: the density must be that of the rays of one pixel (not of the whole picture), per steradian: 1 / "
      "(area of the pixel on the plane at distance 1 · cos³); per area for parallel rays; with a filter times the sum "
      "of the filters of all pixels there",
      "Camera with a filter wider than a pixel: project must return a pixel with the probability of its filter at the "
      "point over the sum of the filters of all pixels (it shifts pixels, or leaves the filter out)",
      "SurfacePoint: both normals of a hit must have unit length",
      "SurfacePoint: the shading normal must lie in the hemisphere of the geometric normal",
      "Scene::intersect: the position of a hit must lie on the ray, in front of its origin",
      "Scene::intersect must report no hit beyond Ray::t_max",
      "SurfacePoint::geometric_normal must not be turned towards the ray: the side from which a ray comes must not "
      "change it",
      "SurfacePoint::geometric_normal must be perpendicular to the surface, in world space",
      "Rays that leave a surface must not meet it again at once: set SurfacePoint::position_error to a bound on the "
      "error of the position, or let the scene ignore hits that near",
      "Scene::visible must be false when a surface lies between 0 and Ray::t_max: it is true where intersect finds "
      "one",
      "Scene::visible must be true when nothing lies between 0 and Ray::t_max: it is false between points that see "
      "each other (t_max ignored, or no room for rounding at its ends)",
      "Scene::transmittance must be between 0 and 1 in every channel, and the same for light that takes the way "
      "back",
      "Scene::effects() must name every property that the scene has: what it leaves out may be left out of the "
      "picture",
      "Light: radiance, weights and densities must be finite and not negative",
      "Scene: sample_light and selection_probability must state the same probability for a light",
      "Scene::selection_probability must be the probability with which sample_light chooses the light",
      "Scene: sample_light(from, u) and selection_probability(light, from) must state the same probability for the "
      "same receiver",
      "Scene::selection_probability(light, from) must be the probability with which sample_light(from, u) chooses "
      "the light",
      "Scene::selection_probability(light, from) must be positive wherever the light reaches the receiver and is "
      "scattered there",
      "Scene::infinite_lights must list every infinite light that is no delta light",
      "A ray towards a point of a light that is no delta light must hit it, with Hit::light pointing to that light",
      "SurfacePoint::tag: the points that a light samples must have the tags that Scene::intersect gives them",
      "NextEventSample::to_light must be the unit vector from the receiver to the light (not from the light)",
      "Light: sample_next_event and next_event_density must state the same density (neither holds the probability "
      "of choosing the light)",
      "Light::next_event_density must be the density with which sample_next_event makes the point, per area (for an "
      "infinite light: of the direction, per steradian), without the probability of choosing the light; where rays "
      "meet the light and no sample comes, a sign or the normal of its points is turned",
      "Light::sample_emission: the direction must have unit length and leave the light",
      "Light: sample_emission and emitted must state the same densities for the same start (origin: per area, "
      "first: per steradian; for an infinite light origin: per steradian, first: per area on the disk)",
      "EmissionDensity::origin must be the density with which sample_emission makes the point, per area (for an "
      "infinite light: of the direction, per steradian), without the probability of choosing the light",
      "EmissionDensity::first must be the density of the direction alone, per steradian, such as cos/π: the density "
      "per area and the probability of choosing the light are not part of it",
      "EmissionDensity::first of an infinite light must be 1 / the area of the disk that sample_emission starts "
      "from, and that disk must cover the scene and lie outside of it, where light comes from",
      "A delta light must state the density 1 for what it fixes: next_event_density, and EmissionDensity::origin",
      "NextEventSample::density must be the density of emission that Light::emitted states for the light's "
      "direction towards the receiver",
      "Light::emitted must state the radiance that sample_next_event and sample_emission weigh with: both weights "
      "disagree with it",
      "NextEventSample::weight must be the incident radiance over the density per steradian at the receiver: "
      "radiance · |cos| / (distance² · next_event_density), for an infinite light radiance / next_event_density; "
      "without the cosine at the receiver",
      "EmissionSample::weight must be radiance · |cos| / (origin · first), for an infinite light radiance / (origin "
      "· first)",
      "A delta light must send the same light in sample_emission and in sample_next_event: intensity / first and "
      "intensity / distance² (for a directional light irradiance / first and irradiance)",
      "Light::start_numbers must return the numbers from which sample_emission makes what it draws first, whatever its "
      "other numbers are: uv_origin for the point, and for an infinite light uv_direction for the direction",
      "Light::emission_along must return the start that sample_emission makes there, with the same direction, weight "
      "and densities",
      "Bsdf::sample: to_next must have unit length, in world space",
      "Bsdf: to_prev and to_next are in world space: what sample states fits a to_next in the frame of the surface",
      "Bsdf: values, densities and weights must be finite and not negative",
      "Bsdf::sample: every direction goes through the surface: to_prev and to_next both point away from it (right "
      "only where a surface scatters all light to its other side)",
      "ScatterSample::eta must be the index of refraction on the side of to_next over that on the side of to_prev: "
      "sin of to_prev = eta · sin of to_next",
      "ScatterSample::pdf.forward must be the density that Bsdf::evaluate states for the same directions, with the "
      "probability of choosing the lobe; a delta lobe must set is_delta",
      "Bsdf: is_purely_delta must be true exactly where evaluate is 0 everywhere and sample makes delta directions "
      "only; a lobe whose direction is drawn is no delta lobe",
      "A delta lobe: pdf.forward must be the probability with which sample makes it, such as 1/2 for each of two "
      "lobes that are chosen alike (not 1 where sample makes something else, too)",
      "ScatterSample::pdf.reverse must be the reverse density that Bsdf::evaluate states for the same directions",
      "Bsdf: pdf.forward must be the density per steradian with which sample makes to_next (forward and reverse "
      "swapped, not normalised, or without a factor of a change of variables: 4 (h · to_next), eta²)",
      "Bsdf::evaluate must not include the cosine: f(a, b) of the two modes, or f(a, b) and f(b, a), differ by the "
      "ratio of the cosines",
      "ScatterSample::weight must be f · |cos| / pdf.forward, with f of Bsdf::evaluate, which does not include the "
      "cosine",
      "Bsdf: evaluate_forward and sample_forward must state the values and forward densities of evaluate and sample",
      "Bsdf: B(compact(), point) must be the same BSDF again",
      "Bsdf::sample must be able to make every direction that scatters light: its mean weight must equal the "
      "integral of f · |cos|",
      "Bsdf: pdf.reverse must be the density of the way back: pdf.forward for swapped directions and the other mode",
      "Bsdf: f(a, b) for importance must equal f(b, a) for radiance (a cosine in f, or a mode mistaken)",
      "Bsdf: for importance no more than all light may be scattered: the mean weight of sample is above 1 (a factor "
      "π in f; factors of refraction belong to radiance)",
      "A delta lobe must be adjoint: weight · pdf.forward for radiance, times eta², must equal the same product for "
      "importance on the way back (the factor 1 / eta² belongs to radiance; pdf.forward is the probability of "
      "choosing this lobe, not another one)",
      "A delta lobe: pdf.reverse must be the selection probability of the same lobe on the way back",
      "Bsdf::reflects_only must be false where evaluate is not 0 for directions on different sides of the surface: "
      "connections through it are left out",
      "Bsdf: where the shading and the geometric normal put to_prev or to_next on different sides, evaluate must be 0 "
      "and sample make nothing: light leaks through the surface otherwise, or does not come back the same way",
      "Bsdf::albedo must be between 0 and 1, and above 0 where light is scattered; a surface whose albedo is above "
      "0 must scatter some (to_prev points away from the surface)",
      "Bsdf::albedo must be near the share of the light that the surface scatters: the mean weight of sample is "
      "another one, by more than a factor of 2 and more than 0.1 (a factor such as π in f, or in albedo)",
      "Bsdf::albedo must depend on the point alone, not on the ray that found it",
  };
  return sentences[static_cast<std::size_t>(convention)];
}

}  // namespace gmis
