#include "scene/shapes.hpp"
#include "support/catch.hpp"
#include "support/seed.hpp"

using namespace gmis;
using namespace gmis::scene;
using namespace scene_test;

namespace {

TEST_CASE("what is no scene is refused with a reason", "[builder]") {
  SceneBuilder<> builder;
  const auto material = builder.add_material(make_diffuse({.5, .5, .5}));
  const double nan = std::nan(""), infinity = std::numeric_limits<double>::infinity();
  CHECK_THROWS_AS(static_cast<void>(builder.build()), std::invalid_argument);  // no camera
  CHECK_THROWS_AS(builder.add_sphere({nan, 0, 0}, 1, material), std::invalid_argument);
  CHECK_THROWS_AS(builder.add_sphere({0, 0, 0}, 0, material), std::invalid_argument);
  CHECK_THROWS_AS(builder.add_sphere({0, 0, 0}, infinity, material), std::invalid_argument);
  CHECK_THROWS_AS(builder.add_sphere({0, 0, 0}, 1, material + 1), std::invalid_argument);
  CHECK_THROWS_AS(builder.add_sphere({0, 0, 0}, 1, material, AreaEmission{{nan, 0, 0}, false}), std::invalid_argument);
  CHECK_THROWS_AS(builder.add_point_light({0, infinity, 0}, {1, 1, 1}), std::invalid_argument);
  CHECK_THROWS_AS(builder.add_directional_light({0, 0, 0}, {1, 1, 1}), std::invalid_argument);
  CHECK_THROWS_AS(builder.add_environment({-1, 0, 0}), std::invalid_argument);
  Mesh mesh = box({0, 0, 0}, {1, 1, 1});
  mesh.triangles[3] = {0, 1, 8};
  CHECK_THROWS_AS(builder.add_mesh(mesh.shape(), material), std::invalid_argument);
  mesh = box({0, 0, 0}, {1, infinity, 1});
  CHECK_THROWS_AS(builder.add_mesh(mesh.shape(), material), std::invalid_argument);
}

TEST_CASE("an empty scene is one", "[builder]") {
  SceneBuilder<> builder;
  builder.set_camera(camera_at({0, 0, 0}));
  const auto scene = builder.build();
  const Ray<float> ray{{0, 0, 0}, {0, 0, 1}};
  CHECK_FALSE(scene.intersect(ray));
  CHECK(scene.visible(ray));
  CHECK(scene.sample_light(0.5F).light == nullptr);
  CHECK(scene.statistics().bvh_bytes == 0);
}

TEST_CASE("triangles without area are left out and never met", "[builder]") {
  SceneBuilder<> builder;
  Mesh mesh;
  mesh.positions = {{-1, -1, 2}, {1, -1, 2}, {0, 1, 2}, {3, -1, 2}, {0, 0, 1}};
  mesh.triangles = {{0, 1, 2}, {0, 1, 3}, {4, 4, 4}, {0, 0, 1}};
  builder.add_mesh(mesh.shape(), builder.add_material(make_diffuse({.5, .5, .5})), AreaEmission{});
  builder.set_camera(camera_at({0, 0, 0}));
  const auto scene = builder.build();
  CHECK(scene.statistics().triangle_count == 1);
  CHECK(scene.statistics().degenerate_triangle_count == 3);
  CHECK(scene.lights().size() == 1);
  const auto hit = scene.intersect({{0, 0, 0}, {0, 0, 1}});
  REQUIRE(hit);
  CHECK(hit->point.position.z == Approx(2));
  CHECK(hit->light == &scene.lights()[0]);
}

TEST_CASE("many triangles in one place still make a tree", "[builder]") {
  SceneBuilder<> builder;
  Mesh mesh;
  mesh.positions = {{-1, -1, 2}, {1, -1, 2}, {0, 1, 2}};
  mesh.triangles.assign(1000, {0, 1, 2});
  const auto material = builder.add_material(make_diffuse({.5, .5, .5}));
  builder.add_mesh(mesh.shape(), material);
  for (int i = 0; i < 100; ++i) builder.add_sphere({0, 0, 2}, 0.5, material);
  builder.set_camera(camera_at({0, 0, 0}));
  const auto scene = builder.build();
  const auto hit = scene.intersect({{0, 0, 0}, {0, 0, 1}});
  REQUIRE(hit);
  CHECK(hit->point.position.z == Approx(1.5));
}

TEST_CASE("hits carry their normals, material and light, also after the scene was moved", "[builder]") {
  SceneBuilder<> builder;
  const auto red = builder.add_material(make_diffuse({.5, 0, 0}));
  const auto green = builder.add_material(make_diffuse({0, .5, 0}));
  Mesh mesh;
  mesh.positions = {{-4, -4, 5}, {4, -4, 5}, {0, 4, 5}};
  mesh.triangles = {{0, 1, 2}};
  const std::vector<glm::dvec3> normals{{-1, 0, 3}, {1, 0, 3}, {0, 1, 3}};  // (b − a) × (c − a) is along +z
  builder.add_mesh({mesh.positions, mesh.triangles, normals}, red, AreaEmission{{1, 2, 3}, false});
  builder.add_sphere({0, 0, 3}, 0.5, green, AreaEmission{{3, 2, 1}, false});
  builder.add_sphere({2, 0, 3}, 0.5, green, {}, true);
  builder.set_camera(camera_at({0, 0, 0}));
  auto built = builder.build();
  const auto scene = std::move(built);

  const auto ball = scene.intersect({{0, 0, 0}, {0, 0, 1}});
  REQUIRE(ball);
  CHECK(ball->point.geometric_normal.z == Approx(-1));
  CHECK(ball->bsdf.albedo() == Vec3<float>(0, .5, 0));
  REQUIRE(ball->light != nullptr);
  CHECK(ball->light->emitted(ball->point, {0, 0, -1}).radiance == Vec3<float>(3, 2, 1));
  CHECK(is_black(ball->light->emitted(ball->point, {0, 0, 1}).radiance));

  const auto inverted = scene.intersect({{2, 0, 0}, {0, 0, 1}});
  REQUIRE(inverted);
  CHECK(inverted->point.geometric_normal.z == Approx(1));
  CHECK(inverted->light == nullptr);

  const auto wall = scene.intersect({{1, -1, 0}, {0, 0, 1}});
  REQUIRE(wall);
  CHECK(wall->point.geometric_normal.z == Approx(1));
  // Barycentrics of (1, −1): c = 3/8, b − a = 1/4.
  const double c = 0.375, b = (1 - c + 0.25) / 2, a = 1 - b - c;
  const auto expected =
      glm::normalize(glm::normalize(normals[0]) * a + glm::normalize(normals[1]) * b + glm::normalize(normals[2]) * c);
  CHECK(glm::length(glm::dvec3(wall->point.shading_normal) - expected) < 1e-6);
  CHECK(wall->light->emitted(wall->point, {0, 0, 1}).radiance == Vec3<float>(1, 2, 3));
  CHECK(is_black(wall->light->emitted(wall->point, {0, 0, -1}).radiance));
}

TEST_CASE("a scene far from the origin loses nothing", "[builder]") {
  const auto at = [](const glm::dvec3& shift) {
    SceneBuilder<> builder;
    const auto material = builder.add_material(make_diffuse({.5, .5, .5}));
    builder.add_sphere(shift + glm::dvec3(0.25, 0, 3), 0.5, material);
    Mesh mesh = box(shift + glm::dvec3(-2), shift + glm::dvec3(5));
    builder.add_mesh(mesh.shape(), material);
    builder.add_point_light(shift + glm::dvec3(0, 1, 0), {1, 1, 1});
    builder.set_camera(camera_at(shift));
    return builder.build();
  };
  const auto near = at({0, 0, 0}), far = at({1048576, -2097152, 4194304});
  Philox source(gmis_test::seed(71));
  int differences = 0;
  for (int i = 0; i < 2000; ++i) {
    const Ray<float> ray{{0, 0, 0}, random_direction<float>(source)};
    const auto a = near.intersect(ray), b = far.intersect(ray);
    REQUIRE(a);
    REQUIRE(b);
    differences += a->point.position == b->point.position ? 0 : 1;
  }
  CHECK(differences == 0);
  CHECK(far.statistics().world_origin == glm::dvec3(1048576, -2097152, 4194304));
}

TEST_CASE("the size of a scene", "[builder]") {
  SceneBuilder<> builder;
  const auto material = builder.add_material(make_diffuse({.5, .5, .5}));
  builder.add_mesh(box({-1, -2, -3}, {1, 2, 3}).shape(), material);
  builder.add_environment({1, 1, 1});
  builder.set_camera(camera_at({0.5, 0, 0}));
  const auto scene = builder.build();
  const auto& statistics = scene.statistics();
  CHECK(statistics.half_diagonal == Approx(std::sqrt(14.0)));
  CHECK(statistics.bounding_radius >= std::sqrt(14.0));
  CHECK(statistics.bounding_radius < std::sqrt(14.0) * 1.0001);
}

TEST_CASE("from within glass the sky is brighter by the square of the index", "[builder][glass]") {
  // Radiance over index² is the same all along a path that only reflects and refracts; flux does
  // not change.
  for (const double index : {1.5, 1 / 1.3}) {
    SceneBuilder<double> builder;
    const auto glass = builder.add_material(make_dielectric<double>(index));
    const auto core = builder.add_material(make_dielectric<double>(1.2));
    builder.add_sphere({0, 0, 0}, 1, glass);
    builder.add_sphere({0.4, 0, 0}, 0.3, core);
    builder.set_camera(camera_at({-0.5, 0.1, 0}));
    const auto scene = builder.build();
    Philox source(gmis_test::seed(26));
    for (const TransportMode mode : {TransportMode::radiance, TransportMode::importance}) {
      int escaped = 0;
      double worst = 0;
      for (int i = 0; i < 300; ++i) {
        Ray<double> ray{{0, 0, 0}, random_direction<double>(source)};
        double weight = 1;
        for (int bounce = 0; bounce < 1000; ++bounce) {
          const auto hit = scene.intersect(ray);
          if (!hit) {
            const double expected = mode == TransportMode::radiance ? index * index : 1;
            worst = std::max(worst, std::abs(weight / expected - 1));
            ++escaped;
            break;
          }
          const double u = uniform<double>(source);
          const auto sample = hit->bsdf.sample(-ray.direction, u, {0.5, 0.5}, mode);
          REQUIRE(sample);
          weight *= sample->weight.x;
          ray = leave(hit->point, sample->to_next);
        }
      }
      CHECK(escaped > 100);
      CHECK(worst < 1e-9);
    }
  }
}

}  // namespace
