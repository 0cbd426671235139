#pragma once

#include <vector>

#include "adapters/broken_scene.hpp"
#include "gmis/check/check_scene.hpp"
#include "gmis/scene/scene_builder.hpp"
#include "support/seed.hpp"

/// \file
/// Mistakes that adapters make, and the convention that is to be named for each.

namespace gmis_test {

using gmis::Convention;

/// Every kind of surface and of light that the built-in scene has. `add(builder, white, glass)`
/// adds to it.
template <class T, class Add>
[[nodiscard]] auto built_in_scene(const Add& add) {
  using namespace gmis::scene;
  SceneBuilder<T> builder;
  const auto white = builder.add_material(make_diffuse<T>({0.7, 0.6, 0.5}));
  const auto shiny = builder.add_material(make_phong<T>({0.3, 0.3, 0.3}, {0.4, 0.4, 0.4}, 20));
  const auto metal = builder.add_material(make_conductor_of_reflectance<T>({0.9, 0.7, 0.4}, 0.3));
  const auto mirror = builder.add_material(make_mirror<T>({0.9, 0.9, 0.9}));
  const auto glass = builder.add_material(make_dielectric<T>(1.5));
  const auto frosted = builder.add_material(make_dielectric<T>(1.4, 0.3));
  const auto coated = builder.add_material(make_coated_diffuse<T>({0.5, 0.2, 0.2}, 1.5, 0.2));
  const auto black = builder.add_material(make_diffuse<T>({0, 0, 0}));
  const std::vector<glm::dvec3> corners{{-4, -1, -4}, {4, -1, -4}, {4, -1, 4}, {-4, -1, 4}};
  const std::vector<std::array<int, 3>> triangles{{0, 2, 1}, {0, 3, 2}};
  builder.add_mesh({corners, triangles}, white);
  const std::vector<glm::dvec3> wall{{-4, -1, 4}, {4, -1, 4}, {4, 5, 4}, {-4, 5, 4}};
  builder.add_mesh({wall, triangles}, shiny);
  builder.add_sphere({-2.2, -0.3, 1}, 0.7, metal);
  builder.add_sphere({-0.7, -0.3, 0}, 0.7, glass);
  builder.add_sphere({0.9, -0.3, 0.5}, 0.7, mirror);
  builder.add_sphere({2.4, -0.3, 1}, 0.7, frosted);
  builder.add_sphere({0.2, -0.5, -1.5}, 0.5, coated);
  builder.add_sphere({-2, 3, -1}, 0.5, black, AreaEmission{{8, 8, 8}});
  const std::vector<glm::dvec3> lamp{{1, 4, -1}, {2.5, 4, -1}, {2.5, 4, 0.5}, {1, 4, 0.5}};
  builder.add_mesh({lamp, std::vector<std::array<int, 3>>{{0, 1, 2}, {0, 2, 3}}}, black, AreaEmission{{15, 12, 9}});
  builder.add_point_light({3, 3, -3}, {6, 6, 9});
  builder.add_environment({0.5, 0.6, 0.8});
  builder.set_camera(look_at({0, 1.5, -7}, {0, 0.2, 0}, {0, 1, 0}, 55, {64, 48}));
  add(builder, white, glass);
  return builder.build();
}
template <class T>
[[nodiscard]] auto built_in_scene() {
  return built_in_scene<T>([](auto&, std::size_t, std::size_t) {});
}

[[nodiscard]] inline gmis::SceneCheckSettings check_settings() {
  gmis::SceneCheckSettings result;
  result.seed = gmis_test::seed(77);
  return result;
}

struct Planted {
  Mistake mistake;
  Convention wanted;  ///< must be among the conventions that are named
};

// clang-format off
inline const std::vector<Planted> planted{
    {Mistake::camera_y_flipped, Convention::camera_pixel},
    {Mistake::camera_pixel_shifted, Convention::camera_pixel},
    {Mistake::camera_density_of_picture, Convention::camera_density},
    {Mistake::camera_density_without_cosines, Convention::camera_density},
    {Mistake::camera_one_density_doubled, Convention::camera_two_densities},
    {Mistake::camera_one_weight_doubled, Convention::camera_two_weights},
    {Mistake::camera_direction_not_unit, Convention::camera_ray_unit},
    {Mistake::to_camera_reversed, Convention::camera_to_camera},
    {Mistake::normal_turned_to_ray, Convention::hit_normal_turned},
    {Mistake::normals_not_unit, Convention::hit_normal_unit},
    {Mistake::normal_not_perpendicular, Convention::hit_normal_slant},
    {Mistake::shading_normal_reversed, Convention::hit_normal_hemisphere},
    {Mistake::hit_beside_ray, Convention::hit_on_ray},
    {Mistake::no_offset, Convention::hit_same_surface},
    {Mistake::t_max_ignored, Convention::hit_range},
    {Mistake::always_visible, Convention::visible_false},
    {Mistake::visible_ignores_t_max, Convention::visible_true},
    {Mistake::hit_without_light, Convention::light_not_hit},
    {Mistake::infinite_lights_empty, Convention::light_infinite_list},
    {Mistake::selection_probability_wrong, Convention::light_frequency},
    {Mistake::choice_states_other_probability, Convention::light_choice},
    {Mistake::receiver_choice_states_other_probability, Convention::receiver_choice},
    {Mistake::receiver_probability_wrong, Convention::receiver_frequency},
    {Mistake::receiver_probability_of_emission, Convention::receiver_choice},
    {Mistake::receiver_choice_misses_light, Convention::receiver_reach},
    {Mistake::densities_with_light_choice, Convention::next_event_distribution},
    {Mistake::next_event_density_with_light_choice, Convention::next_event_distribution},
    {Mistake::next_event_density_doubled, Convention::next_event_distribution},
    {Mistake::next_event_missing, Convention::next_event_distribution},
    {Mistake::emission_missing, Convention::emission_origin_distribution},
    {Mistake::next_event_weight_with_light_choice, Convention::next_event_weight},
    {Mistake::next_event_weight_with_cosine, Convention::next_event_weight},
    {Mistake::next_event_states_other_emission, Convention::next_event_emission_density},
    {Mistake::to_light_reversed, Convention::next_event_direction},
    {Mistake::first_per_area, Convention::emission_direction_distribution},
    {Mistake::emission_density_doubled, Convention::emission_two_densities},
    {Mistake::emission_origin_doubled, Convention::emission_origin_distribution},
    {Mistake::emission_weight_without_density, Convention::emission_weight},
    {Mistake::emission_backwards, Convention::emission_two_densities},
    {Mistake::emitted_radiance_doubled, Convention::emitted_radiance},
    {Mistake::delta_density_zero, Convention::light_delta_densities},
    {Mistake::delta_light_falls_linearly, Convention::emission_intensity},
    {Mistake::emission_numbers_swapped, Convention::guided_numbers},
    {Mistake::emission_along_weight_doubled, Convention::guided_start},
    {Mistake::emission_along_missing, Convention::guided_start},
    {Mistake::disk_area_halved, Convention::emission_disk},
    {Mistake::radiance_negative, Convention::light_value},
    {Mistake::radiance_infinite, Convention::light_value},
    {Mistake::next_event_from_behind, Convention::next_event_weight},
    {Mistake::pdfs_swapped_in_evaluate, Convention::bsdf_two_densities},
    {Mistake::pdfs_swapped_everywhere, Convention::bsdf_distribution},
    {Mistake::cosine_in_f, Convention::bsdf_cosine},
    {Mistake::cosine_in_f_and_weight, Convention::bsdf_cosine},
    {Mistake::weight_without_cosine, Convention::bsdf_weight},
    {Mistake::weight_without_density, Convention::bsdf_weight},
    {Mistake::weight_negative, Convention::bsdf_value},
    {Mistake::to_next_not_unit, Convention::bsdf_unit},
    {Mistake::reverse_density_of_sample_doubled, Convention::bsdf_two_reverse_densities},
    {Mistake::pdf_without_lobe_choice, Convention::bsdf_two_densities},
    {Mistake::pdf_uniform, Convention::bsdf_distribution},
    {Mistake::modes_swapped, Convention::bsdf_energy},
    {Mistake::mode_ignored, Convention::bsdf_reciprocity},
    {Mistake::eta_inverted, Convention::bsdf_eta},
    {Mistake::delta_not_flagged, Convention::bsdf_two_densities},
    {Mistake::purely_delta_wrong, Convention::bsdf_delta},
    {Mistake::delta_reverse_zero, Convention::bsdf_delta_reverse},
    {Mistake::delta_probability_one, Convention::bsdf_delta_frequency},
    {Mistake::albedo_zero, Convention::bsdf_albedo},
    {Mistake::albedo_of_ray, Convention::bsdf_albedo_of_point},
    {Mistake::to_prev_reversed, Convention::bsdf_through},
    {Mistake::local_directions, Convention::bsdf_world},
    {Mistake::reflects_only_wrong, Convention::bsdf_reflects_only},
    {Mistake::forward_density_swapped, Convention::bsdf_forward},
    {Mistake::forward_weight_without_cosine, Convention::bsdf_forward},
    {Mistake::forward_sample_fails, Convention::bsdf_forward},
};
// clang-format on

}  // namespace gmis_test
