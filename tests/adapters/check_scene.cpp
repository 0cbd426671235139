#include "gmis/check/check_scene.hpp"

#include <algorithm>
#include <string>
#include <vector>

#include "adapters/broken_scene.hpp"
#include "bring_your_own/adapter.hpp"
#include "bring_your_own/world.hpp"
#include "gmis/check/explain.hpp"
#include "gmis/core/check.hpp"
#include "gmis/scene/scene_builder.hpp"
#include "support/catch.hpp"
#include "support/seed.hpp"
#include "transport/furnace_scene.hpp"

namespace {

using gmis::Convention;
using gmis_test::BrokenScene;
using gmis_test::Mistake;

/// Every kind of surface and of light that the built-in scene has.
template <class T>
auto built_in_scene() {
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
  return builder.build();
}

gmis::SceneCheckSettings settings() {
  gmis::SceneCheckSettings result;
  result.seed = gmis_test::seed(77);
  result.most_lights = 8;
  return result;
}

struct Planted {
  Mistake mistake;
  Convention wanted;  ///< must be among the conventions that are named
};

// clang-format off
const std::vector<Planted> planted{
    {Mistake::camera_y_flipped, Convention::camera_pixel},
    {Mistake::camera_pixel_shifted, Convention::camera_pixel},
    {Mistake::camera_density_of_picture, Convention::camera_density},
    {Mistake::camera_density_without_cosines, Convention::camera_density},
    {Mistake::camera_one_density_doubled, Convention::camera_two_densities},
    {Mistake::camera_direction_not_unit, Convention::camera_ray_unit},
    {Mistake::to_camera_reversed, Convention::camera_to_camera},
    {Mistake::normal_turned_to_ray, Convention::hit_normal_turned},
    {Mistake::normals_not_unit, Convention::hit_normal_unit},
    {Mistake::normal_not_perpendicular, Convention::hit_normal_slant},
    {Mistake::shading_normal_reversed, Convention::hit_normal_hemisphere},
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
    {Mistake::densities_with_light_choice, Convention::emission_origin_distribution},
    {Mistake::next_event_density_with_light_choice, Convention::next_event_distribution},
    {Mistake::next_event_density_doubled, Convention::next_event_distribution},
    {Mistake::next_event_weight_with_light_choice, Convention::next_event_weight},
    {Mistake::next_event_weight_with_cosine, Convention::next_event_weight},
    {Mistake::to_light_reversed, Convention::next_event_direction},
    {Mistake::first_per_area, Convention::emission_direction_distribution},
    {Mistake::emission_density_doubled, Convention::emission_two_densities},
    {Mistake::emission_weight_without_density, Convention::emission_weight},
    {Mistake::emission_backwards, Convention::emission_two_densities},
    {Mistake::emitted_radiance_doubled, Convention::emission_weight},
    {Mistake::delta_density_zero, Convention::light_delta_densities},
    {Mistake::delta_light_falls_linearly, Convention::emission_intensity},
    {Mistake::disk_area_halved, Convention::emission_disk},
    {Mistake::pdfs_swapped_in_evaluate, Convention::bsdf_two_densities},
    {Mistake::pdfs_swapped_everywhere, Convention::bsdf_distribution},
    {Mistake::cosine_in_f, Convention::bsdf_weight},
    {Mistake::cosine_in_f_and_weight, Convention::bsdf_reciprocity},
    {Mistake::weight_without_cosine, Convention::bsdf_weight},
    {Mistake::weight_without_density, Convention::bsdf_weight},
    {Mistake::pdf_without_lobe_choice, Convention::bsdf_two_densities},
    {Mistake::pdf_uniform, Convention::bsdf_distribution},
    {Mistake::modes_swapped, Convention::bsdf_energy},
    {Mistake::mode_ignored, Convention::bsdf_delta_adjoint},
    {Mistake::eta_inverted, Convention::bsdf_eta},
    {Mistake::delta_not_flagged, Convention::bsdf_two_densities},
    {Mistake::purely_delta_wrong, Convention::bsdf_delta},
    {Mistake::delta_reverse_zero, Convention::bsdf_delta_reverse},
    {Mistake::albedo_zero, Convention::bsdf_albedo},
    {Mistake::to_prev_reversed, Convention::bsdf_through},
    {Mistake::local_directions, Convention::bsdf_weight},
    {Mistake::reflects_only_wrong, Convention::bsdf_reflects_only},
};
// clang-format on

}  // namespace

TEST_CASE("nothing is said about a sound scene") {
  CHECK(check_scene(built_in_scene<float>(), settings()).text() == "");
  CHECK(check_scene(built_in_scene<double>(), settings()).text() == "");
  CHECK(check_scene(gmis_test::FurnaceScene<float>(0.7F, 1.0F, 16, 2), settings()).text() == "");
  CHECK(check_scene(gmis_test::FurnaceScene<double>(0.5, 2.0, 16, 1), settings()).text() == "");
}

TEST_CASE("every planted mistake is named") {
  const auto scene = built_in_scene<float>();
  // The adapter itself changes nothing.
  CHECK(check_scene(BrokenScene(scene, Mistake::none), settings()).text() == "");
  CHECK(planted.size() >= 50);
  for (const Planted& one : planted) {
    const gmis::Findings findings = check_scene(BrokenScene(scene, one.mistake), settings());
    INFO("mistake " << static_cast<int>(one.mistake) << ", wanted: " << sentence_of(one.wanted));
    INFO("said:\n" << findings.text());
    CHECK(findings.is_broken(one.wanted));
  }
}

