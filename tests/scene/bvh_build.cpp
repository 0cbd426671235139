#include "gmis/scene/bvh_build.hpp"

#include <cstring>
#include <thread>

#include "scene/shapes.hpp"
#include "support/catch.hpp"
#include "support/counted_memory.hpp"
#include "support/fewer.hpp"
#include "support/seed.hpp"

// The builder: the same bits for any number of threads, every primitive in one slot and within all
// boxes above it, and no more memory than stated.

using namespace gmis;
using namespace gmis::scene;
using namespace scene_test;

namespace {

/// A thread takes every n-th piece, the last ones first.
struct Threads {
  std::size_t count;
  template <class Work>
  void parallel_for(std::size_t pieces, Work&& work) const {
    std::vector<std::thread> threads;
    for (std::size_t thread = 0; thread < count; ++thread)
      threads.emplace_back([&, thread] {
        for (std::size_t i = pieces; i-- > 0;)
          if (i % count == thread) work(i);
      });
    for (std::thread& thread : threads) thread.join();
  }
};

template <std::floating_point T>
struct Shapes {
  std::vector<TriangleCorners<T>> triangles;
  std::vector<SphereShape<T>> spheres;
};

/// Many sizes; now and then a primitive that was there before, and triangles that share one plane.
template <std::floating_point T>
Shapes<T> random_shapes(std::size_t triangles, std::size_t spheres, Philox& source) {
  Shapes<T> shapes;
  for (std::size_t i = 0; i < triangles; ++i) {
    const glm::dvec3 center = random_in_cube(source) * 10.0;
    const double size = random_magnitude(source, -3, 0);
    TriangleCorners<T> corners;
    for (Vec3<T>& corner : corners) {
      corner = Vec3<T>(center + random_in_cube(source) * size);
      if (i % 7 == 0) corner.y = 1;
    }
    shapes.triangles.push_back(i % 11 == 10 ? shapes.triangles[i / 2] : corners);
  }
  for (std::size_t i = 0; i < spheres; ++i)
    shapes.spheres.push_back({Vec3<T>(random_in_cube(source) * 10.0), T(random_magnitude(source, -3, 0))});
  return shapes;
}

/// Whether the two hold the same bits, member by member.
template <class Vector>
bool same_bits(const Vector& a, const Vector& b) {
  static_assert(std::is_trivially_copyable_v<typename Vector::value_type>);
  return a.size() == b.size() && (a.empty() || std::memcmp(a.data(), b.data(), a.size() * sizeof(a[0])) == 0);
}

template <std::floating_point T>
struct Checker {
  const Shapes<T>& shapes;
  const BuiltBvh<T>& built;
  std::vector<int> found_triangles = std::vector<int>(shapes.triangles.size());
  std::vector<int> found_spheres = std::vector<int>(shapes.spheres.size());
  int outside = 0;

  /// `lower` and `upper` enclose all that is below `child`.
  void visit(BvhChild child, const Vec3<T>& lower, const Vec3<T>& upper) {
    const auto is_within = [&](const Vec3<T>& low, const Vec3<T>& high) {
      return glm::all(glm::lessThanEqual(lower, low)) && glm::all(glm::lessThanEqual(high, upper));
    };
    if (child.kind() == BvhChild::node) {
      const BvhNode<T>& node = built.bvh.nodes[child.index()];
      for (std::size_t lane = 0; lane < lane_count; ++lane) {
        if (node.children[lane].kind() == BvhChild::nothing) continue;
        const Vec3<T> low(node.plane(0, lane), node.plane(2, lane), node.plane(4, lane));
        const Vec3<T> high(node.plane(1, lane), node.plane(3, lane), node.plane(5, lane));
        outside += is_within(low, high) ? 0 : 1;
        visit(node.children[lane], low, high);
      }
      return;
    }
    for (std::size_t lane = 0; lane < lane_count; ++lane) {
      const std::size_t slot = child.index() * lane_count + lane;
      const bool is_triangle = child.kind() == BvhChild::triangles;
      const std::uint32_t index = is_triangle ? built.triangle_in_slot[slot] : built.sphere_in_slot[slot];
      if (index == BuiltBvh<T>::empty_slot) continue;
      if (is_triangle) {
        ++found_triangles[index];
        const auto& packet = built.bvh.triangles[child.index()];
        for (std::size_t k = 0; k < 3; ++k) {
          const Vec3<T> corner(packet.corners[k][0][lane], packet.corners[k][1][lane], packet.corners[k][2][lane]);
          outside += corner == shapes.triangles[index][k] && is_within(corner, corner) ? 0 : 1;
        }
      } else {
        ++found_spheres[index];
        const auto& sphere = shapes.spheres[index];
        outside += is_within(sphere.center - sphere.radius, sphere.center + sphere.radius) ? 0 : 1;
      }
    }
  }
};

}  // namespace

