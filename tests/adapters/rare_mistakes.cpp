#include "adapters/rare_mistakes.hpp"

#include "adapters/planted_mistakes.hpp"
#include "bring_your_own/adapter.hpp"
#include "bring_your_own/world.hpp"
#include "cloth.hpp"
#include "gmis/scene.hpp"
#include "many_lights/adapter.hpp"

// Forty mistakes in four renderers, ten in each; most of them in a rough metal, a small object, one
// wavelength, or one light among many.

using namespace gmis_test;

namespace {

/// A point of the built-in scene as its hits state it: relative to the camera.
[[nodiscard]] glm::dvec3 from_eye(const glm::dvec3& eye, const glm::dvec3& point) {
  return point - eye;
}

[[nodiscard]] gmis::SceneCheckSettings settings(std::uint64_t number) {
  gmis::SceneCheckSettings result;
  result.seed = gmis_test::seed(number);
  return result;
}

// ----------------------------------------------------------------------------------------
// A renderer of another style: double precision, virtual materials.

std::vector<RareMistake<adapter::Scene>> mistakes_of_other_style() {
  using M = RareMistake<adapter::Scene>;
  using A = Alterations<adapter::Scene>;
  const auto in_red_ball = in_ball(glm::dvec3(-1.1, 0.5, 0.6), 0.5);
  const auto in_glass = in_ball(glm::dvec3(0.3, 0.8, 0), 0.8);
  return {
      M{"one ball turns its normal to the ray",
        {Convention::hit_normal_turned},
        [=](A& a) {
          a.hit = [=](const auto& ray, auto& point, std::size_t&) {
            if (!in_red_ball(point) || glm::dot(ray.direction, point.geometric_normal) < 0) return;
            point.geometric_normal = -point.geometric_normal;
            point.shading_normal = -point.shading_normal;
          };
        }},
      M{"glass states 1 for the way back",
        {Convention::bsdf_delta_reverse},
        [=](A& a) {
          a.sample = [=](const auto& point, const auto&, auto, auto& s) {
            if (in_glass(point)) s.pdf.reverse.value = 1;
          };
        }},
      M{"glass leaves the factor of refraction out",
        {Convention::bsdf_delta_adjoint, Convention::bsdf_reciprocity},
        [=](A& a) {
          a.sample = [=](const auto& point, const auto&, auto mode, auto& s) {
            if (in_glass(point) && mode == gmis::TransportMode::radiance) s.weight *= s.eta * s.eta;
          };
        }},
      M{"one lamp states a uniform density of its directions",
        {Convention::emission_direction_distribution},
        [=](A& a) {
          const double uniform = 1 / (2 * gmis::pi<double>);
          a.emitted = [=](std::size_t light, const auto&, const auto&, auto& e) {
            if (light == 1 && e.density.first > 0) e.density.first = uniform;
          };
          a.next_event = [=](std::size_t light, const auto&, auto& s) {
            if (light == 1) s.density.first = uniform;
          };
          a.emission = [=](std::size_t light, auto& s) {
            if (light != 1) return;
            s.weight *= s.density.first / uniform;
            s.density.first = uniform;
          };
        }},
      M{"blue is twice as bright in f of one ball",
        {Convention::bsdf_weight},
        [=](A& a) {
          a.evaluate = [=](const auto& point, const auto&, const auto&, auto, auto& f) {
            if (in_red_ball(point)) f.value.z *= 2;
          };
        }},
      M{"shadow rays pass through one ball",
        {Convention::visible_false},
        [=](A& a) {
          a.visible = [=](const adapter::Scene& inner, gmis::Ray<double> ray, bool& is_visible) {
            if (is_visible) return;
            while (const auto hit = inner.intersect(ray)) {
              if (!in_red_ball(hit->point)) return;
              const double step = glm::dot(hit->point.position - ray.origin, ray.direction) + 1e-6;
              ray = {ray.origin + step * ray.direction, ray.direction, ray.t_max - step};
            }
            is_visible = true;
          };
        }},
      M{"the density of the way back is that of the way there",
        {Convention::bsdf_reverse},
        [=](A& a) {
          a.evaluate = [=](const auto& point, const auto&, const auto&, auto, auto& f) {
            if (in_red_ball(point)) f.pdf.reverse = f.pdf.forward;
          };
          a.sample = [=](const auto& point, const auto&, auto, auto& s) {
            if (in_red_ball(point)) s.pdf.reverse = s.pdf.forward;
          };
        }},
      M{"the density of the camera has a cosine too few",
        {Convention::camera_density},
        [=](A& a) {
          a.camera_ray = [](auto& s) { s.density *= s.direction.z; };
          a.projection = [](auto& p) { p.density *= -p.to_camera.z; };
        }},
      M{"lamps are drawn alike and state shares of their power",
        {Convention::light_frequency},
        [=](A& a) { a.probability = [](std::size_t light, double& p) { p *= light == 0 ? 1.5 : 0.5; }; }},
      M{"a next event of one lamp has too much green",
        {Convention::next_event_weight},
        [=](A& a) {
          a.next_event = [](std::size_t light, const auto&, auto& s) {
            if (light == 1) s.weight.y *= 1.2;
          };
        }},
  };
}

// ----------------------------------------------------------------------------------------
// A town at night: 24 lamps, single precision.

using Town = many_lights::Scene<true>;

std::vector<RareMistake<Town>> mistakes_of_town() {
  using M = RareMistake<Town>;
  using A = Alterations<Town>;
  const auto in_lamp = in_ball(glm::dvec3(2.5, 35, 1.2), 0.2);
  return {
      M{"one lamp of 24 states the area of another radius",
        {Convention::next_event_distribution},
        [=](A& a) {
          constexpr float wrong = 0.6F;
          a.next_event = [=](std::size_t light, const auto&, auto& s) {
            if (light == 7) s.next_event_density *= wrong, s.density.origin *= wrong, s.weight /= wrong;
          };
          a.next_event_density = [=](std::size_t light, const auto&, const auto&, const auto&, float& density) {
            if (light == 7) density *= wrong;
          };
          a.emitted = [=](std::size_t light, const auto&, const auto&, auto& e) {
            if (light == 7) e.density.origin *= wrong;
          };
          a.emission = [=](std::size_t light, auto& s) {
            if (light == 7) s.density.origin *= wrong, s.weight /= wrong;
          };
        }},
      M{"next_event_density of one lamp is per steradian",
        {Convention::next_event_two_densities},
        [=](A& a) {
          a.next_event_density = [](std::size_t light, const auto& origin, const auto& direction, const auto& from,
                                    float& density) {
            const glm::vec3 offset = origin.position - from.position;
            if (light == 3) density *= glm::dot(offset, offset) / glm::dot(origin.geometric_normal, direction);
          };
        }},
      M{"one lamp states half its probability",
        {Convention::light_frequency},
        [=](A& a) {
          a.probability = [](std::size_t light, float& p) {
            if (light == 11) p *= 0.5F;
          };
        }},
      M{"one lamp states another probability for a receiver",
        {Convention::receiver_choice},
        [=](A& a) {
          a.receiver_probability = [](std::size_t light, float& p) {
            if (light == 5) p *= 0.7F;
          };
        }},
      M{"one lamp sends light uniformly and states the cosine",
        {Convention::emission_direction_distribution},
        [=](A& a) {
          a.emission = [](std::size_t light, auto& s) {
            if (light != 9) return;
            // From the cosine law to the uniform one: sin² θ = u becomes cos θ = 1 − u.
            const auto frame = gmis::Frame<float>::around(s.origin.geometric_normal);
            const glm::vec3 local = frame.to_local(s.direction);
            const float u = local.x * local.x + local.y * local.y, z = 1 - u;
            const float scale = std::sqrt((1 - z * z) / std::max(u, 1e-12F));
            s.direction = frame.to_world({local.x * scale, local.y * scale, z});
            const float first = std::max(z, 1e-6F) / gmis::pi<float>;
            s.density.first = first;
          };
        }},
      M{"rays that hit one lamp find another",
        {Convention::light_not_hit},
        [=](A& a) {
          a.hit = [](const auto&, auto&, std::size_t& light) {
            if (light == 20) light = 21;
          };
        }},
      M{"emission of one lamp lacks red",
        {Convention::emission_weight},
        [=](A& a) {
          a.emission = [](std::size_t light, auto& s) {
            if (light == 2) s.weight.x *= 0.5F;
          };
        }},
      M{"the shading normal of one lamp is reversed",
        {Convention::hit_normal_hemisphere},
        [=](A& a) {
          a.hit = [=](const auto&, auto& point, std::size_t&) {
            if (in_lamp(point)) point.shading_normal = -point.shading_normal;
          };
        }},
      M{"f lacks the factor 1/pi",
        {Convention::bsdf_energy, Convention::bsdf_albedo_share},
        [=](A& a) {
          a.evaluate = [](const auto&, const auto&, const auto&, auto, auto& f) { f.value *= gmis::pi<float>; };
          a.sample = [](const auto&, const auto&, auto, auto& s) { s.weight *= gmis::pi<float>; };
        }},
      M{"visible leaves no room at the far end",
        {Convention::visible_true},
        [=](A& a) {
          a.visible = [](const Town& inner, gmis::Ray<float> ray, bool& is_visible) {
            ray.t_max *= 1.001F;
            is_visible = inner.visible(ray);
          };
        }},
  };
}

// ----------------------------------------------------------------------------------------
// Materials that the library does not have: cloth, a rough metal, a small ball of it, six lamps, a
// sky.

using OwnScene = gmis::scene::BvhScene<float, gmis::scene::EitherBsdf<gmis::scene::SurfaceBsdf<float>, own::ClothBsdf>>;

OwnScene own_scene() {
  using namespace gmis::scene;
  SceneBuilder<float, OwnScene::Bsdf> builder;
  const auto floor = builder.add_material(make_diffuse({0.6, 0.5, 0.4}));
  const auto velvet = builder.add_material(own::make_cloth({0.3F, 0.05F, 0.08F}, {0.9F, 0.7F, 0.7F}, 0.3F));
  const auto metal = builder.add_material(make_conductor_of_reflectance({0.9, 0.75, 0.5}, 0.08));
  const auto black = builder.add_material(make_diffuse({0, 0, 0}));
  const std::array<glm::dvec3, 4> corners{{{-3, -1, -3}, {3, -1, -3}, {3, -1, 3}, {-3, -1, 3}}};
  const std::array<std::array<int, 3>, 2> triangles{{{0, 2, 1}, {0, 3, 2}}};
  builder.add_mesh({corners, triangles}, floor);
  builder.add_sphere({-0.7, 0, 0}, 1, velvet);
  builder.add_sphere({1.3, -0.3, 0.3}, 0.7, metal);
  builder.add_sphere({0.8, -0.9, -1.5}, 0.1, metal);
  for (int i = 0; i < 6; ++i) builder.add_sphere({-2.5 + i, 3, -1}, 0.2, black, AreaEmission{{12, 12, 12}});
  builder.add_environment({0.4, 0.5, 0.6});
  builder.set_camera(look_at({0, 0.7, -6}, {0, -0.2, 0}, {0, 1, 0}, 40, {32, 24}));
  return builder.build();
}

/// f and weight of a surface times a factor that a direction pair gives, for one mode or for both.
template <class A, class Where, class Factor>
void scale_value(A& a, Where where, Factor factor) {
  a.evaluate = [=](const auto& point, const auto& to_prev, const auto& to_next, auto mode, auto& f) {
    if (where(point)) f.value = f.value * factor(point, to_prev, to_next, mode);
  };
  a.sample = [=](const auto& point, const auto& to_prev, auto mode, auto& s) {
    if (where(point)) s.weight = s.weight * factor(point, to_prev, s.to_next, mode);
  };
}

std::vector<RareMistake<OwnScene>> mistakes_of_own_materials() {
  using M = RareMistake<OwnScene>;
  using A = Alterations<OwnScene>;
  using glm::vec3;
  using gmis::TransportMode;
  const auto in_metal = in_ball(from_eye({0, 0.7, -6}, {1.3, -0.3, 0.3}), 0.7);
  const auto in_small = in_ball(from_eye({0, 0.7, -6}, {0.8, -0.9, -1.5}), 0.1);
  const auto in_cloth = in_ball(from_eye({0, 0.7, -6}, {-0.7, 0, 0}), 1);
  const auto constant = [](float factor) { return [factor](const auto&, const vec3&, const vec3&) { return factor; }; };
  return {
      M{"metal: the density of half vectors",
        {Convention::bsdf_distribution},
        [=](A& a) {
          scale_density(a, in_metal, [](const auto&, const vec3& to_prev, const vec3& to_next) {
            const float length = glm::length(to_prev + to_next);
            return length > 1e-3F ? 4 * glm::dot(glm::normalize(to_prev + to_next), to_next) : 1.0F;
          });
        }},
      M{"metal: 0.43 of the density",
        {Convention::bsdf_distribution},
        [=](A& a) { scale_density(a, in_metal, constant(0.43F)); }},
      M{"metal: 2.7 times the density",
        {Convention::bsdf_distribution},
        [=](A& a) { scale_density(a, in_metal, constant(2.7F)); }},
      M{"a small metal ball: the cosine is left in f, roles swapped by mode",
        {Convention::bsdf_cosine},
        [=](A& a) {
          scale_value(a, in_small, [](const auto& point, const vec3& prev, const vec3& next, TransportMode mode) {
            return std::abs(glm::dot(point.shading_normal, mode == TransportMode::radiance ? next : prev));
          });
        }},
      M{"metal: samples weigh 0.8",
        {Convention::bsdf_weight},
        [=](A& a) {
          a.sample = [=](const auto& point, const auto&, auto, auto& s) {
            if (in_metal(point)) s.weight *= 0.8F;
          };
        }},
      M{"metal: the density of the way back is that of the way there",
        {Convention::bsdf_reverse},
        [=](A& a) {
          a.evaluate = [=](const auto& point, const auto&, const auto&, auto, auto& f) {
            if (in_metal(point)) f.pdf.reverse = f.pdf.forward;
          };
          a.sample = [=](const auto& point, const auto&, auto, auto& s) {
            if (in_metal(point)) s.pdf.reverse = s.pdf.forward;
          };
        }},
      M{"cloth: less green for importance",
        {Convention::bsdf_reciprocity},
        [=](A& a) {
          scale_value(a, in_cloth, [](const auto&, const vec3&, const vec3&, TransportMode mode) {
            return vec3(1, mode == TransportMode::importance ? 0.9F : 1.0F, 1);
          });
        }},
      M{"cloth: the lobes are chosen with other probabilities than stated",
        {Convention::bsdf_distribution},
        [=](A& a) {
          scale_density(a, in_cloth, [](const auto& point, const vec3&, const vec3& to_next) {
            const float cosine = std::abs(glm::dot(point.shading_normal, to_next));
            return 0.5F / (0.8F * cosine + 0.1F);
          });
        }},
      M{"the sky: the disk is larger than stated",
        {Convention::emission_disk},
        [=](A& a) {
          constexpr float wrong = 1.2F;
          const auto is_sky = [](const auto& origin) { return glm::length(origin.geometric_normal) < 0.5F; };
          a.next_event = [=](std::size_t, const auto&, auto& s) {
            if (is_sky(s.origin)) s.density.first *= wrong;
          };
          a.emitted = [=](std::size_t, const auto& origin, const auto&, auto& e) {
            if (is_sky(origin)) e.density.first *= wrong;
          };
          a.emission = [=](std::size_t, auto& s) {
            if (is_sky(s.origin)) s.density.first *= wrong, s.weight /= wrong;
          };
        }},
      M{"the sky: the disk lies behind the scene, not before it",
        {Convention::emission_disk},
        [=](A& a) {
          a.emission = [](std::size_t, auto& s) {
            // The centre of the ball is the origin.
            if (glm::length(s.origin.geometric_normal) < 0.5F)
              s.origin.position -= 2 * glm::dot(s.origin.position, s.direction) * s.direction;
          };
        }},
      M{"the sky: the disk goes through the middle of the scene",
        {Convention::emission_disk},
        [=](A& a) {
          a.emission = [](std::size_t, auto& s) {
            if (glm::length(s.origin.geometric_normal) < 0.5F)
              s.origin.position -= glm::dot(s.origin.position, s.direction) * s.direction;
          };
        }},
      M{"emitted of one lamp of six has too much blue",
        {Convention::emitted_radiance},
        [=](A& a) {
          a.emitted = [](std::size_t light, const auto&, const auto&, auto& e) {
            if (light == 3) e.radiance.z *= 1.3F;
          };
        }},
  };
}

// ----------------------------------------------------------------------------------------
// The built-in scene, with two small balls more.

using BuiltIn = gmis::scene::BvhScene<float>;

BuiltIn scene_with_small_balls() {
  using namespace gmis::scene;
  return built_in_scene<float>([](SceneBuilder<float>& builder, std::size_t white, std::size_t glass) {
    builder.add_sphere({-1.5, -0.9, -2.5}, 0.1, white);
    builder.add_sphere({1.5, -0.9, -2.5}, 0.1, glass);
  });
}

std::vector<RareMistake<BuiltIn>> mistakes_of_built_in_scene() {
  using M = RareMistake<BuiltIn>;
  using A = Alterations<BuiltIn>;
  using glm::vec3;
  const auto in_metal = in_ball(from_eye({0, 1.5, -7}, {-2.2, -0.3, 1}), 0.7);
  const auto in_frosted = in_ball(from_eye({0, 1.5, -7}, {2.4, -0.3, 1}), 0.7);
  const auto in_coated = in_ball(from_eye({0, 1.5, -7}, {0.2, -0.5, -1.5}), 0.5);
  const auto in_mirror = in_ball(from_eye({0, 1.5, -7}, {0.9, -0.3, 0.5}), 0.7);
  const auto in_small = in_ball(from_eye({0, 1.5, -7}, {-1.5, -0.9, -2.5}), 0.1);
  const auto in_small_glass = in_ball(from_eye({0, 1.5, -7}, {1.5, -0.9, -2.5}), 0.1);
  return {
      M{"frosted glass: the density of refraction lacks eta squared",
        {Convention::bsdf_distribution},
        [=](A& a) {
          scale_density(a, in_frosted, [](const auto& point, const vec3& to_prev, const vec3& to_next) {
            const float prev = glm::dot(point.shading_normal, to_prev), next = glm::dot(point.shading_normal, to_next);
            if (prev * next > 0) return 1.0F;
            return next > 0 ? 1.4F * 1.4F : 1 / (1.4F * 1.4F);
          });
        }},
      M{"metal: evaluate states a tenth more density than sample",
        {Convention::bsdf_two_densities},
        [=](A& a) {
          a.evaluate = [=](const auto& point, const auto&, const auto&, auto, auto& f) {
            if (in_metal(point)) f.pdf.forward.value *= 1.1F;
          };
        }},
      M{"metal: too much blue in f",
        {Convention::bsdf_weight},
        [=](A& a) {
          a.evaluate = [=](const auto& point, const auto&, const auto&, auto, auto& f) {
            if (in_metal(point)) f.value.z *= 1.5F;
          };
        }},
      M{"a coated ball: a fifth of its albedo",
        {Convention::bsdf_albedo_share},
        [=](A& a) {
          a.albedo = [=](const auto& point, vec3& albedo) {
            if (in_coated(point)) albedo *= 0.2F;
          };
        }},
      M{"a small ball: its normals lean over",
        {Convention::hit_normal_slant},
        [=](A& a) {
          a.hit = [=](const auto&, auto& point, std::size_t&) {
            if (!in_small(point)) return;
            const auto frame = gmis::Frame<float>::around(point.geometric_normal);
            point.geometric_normal = point.shading_normal = glm::normalize(frame.normal + 0.6F * frame.tangent);
          };
        }},
      M{"a small ball like the floor: weights without the cosine",
        {Convention::bsdf_weight},
        [=](A& a) {
          a.sample = [=](const auto& point, const auto&, auto, auto& s) {
            if (in_small(point)) s.weight /= std::abs(glm::dot(point.shading_normal, s.to_next));
          };
        }},
      M{"the point light: red falls off with the distance alone",
        {Convention::emission_intensity},
        [=](A& a) {
          a.next_event = [](std::size_t, const auto& from, auto& s) {
            const vec3 light(from_eye({0, 1.5, -7}, {3, 3, -3}));
            if (glm::length(s.origin.position - light) < 1e-4F) s.weight.x *= glm::length(from.position - light);
          };
        }},
      M{"the sky: half the density of next events",
        {Convention::next_event_distribution},
        [=](A& a) {
          a.next_event = [](std::size_t, const auto&, auto& s) {
            if (glm::length(s.origin.geometric_normal) < 0.5F && s.density.origin != 1.0F)
              s.next_event_density *= 0.5F, s.weight *= 2.0F;
          };
          a.next_event_density = [](std::size_t, const auto& origin, const auto&, const auto&, float& density) {
            if (glm::length(origin.geometric_normal) < 0.5F && density != 1.0F) density *= 0.5F;
          };
        }},
      M{"a small glass ball: eta is inverted",
        {Convention::bsdf_eta},
        [=](A& a) {
          a.sample = [=](const auto& point, const auto&, auto, auto& s) {
            if (in_small_glass(point)) s.eta = 1 / s.eta;
          };
        }},
      M{"the mirror does not flag its delta lobe",
        {Convention::bsdf_two_densities, Convention::bsdf_delta},
        [=](A& a) {
          a.sample = [=](const auto& point, const auto&, auto, auto& s) {
            if (in_mirror(point)) s.is_delta = false;
          };
        }},
  };
}

}  // namespace

TEST_CASE("mistakes in what is rare are named, the right cause first, in at least 40 of 42 cases") {
  const theirs::World world = theirs::make_world(64, 48);
  const town::Town town = town::make_town(24, 64, 48);
  Named all;
  const auto add = [&all](const Named& named) {
    all.right_cause_first += named.right_cause_first;
    all.missed += named.missed;
  };
  add(name_mistakes(adapter::Scene(world), mistakes_of_other_style(), settings(31)));
  add(name_mistakes(Town(town), mistakes_of_town(), settings(32)));
  add(name_mistakes(own_scene(), mistakes_of_own_materials(), settings(33)));
  add(name_mistakes(scene_with_small_balls(), mistakes_of_built_in_scene(), settings(34)));
  CHECK(all.right_cause_first >= 40);
  CHECK(all.missed == 0);
}
