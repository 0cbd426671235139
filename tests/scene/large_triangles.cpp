#include <algorithm>
#include <map>
#include <tuple>

#include "gmis/scene/cut_large_triangles.hpp"
#include "scene/shapes.hpp"
#include "support/catch.hpp"
#include "support/seed.hpp"

using namespace gmis;
using namespace gmis::scene;
using namespace scene_test;

namespace {

using Corners = std::array<glm::dvec3, 3>;

glm::dvec3 area_of(const Corners& c) {
  return glm::cross(c[1] - c[0], c[2] - c[0]);
}

/// Distance of 0 from a segment, by a search that knows no formula.
double distance_of(const glm::dvec3& a, const glm::dvec3& b) {
  double lower = 0, upper = 1;
  const auto at = [&](double t) { return glm::length(a + (b - a) * t); };
  for (int i = 0; i < 200; ++i) {
    const double one = lower + (upper - lower) / 3, other = upper - (upper - lower) / 3;
    (at(one) < at(other) ? upper : lower) = at(one) < at(other) ? other : one;
  }
  return at((lower + upper) / 2);
}

/// A point in a cube around the origin whose half side is any size from 0.1 to 1e5.
glm::dvec3 random_point(Philox& source) {
  const double size = std::pow(10.0, 6 * uniform<double>(source) - 1);
  const auto coordinate = [&] { return size * (2 * uniform<double>(source) - 1); };
  const double x = coordinate(), y = coordinate();
  return {x, y, coordinate()};
}

constexpr double largest_size = 20, least_distance = 0.01;
constexpr LargeTriangleCutter cutter(largest_size, least_distance);

std::vector<TrianglePiece> pieces_of(const Corners& triangle) {
  std::vector<TrianglePiece> pieces;
  cutter.for_each_piece(triangle, [&](const TrianglePiece& piece) { pieces.push_back(piece); });
  return pieces;
}

TEST_CASE("the pieces of a large triangle tile it, and are small where they are near", "[large_triangles]") {
  Philox source(gmis_test::seed(631));
  std::size_t most = 0;
  for (int i = 0; i < 400; ++i) {
    Corners triangle{random_point(source), random_point(source), random_point(source)};
    // Some have 0 above their middle, or on them.
    if (i % 4 == 0) triangle[2] = (triangle[0] + triangle[1]) * -1.0 + glm::dvec3(0, 0, uniform<double>(source));
    if (i % 20 == 0) triangle[2] = (triangle[0] + triangle[1]) * -1.0;
    const auto pieces = pieces_of(triangle);
    most = std::max(most, pieces.size());
    const glm::dvec3 whole = area_of(triangle);
    const double scale = std::max({glm::length(triangle[0]), glm::length(triangle[1]), glm::length(triangle[2])});
    glm::dvec3 sum(0);
    for (const TrianglePiece& piece : pieces) {
      const glm::dvec3 area = area_of(piece.corners);
      CHECK(glm::dot(area, whole) >= -1e-14 * scale * scale * glm::length(whole));  // with the sum: no overlap
      sum += area;
      for (int k = 0; k < 3; ++k) {
        const glm::dvec3 w = piece.weights[k];
        CHECK(std::min({w[0], w[1], w[2]}) >= 0.0);
        const glm::dvec3 at = triangle[0] * w[0] + triangle[1] * w[1] + triangle[2] * w[2];
        CHECK(glm::length(at - piece.corners[static_cast<std::size_t>(k)]) <= 1e-13 * scale);
        const auto& a = piece.corners[static_cast<std::size_t>(k)];
        const auto& b = piece.corners[static_cast<std::size_t>((k + 1) % 3)];
        CHECK(glm::length(b - a) <= 1.0001 * largest_size * std::max(least_distance, distance_of(a, b)));
      }
    }
    CHECK(glm::length(sum - whole) <= 1e-12 * scale * scale);
    CHECK(pieces.size() < 3000);
  }
  CHECK(most > 50);
}

/// The smallest height of a triangle over its longest edge.
double flatness(const Corners& c) {
  const double longest2 = std::max(
      {glm::dot(c[1] - c[0], c[1] - c[0]), glm::dot(c[2] - c[0], c[2] - c[0]), glm::dot(c[2] - c[1], c[2] - c[1])});
  return glm::length(area_of(c)) / longest2;
}

TEST_CASE("no piece is so thin that rounding takes its area", "[large_triangles]") {
  // 0 is as far from the triangle as makes it be cut, above its inside, an edge or a corner,
  // exactly or nearly.
  Philox source(gmis_test::seed(635));
  double flattest = 1;
  std::size_t inside = 0;
  for (int i = 0; i < 3000; ++i) {
    const double height = random_magnitude(source, -2, 0);
    glm::dvec3 weights(uniform<double>(source), uniform<double>(source), uniform<double>(source));
    if (i % 3 > 0) weights[0] = i % 2 == 0 ? 0 : random_magnitude(source, -18, -2);
    if (i % 3 > 1) weights[1] = i % 2 == 0 ? 0 : random_magnitude(source, -18, -2);
    weights /= weights[0] + weights[1] + weights[2];
    Corners triangle{glm::dvec3(0, 0, 0), glm::dvec3(1, 0, 0), glm::dvec3(uniform<double>(source), 0.5, 0)};
    const glm::dvec3 eye = triangle[0] * weights[0] + triangle[1] * weights[1] + triangle[2] * weights[2];
    const auto frame = Frame<double>::around(random_direction<double>(source));
    for (auto& corner : triangle) corner = frame.to_world(corner - eye + glm::dvec3(0, 0, height)) * 100.0;
    for (const TrianglePiece& piece : pieces_of(triangle)) {
      flattest = std::min(flattest, flatness(piece.corners));
      if (std::min({piece.weights[0][0], piece.weights[0][1], piece.weights[0][2]}) > 0) ++inside;
    }
  }
  CHECK(inside > 1000);
  CAPTURE(flattest);
  CHECK(flattest > 1e-5);  // a hundred roundings in float
}

TEST_CASE("neighbours are cut at the same points", "[large_triangles]") {
  Philox source(gmis_test::seed(632));
  for (int i = 0; i < 200; ++i) {
    const glm::dvec3 a = random_point(source), b = random_point(source), c = random_point(source),
                     d = random_point(source);
    // In each order of the corners of the second one.
    Corners other{b, a, d};
    std::rotate(other.begin(), other.begin() + i % 3, other.end());
    using Point = std::tuple<double, double, double>;
    const auto key = [](const glm::dvec3& v) { return Point(v.x, v.y, v.z); };
    std::map<std::pair<Point, Point>, int> edges;
    for (const Corners& triangle : {Corners{a, b, c}, other})
      for (const TrianglePiece& piece : pieces_of(triangle))
        for (std::size_t k = 0; k < 3; ++k) {
          const Point from = key(piece.corners[k]), to = key(piece.corners[(k + 1) % 3]);
          ++edges[{from, to}];
          --edges[{to, from}];
        }
    // What has no edge the other way is the outline: it closes without a point where an edge ends
    // within another.
    std::map<Point, int> ends;
    double outline = 0;
    for (const auto& [edge, count] : edges)
      if (count > 0) {
        REQUIRE(count == 1);
        ++ends[edge.first];
        --ends[edge.second];
        const auto [ax, ay, az] = edge.first;
        const auto [bx, by, bz] = edge.second;
        outline += glm::length(glm::dvec3(bx - ax, by - ay, bz - az));
      }
    for (const auto& [point, count] : ends) CHECK(count == 0);
    const double expected = glm::length(c - b) + glm::length(a - c) + glm::length(d - a) + glm::length(b - d);
    CHECK(outline == Approx(expected).epsilon(1e-12));
  }
}

/// Two triangles, 20,000 units wide, at this height, the camera above their middle.
Mesh ground(double y, double half_width = 1e4) {
  Mesh mesh;
  mesh.positions = {{-half_width, y, -half_width},
                    {half_width, y, -half_width},
                    {-half_width, y, half_width},
                    {half_width, y, half_width}};
  mesh.triangles = {{0, 2, 3}, {0, 3, 1}};
  return mesh;
}

TEST_CASE("a ray that leaves a huge ground does not start inside what lies on it", "[large_triangles]") {
  SceneBuilder<> builder;
  const auto white = builder.add_material(make_diffuse({.5, .5, .5}));
  builder.add_mesh(ground(-1.6).shape(), white);
  builder.set_camera(camera_at({0, 0, 0}));
  const auto scene = builder.build();
  CHECK(scene.statistics().triangle_count == 2);
  // A ball of radius 0.5 would lie at the foot of the camera's path: the gap beneath it, 0.1 from
  // where it touches, is 0.01.
  Philox source(gmis_test::seed(633));
  float farthest = 0;
  for (int i = 0; i < 1000; ++i) {
    const float x = 4 * uniform<float>(source) - 2, z = 2 + 2 * uniform<float>(source);
    const Vec3<float> direction = glm::normalize(Vec3<float>(x, -1.6F, z));
    const auto hit = scene.intersect({{0, 0, 0}, direction});
    REQUIRE(hit);
    CHECK(hit->point.position.y == Approx(-1.6).margin(1e-5));
    CHECK(hit->point.geometric_normal.y == 1.0F);
    const Ray<float> ray = leave(hit->point, Vec3<float>(0, 1, 0));
    CHECK(ray.origin.y > -1.6F);
    farthest = std::max(farthest, ray.origin.y + 1.6F);
    CHECK(scene.visible(ray));
    CHECK(scene.visible(leave(hit->point, Vec3<float>(0, -1, 0))));
  }
  CHECK(farthest < 5e-4F);
}

TEST_CASE("lights and what is small or far stay whole, and so does all in double", "[large_triangles]") {
  for (const double height : {0.0, -1.6, -1e3}) {
    SceneBuilder<> emitting;
    emitting.add_mesh(ground(height).shape(), emitting.add_material(make_diffuse({0, 0, 0})), AreaEmission{});
    emitting.set_camera(camera_at({0, 0, 0}));
    const auto scene = emitting.build();
    CHECK(scene.lights().size() == 2);
    CHECK(scene.statistics().light_count == 2);
  }
  const auto bytes = [](double height, double half_width, auto scalar) {
    SceneBuilder<decltype(scalar)> builder;
    builder.add_mesh(ground(height, half_width).shape(),
                     builder.add_material(make_diffuse<decltype(scalar)>({.5, .5, .5})));
    builder.set_camera(camera_at({0, 0, 0}));
    return builder.build().statistics().bvh_bytes;
  };
  CHECK(bytes(-1.6, 1e4, 1.0F) > 4 * bytes(-1.6, 8, 1.0F));
  CHECK(bytes(-1e4, 1e4, 1.0F) == bytes(-1.6, 8, 1.0F));
  CHECK(bytes(-1.6, 1e4, 1.0) == bytes(-1.6, 8, 1.0));
}

TEST_CASE("normals and coordinates of a piece are those of the whole", "[large_triangles]") {
  const std::vector<glm::dvec3> normals{{0, 1, 0}, {0.6, 0.8, 0}, {0, 1, 2}, {-1, 2, 0.5}};
  const std::vector<glm::dvec2> uv{{0, 0}, {1, 0}, {0, 1}, {1, 1}};
  const Mesh mesh = ground(-1.6, 1e3);
  const auto built = [&](auto scalar) {
    using T = decltype(scalar);
    auto image = std::make_shared<TextureImage>();
    image->resolution = {2, 2};
    image->floats = {0, 1, 0.3F, 1, 1, 0.3F, 0, 0, 0.3F, 1, 0, 0.3F};
    MaterialTextures<T> textures;
    textures.color = Texture<T>::image(image, {{0.5, 0.5}, {0.25, 0.25}}, TextureWrap::clamp);
    SceneBuilder<T> builder;
    const auto material = builder.add_material(with_textures(make_diffuse<T>({1, 1, 1}), textures));
    builder.add_mesh({mesh.positions, mesh.triangles, normals, uv}, material);
    builder.set_camera(camera_at({0, 0, 0}));
    return builder.build();
  };
  const auto cut = built(1.0F);
  const auto whole = built(1.0);
  CHECK(cut.statistics().bvh_bytes > 2 * whole.statistics().bvh_bytes);
  Philox source(gmis_test::seed(634));
  int compared = 0;
  for (int i = 0; i < 2000; ++i) {
    const double reach = std::pow(10.0, 3 * uniform<double>(source));
    const double angle = 2 * pi<double> * uniform<double>(source);
    const glm::dvec3 direction = glm::normalize(glm::dvec3(reach * std::cos(angle), -1.6, reach * std::sin(angle)));
    const auto hit = cut.intersect({{0, 0, 0}, Vec3<float>(direction)});
    const auto exact = whole.intersect({{0, 0, 0}, direction});
    if (!hit || !exact) continue;  // at the rim
    ++compared;
    const double off = glm::length(glm::dvec3(hit->point.position) - exact->point.position);
    CHECK(off < 1e-3 * reach * reach);  // where the rounded direction goes
    CHECK(glm::length(glm::dvec3(hit->point.shading_normal) - exact->point.shading_normal) < 1e-4 + 3e-3 * off);
    CHECK(glm::length(glm::dvec3(hit->bsdf.albedo()) - exact->bsdf.albedo()) < 1e-4 + 3e-3 * off);
  }
  CHECK(compared > 1990);
}

}  // namespace