TEST_CASE("the same mistakes in double precision") {
  const auto scene = built_in_scene<double>();
  for (const Planted& one : planted) {
    INFO("mistake " << static_cast<int>(one.mistake));
    CHECK(check_scene(BrokenScene(scene, one.mistake), settings()).is_broken(one.wanted));
  }
}

TEST_CASE("the same mistakes in the adapter of a renderer of another style") {
  const theirs::World world = theirs::make_world(64, 48);
  const adapter::Scene scene(world);
  gmis::SceneCheckSettings many = settings();
  many.samples *= 4;  // all is diffuse: a wrong density differs less than at a narrow lobe
  CHECK(check_scene(scene, settings()).text() == "");
  CHECK(check_scene(BrokenScene(scene, Mistake::none), many).text() == "");
  // It has no delta light, no infinite light, no surface that transmits but delta ones, and a distance of its own that
  // keeps rays off surfaces.
  const std::vector<Mistake> impossible{Mistake::no_offset,          Mistake::infinite_lights_empty,
                                        Mistake::delta_density_zero, Mistake::delta_light_falls_linearly,
                                        Mistake::disk_area_halved,   Mistake::reflects_only_wrong};
  for (const Planted& one : planted) {
    if (std::find(impossible.begin(), impossible.end(), one.mistake) != impossible.end()) continue;
    const gmis::Findings findings = check_scene(BrokenScene(scene, one.mistake), many);
    INFO("mistake " << static_cast<int>(one.mistake) << ", wanted: " << sentence_of(one.wanted));
    INFO("said:\n" << findings.text());
    CHECK(findings.is_broken(one.wanted));
  }
}

TEST_CASE("what an adapter leaves out is listed, with what it costs") {
  CHECK(gmis::explain(built_in_scene<float>()) == "");
  const std::string furnace = gmis::explain(gmis_test::FurnaceScene<float>(0.7F, 1.0F, 16, 2));
  CHECK(furnace.find("Scene::effects() is missing") != std::string::npos);
  CHECK(furnace.find("BsdfWithLobes") == std::string::npos);
  const theirs::World world = theirs::make_world(8, 6);
  const std::string other = gmis::explain(adapter::Scene(world));
  CHECK(other.find("effects()") == std::string::npos);
  CHECK(other.find("BsdfWithLobes") != std::string::npos);
  CHECK(other.find("is_glossy() is missing") != std::string::npos);
}

TEST_CASE("every convention has a sentence of its own") {
  for (std::size_t i = 0; i < gmis::convention_count; ++i) {
    const auto sentence = sentence_of(static_cast<Convention>(i));
    CHECK(sentence.size() > 40);
    for (std::size_t j = 0; j < i; ++j) CHECK(sentence != sentence_of(static_cast<Convention>(j)));
  }
  gmis::Findings findings;
  for (int i = 0; i < 100; ++i) findings.count(Convention::hit_range, i > 2);
  CHECK(findings.passes());  // 3 of 100 are rounding
  for (int i = 0; i < 3; ++i) findings.count(Convention::hit_range, false);
  CHECK_FALSE(findings.passes());
  CHECK(findings.text().find("t_max [6 of 103 cases]") != std::string::npos);
  findings.judge(Convention::bsdf_energy, true);
  CHECK(findings.broken().size() == 1);
}

TEST_CASE("a BSDF that is made for one to_prev is checked with the to_prev of each ray") {
  // Cosine-weighted reflection around the normal on the side of `to_prev`, which the BSDF has stored.
  struct OneSided {
    using Spectrum = float;
    gmis::Vec3<float> normal;
    [[nodiscard]] gmis::BsdfValue<float> evaluate(const gmis::Vec3<float>& to_prev, const gmis::Vec3<float>& to_next,
                                                  gmis::TransportMode) const {
      const float prev = glm::dot(to_prev, normal), next = glm::dot(to_next, normal);
      if (next <= 0) return {};
      return {0.5F / gmis::pi<float>, {{next / gmis::pi<float>}, {std::abs(prev) / gmis::pi<float>}}};
    }
    [[nodiscard]] std::optional<gmis::ScatterSample<float>> sample(const gmis::Vec3<float>& to_prev, float,
                                                                   const gmis::Vec2<float>& uv,
                                                                   gmis::TransportMode mode) const {
      const auto to_next = gmis::Frame<float>::around(normal).to_world(gmis::square_to_cosine_hemisphere(uv));
      const auto f = evaluate(to_prev, to_next, mode);
      if (!(f.pdf.forward.value > 0)) return std::nullopt;
      return gmis::ScatterSample<float>{to_next, 0.5F, f.pdf, false, 1.0F};
    }
    [[nodiscard]] bool is_purely_delta() const { return false; }
    [[nodiscard]] float albedo() const { return 0.5F; }
  };
  using V = gmis::Vec3<float>;
  const V up(0, 0, 1), to_prev = glm::normalize(V(0.3F, 0.2F, -0.7F));
  const auto bsdf_for = [&](const V& from) { return OneSided{glm::dot(from, up) > 0 ? up : -up}; };
  gmis::CheckSettings few;
  few.samples = 20'000;
  few.bins = 100;
  gmis::Philox source(gmis_test::seed(6));
  const gmis::BsdfCheck check = gmis::check_bsdf(bsdf_for, up, to_prev, source, few);
  CHECK(check.passes(1e-6));
  // Stored once, for another side, the same BSDF is no BSDF of this point.
  CHECK_FALSE(gmis::check_bsdf(OneSided{up}, up, to_prev, source, few).reverse_error < 1e-3);
}
