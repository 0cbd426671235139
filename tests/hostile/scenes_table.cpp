#include "hostile/scenes_table.hpp"

#include <cmath>
#include <limits>

#include "hostile/geometry_shapes.hpp"

namespace hostile {

using namespace gmis::scene;

namespace {

using Colour = glm::dvec3;
using Place = glm::dvec3;

void look(Builder& builder, const Place& eye, const Place& target, double degrees) {
  const Place along = target - eye;
  const Place up = std::abs(along.y) > 0.9 * glm::length(along) ? Place(0, 0, 1) : Place(0, 1, 0);
  builder.set_camera(look_at(eye, target, up, degrees, {picture_size, picture_size}));
}

/// A parallelogram from `corner` along `a` and `b`; its normal is a × b.
void quad(Builder& builder, const Place& corner, const Place& a, const Place& b, std::size_t material,
          const std::optional<AreaEmission>& emission = {}) {
  const std::array<Place, 4> positions{corner, corner + a, corner + a + b, corner + b};
  const std::array<std::array<int, 3>, 2> triangles{{{0, 1, 2}, {0, 2, 3}}};
  builder.add_mesh({positions, triangles, {}}, material, emission);
}

std::size_t diffuse(Builder& builder, double albedo = 0.5) {
  return builder.add_material(make_diffuse(Colour(albedo)));
}

/// A closed body seen from within, every point of which emits radiance 1 and reflects the share
/// `albedo`: radiance is Σ albedoᵏ over the segments of a path.
void glowing(Builder& builder, const Mesh& body, double albedo, double scale, const Place& shift) {
  Mesh inside = body;
  for (auto& position : inside.positions) position = position * scale + shift;
  for (auto& triangle : inside.triangles) std::swap(triangle[1], triangle[2]);
  builder.add_mesh(inside.shape(), diffuse(builder, albedo), AreaEmission{});
}
double glow(double albedo, int depth) {
  double sum = 0;
  for (int k = 0; k < depth; ++k) sum += std::pow(albedo, k);
  return sum;
}

/// A ball of this material on its own in a sky of radiance 1.
void ball_in_sky(Builder& builder, const Material<float>& material, double radius = 1) {
  builder.add_sphere({0, 0, 0}, radius, builder.add_material(material));
  builder.add_environment(Colour(1));
  look(builder, Place(0.3, 0.2, -4) * radius, {0, 0, 0}, 25);
}

/// A ball of this material on a floor under a lamp, the picture on the ball and the floor beside
/// it.
void ball_under_lamp(Builder& builder, const Material<float>& material) {
  builder.add_sphere({0, 0.5, 0}, 0.5, builder.add_material(material));
  quad(builder, {-3, 0, -3}, {0, 0, 6}, {6, 0, 0}, diffuse(builder));
  quad(builder, {-1, 3, -1}, {2, 0, 0}, {0, 0, 2}, diffuse(builder, 0), AreaEmission{Colour(4)});
  builder.add_environment(Colour(0.2));
  look(builder, {0.4, 1.2, -3}, {0.4, 0.3, 0}, 25);
}

void floor_and_wall(Builder& builder, double albedo = 0.5) {
  quad(builder, {-1, 0, -1}, {0, 0, 2}, {2, 0, 0}, diffuse(builder, albedo));
  quad(builder, {-1, 0, 1}, {0, 1, 0}, {2, 0, 0}, diffuse(builder, albedo));
}

class Table {
 public:
  std::vector<HostileScene> scenes;