TEMPLATE_TEST_CASE("a tree holds every primitive once, within the boxes above it", "[bvh]", float, double) {
  using T = TestType;
  Philox source(gmis_test::seed(29));
  for (const auto& [triangles, spheres] :
       {std::pair{1U, 0U}, {0U, 1U}, {1U, 1U}, {8U, 0U}, {5U, 3U}, {0U, 9U}, {100U, 50U}, {9000U, 4000U}}) {
    const auto shapes = random_shapes<T>(triangles, spheres, source);
    const auto built = BvhBuilder<T>(shapes.triangles, shapes.spheres).build();
    Checker<T> checker{shapes, built};
    const T all = std::numeric_limits<T>::max();
    checker.visit(built.bvh.root, Vec3<T>(-all), Vec3<T>(all));
    CAPTURE(triangles, spheres);
    CHECK(checker.outside == 0);
    CHECK(std::all_of(checker.found_triangles.begin(), checker.found_triangles.end(), [](int n) { return n == 1; }));
    CHECK(std::all_of(checker.found_spheres.begin(), checker.found_spheres.end(), [](int n) { return n == 1; }));
  }
}

TEMPLATE_TEST_CASE("a tree has the same bits for any number of threads", "[bvh]", float, double) {
  using T = TestType;
  Philox source(gmis_test::seed(30));
  // Enough for several levels that all threads share.
  const auto shapes = random_shapes<T>(60'000 / gmis_test::fewer, 20'000 / gmis_test::fewer, source);
  const BvhBuilder<T> builder(shapes.triangles, shapes.spheres);
  const BuiltBvh<T> serial = builder.build();
  for (const std::size_t count : {1U, 2U, 5U}) {
    Threads threads{count};
    const BuiltBvh<T> parallel = builder.build(threads);
    CAPTURE(count);
    CHECK(parallel.bvh.root.code == serial.bvh.root.code);
    CHECK(same_bits(parallel.bvh.nodes, serial.bvh.nodes));
    CHECK(same_bits(parallel.bvh.triangles, serial.bvh.triangles));
    CHECK(same_bits(parallel.bvh.spheres, serial.bvh.spheres));
    CHECK(same_bits(parallel.triangle_in_slot, serial.triangle_in_slot));
    CHECK(same_bits(parallel.sphere_in_slot, serial.sphere_in_slot));
  }
}

// Where small triangles lie far apart, packets of one or two are the quickest, and take more.
TEST_CASE("building takes at most 80 bytes a triangle of a mesh or a dense soup, the result included", "[bvh]") {
  Philox source(gmis_test::seed(31));
  std::vector<TriangleCorners<float>> ball, soup;
  const Mesh mesh = bumpy_ball({0, 0, 0}, 1, 150, source);
  for (const auto& t : mesh.triangles) {
    const auto corner = [&](std::size_t k) { return Vec3<float>(mesh.positions[static_cast<std::size_t>(t[k])]); };
    ball.push_back({corner(0), corner(1), corner(2)});
  }
  for (int i = 0; i < 90'000; ++i) {
    const glm::dvec3 center = random_in_cube(source) * 10.0;
    const auto corner = [&] { return Vec3<float>(center + random_in_cube(source)); };
    soup.push_back({corner(), corner(), corner()});
  }
  for (const auto& triangles : {ball, soup}) {
    const std::size_t before = counted_memory::now;
    counted_memory::peak = before;
    const auto built = BvhBuilder<float>(triangles, {}).build();
    CHECK(counted_memory::peak - before <= 80 * triangles.size());
    CHECK(counted_memory::now - before <= 64 * triangles.size());
  }
}