  HostileScene& add(std::string name, std::function<void(Builder&)> make) {
    scenes.push_back({std::move(name), std::move(make)});
    return scenes.back();
  }
  HostileScene& add(std::string name, Paths paths, std::function<void(Builder&)> make) {
    HostileScene& scene = add(std::move(name), std::move(make));
    scene.paths = paths;
    return scene;
  }
};

Mesh cube() {
  return scene_test::box({-1, -1, -1}, {1, 1, 1});
}

void add_furnaces(Table& table) {
  for (const double albedo : {0.0, 0.5, 1.0})
    table
        .add("glowing cube, albedo " + std::to_string(albedo),
             [=](Builder& b) {
               glowing(b, cube(), albedo, 1, {});
               look(b, {0.1, 0.2, -0.3}, {0, 0, 1}, 60);
             })
        .radiance = glow(albedo, 5);
  for (const double scale : {1e-4, 1e6})
    table
        .add("glowing cube, scale " + std::to_string(scale),
             [=](Builder& b) {
               glowing(b, cube(), 0.5, scale, {});
               look(b, Place(0.1, 0.2, -0.3) * scale, Place(0, 0, 1) * scale, 60);
             })
        .radiance = glow(0.5, 5);
  table
      .add("glowing cube, far from the origin",
           [](Builder& b) {
             const Place shift(1e9, -2e9, 1e9);
             glowing(b, cube(), 0.5, 1, shift);
             look(b, shift + Place(0.1, 0.2, -0.3), shift + Place(0, 0, 1), 60);
           })
      .radiance = glow(0.5, 5);
  // Where three walls meet, and nothing else: the distance between vertices goes to 0.
  HostileScene& corner = table.add("corner of a glowing cube", [](Builder& b) {
    glowing(b, cube(), 0.5, 1, {});
    look(b, {0.9, 0.9, 0.9}, {1, 1, 1}, 20);
  });
  corner.radiance = glow(0.5, 5);
  corner.radius = 1e-4;
  corner.paths = Paths::narrow;  // ppm hardly finds a light path in a picture this small
  const struct {
    const char* where;
    Place eye, target;
  } cameras[] = {{"on a wall", {1, 0, 0}, {0, 0.2, 0.1}},
                 {"on an edge", {1, 1, 0}, {0, 0.2, 0.1}},
                 {"in a corner", {1, 1, 1}, {0, 0.2, 0.1}},
                 {"on a wall, nearly along it", {1, 0, 0}, {0.6, 1, 0}}};
  for (const auto& camera : cameras)
    table
        .add(std::string("glowing cube, camera ") + camera.where,
             [=](Builder& b) {
               glowing(b, cube(), 0.5, 1, {});
               look(b, camera.eye, camera.target, 20);
             })
        .radiance = glow(0.5, 5);
  table
      .add("glowing ball",
           [](Builder& b) {
             b.add_sphere({0, 0, 0}, 1, diffuse(b), AreaEmission{}, true);
             look(b, {0.1, 0.2, -0.3}, {0, 0, 1}, 60);
           })
      .radiance = glow(0.5, 5);
  HostileScene& corridor = table.add("glowing corridor, fifty times as long as wide", [](Builder& b) {
    glowing(b, scene_test::box({-1, -1, -1}, {1, 1, 99}), 0.5, 1, {});
    look(b, {0.1, 0.2, 0}, {0, 0, 10}, 60);
  });
  corridor.radiance = glow(0.5, 5);
  corridor.radius = 1e-3;
  for (int seed = 1; seed <= 3; ++seed) {
    HostileScene& body = table.add("glowing body " + std::to_string(seed), [=](Builder& b) {
      Philox source(static_cast<std::uint64_t>(seed));
      glowing(b, random_body(source).mesh, 0.5, 1, {});
      look(b, {0, 0, 0}, {0, 0.1, 1}, 90);
    });
    body.radiance = glow(0.5, 5);
    body.radius = 0.001;
  }
  HostileScene& small = table.add("glowing cube, merging radius 1e-7 of it", [](Builder& b) {
    glowing(b, cube(), 0.5, 1, {});
    look(b, {0.1, 0.2, -0.3}, {0, 0, 1}, 60);
  });
  small.radius = 1e-7;
  small.has_heavy_tail = true;  // a merge is a rare event of a weight of 1e12
  HostileScene& spoilt = table.add("glowing cube with triangles without area", [](Builder& b) {
    Mesh mesh = cube();
    glowing(b, mesh, 0.5, 1, {});
    mesh.triangles = {{0, 0, 1}, {2, 2, 2}, {3, 4, 3}};
    b.add_mesh(mesh.shape(), diffuse(b), AreaEmission{});
    look(b, {0.1, 0.2, -0.3}, {0, 0, 1}, 60);
  });
  spoilt.radiance = glow(0.5, 5);
}

void add_materials(Table& table) {
  // A ball that takes nothing away is not seen in an even sky.
  for (const double eta : {0.5, 1.0, 1.0001, 3.0}) {
    HostileScene& scene = table.add("glass ball of index " + std::to_string(eta), Paths::through_delta,
                                    [=](Builder& b) { ball_in_sky(b, make_dielectric(eta)); });
    scene.radiance = 1.0;
    scene.max_depth = 32;
    table.add("rough glass of index " + std::to_string(eta),
              eta == 1.0 || eta == 1.0001 ? Paths::through_delta : Paths::all,
              [=](Builder& b) { ball_in_sky(b, make_dielectric(eta, 0.3)); });
  }
  table.add("mirror ball", Paths::through_delta, [](Builder& b) { ball_in_sky(b, make_mirror(Colour(1))); }).radiance =
      1.0;
  for (const double alpha : {1e-4, 1e-3, 0.01, 1.0}) {
    const auto paths = alpha < smallest_alpha ? Paths::through_delta : alpha < 0.1 ? Paths::narrow : Paths::all;
    const std::string with = " of alpha " + std::to_string(alpha);
    table.add("metal" + with, paths,
              [=](Builder& b) { ball_in_sky(b, make_conductor(Colour(0.2, 0.9, 1.1), Colour(3.9, 2.4, 2.2), alpha)); });
    table.add("coat" + with, paths, [=](Builder& b) { ball_in_sky(b, make_coated_diffuse(Colour(0.6), 1.5, alpha)); });
    table.add("glass" + with, paths, [=](Builder& b) { ball_in_sky(b, make_dielectric(1.5, alpha)); });
  }
  for (const double exponent : {1.0, 100.0, 1e6}) {
    const auto paths = exponent > 1e4 ? Paths::narrow : exponent > 1 ? Paths::narrow_for_ppm : Paths::all;
    table.add("Phong with exponent " + std::to_string(exponent), paths,
              [=](Builder& b) { ball_in_sky(b, make_phong(Colour(0.3), Colour(0.6), exponent)); });
  }
  for (const double albedo : {0.0, 1.0}) {
    table.add("diffuse ball of albedo " + std::to_string(albedo),
              [=](Builder& b) { ball_under_lamp(b, make_diffuse(Colour(albedo))); });
    table.add("Phong ball of albedo " + std::to_string(albedo),
              [=](Builder& b) { ball_under_lamp(b, make_phong(Colour(0), Colour(albedo), 1)); });
    table.add("coated ball over albedo " + std::to_string(albedo), Paths::through_delta,
              [=](Builder& b) { ball_under_lamp(b, make_coated_diffuse(Colour(albedo), 1.5, 0)); });
  }
  table.add("glass ball under a lamp", Paths::through_delta,
            [](Builder& b) { ball_under_lamp(b, make_dielectric(1.5)); });
  table.add("very rough metal under a lamp",
            [](Builder& b) { ball_under_lamp(b, make_conductor(Colour(0), Colour(1e6), 1, Masking::separable)); });
  // Total reflection exactly at the critical angle: a prism of index √2 has it at 45°.
  table
      .add("prism at the critical angle", Paths::through_delta,
           [](Builder& b) {
             Mesh prism;
             prism.positions = {{-1, -1, -1}, {1, -1, -1}, {-1, 1, -1}, {-1, -1, 1}, {1, -1, 1}, {-1, 1, 1}};
             prism.triangles = {{0, 2, 1}, {3, 4, 5}, {0, 1, 4}, {0, 4, 3}, {0, 3, 5}, {0, 5, 2}, {1, 2, 5}, {1, 5, 4}};
             b.add_mesh(prism.shape(), b.add_material(make_dielectric(std::sqrt(2.0))));
             b.add_environment(Colour(1));
             look(b, {-0.3, -5, 0}, {-0.3, 0, 0}, 10);
           })
      .max_depth = 40;
  table.scenes.back().radiance = 1.0;
}

void add_lights(Table& table) {
  table
      .add("no light",
           [](Builder& b) {
             floor_and_wall(b);
             look(b, {0, 0.5, -2}, {0, 0.3, 0}, 40);
           })
      .radiance = 0.0;
  table
      .add("black lights of every kind",
           [](Builder& b) {
             floor_and_wall(b);
             b.add_sphere({0, 0.5, 0}, 0.2, diffuse(b), AreaEmission{Colour(0)});
             b.add_point_light({0, 1, 0}, Colour(0));
             b.add_spot_light({0, 1, 0}, {0, -1, 0}, Colour(0), 0.1, 0.2);
             b.add_directional_light({0, 1, 0}, Colour(0));
             b.add_environment(Colour(0));
             b.add_environment(EnvironmentImage{{2, 2}, std::vector<glm::vec3>(4, glm::vec3(0))});
             look(b, {0, 0.5, -2}, {0, 0.3, 0}, 40);
           })
      .radiance = 0.0;
  table.add("black lights among one that shines", [](Builder& b) {
    floor_and_wall(b);
    b.add_sphere({0.5, 0.5, 0}, 0.2, diffuse(b), AreaEmission{Colour(0)});
    b.add_point_light({0, 1, 0}, Colour(0));
    b.add_environment(Colour(1, 0, 0.5));
    look(b, {0, 0.5, -2}, {0, 0.3, 0}, 40);
  });
  // A lamp of 1e-6 × 1e-6 near the camera on a floor of 1e6 × 1e6.
  table
      .add("a light of area 1e-12 in a scene of size 1e6",
           [](Builder& b) {
             floor_and_wall(b);
             quad(b, {-5e5, -5e5, 5e5}, {0, 1e6, 0}, {1e6, 0, 0}, diffuse(b));
             quad(b, {0, 0.5, 0}, {1e-6, 0, 0}, {0, 0, 1e-6}, diffuse(b, 0), AreaEmission{Colour(1e12)});
             look(b, {0.2, 1, -1}, {0, 0, 0}, 30);
           })
      .radius = 3e-8;  // of half a diagonal of 7e5
  table
      .add("a light of area 1e-12 over a floor of size 1e6",
           [](Builder& b) {
             quad(b, {-5e5, 0, -5e5}, {0, 0, 1e6}, {1e6, 0, 0}, diffuse(b));
             quad(b, {0, 0.5, 0}, {1e-6, 0, 0}, {0, 0, 1e-6}, diffuse(b, 0), AreaEmission{Colour(1e12)});
             look(b, {0.2, 1, -1}, {0, 0, 0}, 30);
           })
      .has_heavy_tail = true;  // places on the floor are known to 2.4: finite, and no more
  // pt does not find the spot of light below it.
  table
      .add("a point light a ten-thousandth above the floor",
           [](Builder& b) {
             floor_and_wall(b);
             b.add_point_light({0, 1e-4, 0}, Colour(1));
             look(b, {0, 0.7, -1.5}, {0, 0.3, 1}, 30);
           })
      .has_heavy_tail = true;
  table.add("a point light in the floor", [](Builder& b) {
    floor_and_wall(b);
    b.add_point_light({0, 0, 0}, Colour(1));
    look(b, {0, 0.7, -1.5}, {0, 0.3, 1}, 30);
  });
  table.add("a point light in the corner of two walls", [](Builder& b) {
    floor_and_wall(b);
    b.add_point_light({0, 0.05, 0.95}, Colour(1));
    look(b, {0, 0.5, -1.5}, {0, 0.3, 0.3}, 30);
  });
  for (const double angle : {1e-3, 0.1}) {
    HostileScene& spot = table.add("a spot light of " + std::to_string(angle), [=](Builder& b) {
      floor_and_wall(b);
      b.add_spot_light({0, 2, 0.5}, {0, -1, 0}, Colour(1 / (angle * angle)), angle, 1.1 * angle);
      look(b, {0, 0.7, -1.5}, {0, 0.3, 1}, 30);
    });
    spot.has_heavy_tail = angle < 0.01;  // pt does not find it
  }
  for (const double slope : {1e-4, 0.1}) {
    HostileScene& sun = table.add("a sun that grazes the floor by " + std::to_string(slope), [=](Builder& b) {
      floor_and_wall(b);
      b.add_directional_light({1, slope, 0}, Colour(1 / slope));
      look(b, {0, 0.5, -1.5}, {0, 0, 0}, 20);
    });
    sun.radius = 0.02;
    sun.bias = 0.06;
    sun.has_heavy_tail = slope < 0.01;  // hardly a light path hits the floor
  }
  table
      .add("a light inside a glass ball", Paths::through_delta,
           [](Builder& b) {
             quad(b, {-3, -1, -3}, {0, 0, 6}, {6, 0, 0}, diffuse(b));
             b.add_sphere({0, 0, 0}, 1, b.add_material(make_dielectric(1.5)));
             b.add_sphere({0, 0, 0}, 0.5, diffuse(b, 0), AreaEmission{Colour(1)});
             look(b, {0, 1, -5}, {0, -0.5, 0}, 30);
           })
      .max_depth = 8;
  table
      .add("a lamp that touches glass", Paths::through_delta,
           [](Builder& b) {
             quad(b, {-3, -1, -3}, {0, 0, 6}, {6, 0, 0}, diffuse(b));
             b.add_sphere({0, 0, 0}, 1, b.add_material(make_dielectric(1.5)));
             quad(b, {-1, 1, -1}, {2, 0, 0}, {0, 0, 2}, diffuse(b, 0), AreaEmission{Colour(1)});
             look(b, {0, 0.5, -5}, {0, -0.5, 0}, 30);
           })
      .max_depth = 8;
  HostileScene& inside = table.add("a camera inside glass, the sky outside", Paths::through_delta, [](Builder& b) {
    b.add_sphere({0, 0, 0}, 1, b.add_material(make_dielectric(1.5)));
    b.add_environment(Colour(1));
    look(b, {0, 0, 0}, {0, 0, 1}, 30);  // head on everywhere: no total reflection
  });
  inside.radiance = 1.5 * 1.5;
  inside.max_depth = 16;
  HostileScene& within = table.add("a camera near the wall inside glass", Paths::through_delta, [](Builder& b) {
    b.add_sphere({0, 0, 0}, 1, b.add_material(make_dielectric(1.5)));
    b.add_environment(Colour(1));
    look(b, {0, 0, -1 + 1e-6}, {0, 0, 1}, 30);
  });
  within.radiance = 1.5 * 1.5;
  within.max_depth = 16;
  table.add("a camera on the floor, looking along it", [](Builder& b) {
    floor_and_wall(b);
    b.add_sphere({0, 0.3, 0.3}, 0.2, diffuse(b));
    b.add_environment(Colour(1));
    look(b, {0, 0, -0.9}, {0, 0.01, 1}, 50);
  });
  table.add("a camera that touches a lamp", [](Builder& b) {
    floor_and_wall(b);
    quad(b, {-0.2, 0.8, -0.2}, {0.4, 0, 0}, {0, 0, 0.4}, diffuse(b, 0.5), AreaEmission{Colour(3)});
    look(b, {0, 0.8, 0}, {0, 0, 0.2}, 60);
  });
  table.add("a camera that touches a glowing ball", [](Builder& b) {
    floor_and_wall(b);
    b.add_sphere({0, 0.6, 0}, 0.2, diffuse(b, 0.5), AreaEmission{Colour(3)});
    look(b, {0, 0.4, 0}, {0, 0, 0.2}, 60);
  });
  table.add("a sky with one pixel 1e8 times the others", [](Builder& b) {
    floor_and_wall(b);
    std::vector<glm::vec3> sky(64 * 64, glm::vec3(1));
    sky[64 * 30 + 34] = glm::vec3(1e8F);
    b.add_environment(EnvironmentImage{{64, 64}, sky}, glm::dmat3(1, 0, 0, 0, 0, -1, 0, 1, 0));
    look(b, {0, 0.7, -1.5}, {0, 0.3, 1}, 30);
  });
  table.add("lights from 1e-12 to 1e12", [](Builder& b) {
    floor_and_wall(b);
    for (int e = -12; e <= 12; e += 4) b.add_point_light({0.06 * e, 0.8, -0.3}, Colour(std::pow(10.0, e)));
    look(b, {0, 0.7, -1.5}, {0, 0.3, 1}, 30);
  });
  table.add("two-sided lamps back to back", [](Builder& b) {
    floor_and_wall(b);
    quad(b, {-0.2, 0.6, -0.2}, {0.4, 0, 0}, {0, 0, 0.4}, diffuse(b), AreaEmission{Colour(2), true});
    quad(b, {-0.2, 0.6 + 1e-4, -0.2}, {0.4, 0, 0}, {0, 0, 0.4}, diffuse(b), AreaEmission{Colour(2), true});
    look(b, {0, 0.7, -1.5}, {0, 0.3, 1}, 40);
  });
}

void add_geometry(Table& table) {
  table.add("surfaces twice in one place", [](Builder& b) {
    floor_and_wall(b);
    floor_and_wall(b);
    b.add_sphere({0, 0.5, 0}, 0.2, diffuse(b));
    b.add_sphere({0, 0.5, 0}, 0.2, diffuse(b));
    b.add_environment(Colour(1));
    look(b, {0, 0.7, -1.5}, {0, 0.3, 1}, 40);
  });
  table
      .add("a slab of glass a millionth thick", Paths::through_delta,
           [](Builder& b) {
             floor_and_wall(b);
             b.add_mesh(scene_test::box({-1, 0.3, -1}, {1, 0.3 + 1e-6, 1}).shape(),
                        b.add_material(make_dielectric(1.5)));
             b.add_environment(Colour(1));
             look(b, {0, 0.7, -1.5}, {0, 0, 0.5}, 30);
           })
      .max_depth = 8;
  table
      .add("bodies that run through each other", Paths::through_delta,
           [](Builder& b) {
             floor_and_wall(b);
             b.add_mesh(scene_test::box({-0.3, -0.1, -0.3}, {0.3, 0.4, 0.3}).shape(),
                        b.add_material(make_dielectric(1.5)));
             b.add_sphere({0, 0.4, 0}, 0.3, b.add_material(make_dielectric(1.3)));
             b.add_sphere({0.2, 0.2, 0}, 0.2, diffuse(b));
             b.add_environment(Colour(1));
             look(b, {0, 0.7, -1.5}, {0, 0.3, 0}, 30);
           })
      .max_depth = 8;
  table.add("a fan of needles", [](Builder& b) {
    Mesh fan;
    fan.positions.push_back({0, 1e-3, 0});
    for (int i = 0; i <= 2000; ++i) {
      const double angle = 2 * gmis::pi<double> * i / 2000;
      fan.positions.push_back({std::cos(angle), 0, std::sin(angle)});
      if (i > 0) fan.triangles.push_back({0, i + 1, i});
    }
    b.add_mesh(fan.shape(), diffuse(b));
    b.add_environment(Colour(1));
    look(b, {0.2, 1, 0.1}, {0, 0, 0}, 20);
  });
  table.add("shading normals that turn away", [](Builder& b) {
    Philox source(17);
    const Mesh mesh = scene_test::bumpy_ball({0, 0.5, 0}, 0.5, 5, source);
    std::vector<glm::dvec3> normals;
    for (std::size_t i = 0; i < mesh.positions.size(); ++i)
      normals.push_back(glm::dvec3(scene_test::random_direction<double>(source)));
    b.add_mesh({mesh.positions, mesh.triangles, normals}, diffuse(b));
    floor_and_wall(b);
    b.add_environment(Colour(1));
    look(b, {0, 0.7, -1.5}, {0, 0.3, 0}, 30);
  });
  for (const double size : {1e-5, 1e5})
    table
        .add("the stage with parallel rays and a ball of size " + std::to_string(size),
             [=](Builder& b) {
               make_stage(b, 1, {});
               b.add_sphere({0, 0.2, -0.5}, 0.1 * std::min(1.0, size), diffuse(b));
               if (size > 1) b.add_sphere({0, -size, 0}, size - 0.01, diffuse(b));
               CameraDescription camera =
                   look_at({0, 1.2, -3}, {0, 0.4, 0}, {0, 1, 0}, 30, {picture_size, picture_size});
               camera.projection = Projection::orthographic;
               b.set_camera(camera);
             })
        .radius = size > 1 ? 1e-7 : 0.005;
}

}  // namespace

void make_stage(Builder& builder, double scale, const Place& shift) {
  const auto at = [&](const Place& p) { return p * scale + shift; };
  quad(builder, at({-2, 0, -2}), Place(0, 0, 4) * scale, Place(4, 0, 0) * scale, diffuse(builder, 0.6));
  quad(builder, at({-2, 0, 2}), Place(0, 3, 0) * scale, Place(4, 0, 0) * scale,
       builder.add_material(make_diffuse(Colour(0.3, 0.5, 0.7))));
  builder.add_sphere(at({-0.5, 0.5, 0.3}), 0.5 * scale, builder.add_material(make_phong(Colour(0.3), Colour(0.4), 20)));
  builder.add_sphere(at({0.7, 0.4, 0}), 0.4 * scale, builder.add_material(make_dielectric(1.5, 0.3)));
  quad(builder, at({-0.5, 2.5, -0.5}), Place(1, 0, 0) * scale, Place(0, 0, 1) * scale, diffuse(builder, 0),
       AreaEmission{Colour(6)});
  builder.add_point_light(at({1, 2, -1}), Colour(2) * scale * scale);
  look(builder, at({0, 1.2, -3}), at({0, 0.6, 0}), 40);
}

std::vector<HostileScene> hostile_scenes() {
  Table table;
  add_furnaces(table);
  add_materials(table);
  add_lights(table);
  add_geometry(table);
  return std::move(table.scenes);
}

}  // namespace hostile
