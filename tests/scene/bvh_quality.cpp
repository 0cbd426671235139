#include <cmath>
#include <cstdio>
#include <numeric>

#include "gmis/scene/bvh_build.hpp"
#include "scene/shapes.hpp"
#include "support/catch.hpp"
#include "support/seed.hpp"

// How good the tree is: what a random line and what closest-hit rays visit in it, beside a tree
// over the same triangles that a full sweep makes. The sweep is written here, in double: at every
// node it tries all n − 1 cuts along each axis.

using namespace gmis;
using namespace gmis::scene;
using namespace scene_test;

namespace {

using Triangles = std::vector<TriangleCorners<float>>;

struct Bounds {
  glm::dvec3 lower{std::numeric_limits<double>::infinity()}, upper{-std::numeric_limits<double>::infinity()};
  [[nodiscard]] Bounds joined(const Bounds& other) const {
    return {glm::min(lower, other.lower), glm::max(upper, other.upper)};
  }
  [[nodiscard]] double half_area() const {
    const glm::dvec3 size = upper - lower;
    return size.x * size.y + size.y * size.z + size.z * size.x;
  }
  /// The parameter t at which a line from `origin` enters, 0 if it begins inside; infinity where it
  /// misses or enters beyond `t_max`.
  [[nodiscard]] double entry(const glm::dvec3& origin, const glm::dvec3& direction, double t_max) const {
    const glm::dvec3 one = (lower - origin) / direction, other = (upper - origin) / direction;
    const glm::dvec3 near = glm::min(one, other), far = glm::max(one, other);
    const double enter = std::max({near.x, near.y, near.z, 0.0});
    return enter <= std::min({far.x, far.y, far.z, t_max}) ? enter : std::numeric_limits<double>::infinity();
  }
};

Bounds bounds_of(const TriangleCorners<float>& triangle) {
  Bounds bounds;
  for (const auto& corner : triangle) bounds = bounds.joined({glm::dvec3(corner), glm::dvec3(corner)});
  return bounds;
}

/// A tree as the measures below see it, whoever built it: nodes of up to eight children, packets of
/// up to eight triangles.
struct Tree {
  struct Child {
    Bounds bounds;
    bool is_packet;
    std::size_t index;
  };
  std::vector<std::vector<Child>> nodes;
  std::vector<std::vector<std::uint32_t>> packets;
  Child root{};
};

/// The tree that the library built.
class Library {
 public:
  explicit Library(const Triangles& triangles) : built_(BvhBuilder<float>(triangles, {}).build()) {
    for (std::size_t packet = 0; packet < built_.bvh.triangles.size(); ++packet) {
      tree_.packets.emplace_back();
      for (std::size_t lane = 0; lane < lane_count; ++lane) {
        const std::uint32_t triangle = built_.triangle_in_slot[packet * lane_count + lane];
        if (triangle != BuiltBvh<float>::empty_slot) tree_.packets.back().push_back(triangle);
      }
    }
    for (const BvhNode<float>& node : built_.bvh.nodes) {
      tree_.nodes.emplace_back();
      for (std::size_t lane = 0; lane < lane_count; ++lane) {
        if (node.children[lane].kind() == BvhChild::nothing) continue;
        Bounds bounds;
        for (std::size_t axis = 0; axis < 3; ++axis) {
          bounds.lower[static_cast<int>(axis)] = static_cast<double>(node.plane(2 * axis, lane));
          bounds.upper[static_cast<int>(axis)] = static_cast<double>(node.plane(2 * axis + 1, lane));
        }
        tree_.nodes.back().push_back(
            {bounds, node.children[lane].kind() != BvhChild::node, node.children[lane].index()});
      }
    }
    Bounds all;
    for (const auto& triangle : triangles) all = all.joined(bounds_of(triangle));
    tree_.root = {all, built_.bvh.root.kind() != BvhChild::node, built_.bvh.root.index()};
  }
  [[nodiscard]] const Tree& tree() const { return tree_; }

 private:
  BuiltBvh<float> built_;
  Tree tree_;
};

/// The same model of cost as the library's: a packet costs 1, however full it is, a cut 0.3 of one.
class FullSweep {
 public:
  explicit FullSweep(const Triangles& triangles) {
    for (const auto& triangle : triangles) bounds_.push_back(bounds_of(triangle));
    std::vector<std::uint32_t> all(triangles.size());
    std::iota(all.begin(), all.end(), 0U);
    tree_.root = emit(cut(std::move(all)));
  }
  [[nodiscard]] const Tree& tree() const { return tree_; }

 private:
  struct Binary {
    Bounds bounds;
    std::vector<std::uint32_t> triangles;  ///< of a leaf
    std::size_t left = 0, right = 0;       ///< 0 in a leaf
  };

  static double packets_for(std::size_t count) { return std::ceil(static_cast<double>(count) / 8); }

  std::size_t cut(std::vector<std::uint32_t> triangles) {
    const std::size_t number = binary_.size(), count = triangles.size();
    binary_.emplace_back();
    for (const auto i : triangles) binary_[number].bounds = binary_[number].bounds.joined(bounds_[i]);
    double best = std::numeric_limits<double>::infinity();
    std::size_t best_place = 0;
    std::vector<std::uint32_t> best_order;
    for (int axis = 0; axis < 3; ++axis) {
      std::sort(triangles.begin(), triangles.end(), [&](std::uint32_t a, std::uint32_t b) {
        const double at_a = bounds_[a].lower[axis] + bounds_[a].upper[axis];
        const double at_b = bounds_[b].lower[axis] + bounds_[b].upper[axis];
        return at_a != at_b ? at_a < at_b : a < b;
      });
      std::vector<double> above(count);
      Bounds bounds;
      for (std::size_t i = count; i-- > 1;) {
        bounds = bounds.joined(bounds_[triangles[i]]);
        above[i] = bounds.half_area() * packets_for(count - i);
      }
      bounds = {};
      bool is_better = false;
      for (std::size_t i = 1; i < count; ++i) {
        bounds = bounds.joined(bounds_[triangles[i - 1]]);
        const double cost = bounds.half_area() * packets_for(i) + above[i];
        if (cost < best) {
          best = cost;
          best_place = i;
          is_better = true;
        }
      }
      if (is_better) best_order = triangles;
    }
    if (count <= 8 && !(best < 0.7 * binary_[number].bounds.half_area())) {
      binary_[number].triangles = std::move(triangles);
      return number;
    }
    const auto middle = best_order.begin() + static_cast<std::ptrdiff_t>(best_place);
    const std::size_t left = cut({best_order.begin(), middle}), right = cut({middle, best_order.end()});
    binary_[number].left = left;
    binary_[number].right = right;
    return number;
  }

  Tree::Child emit(std::size_t number) {
    if (binary_[number].left == 0) {
      tree_.packets.push_back(binary_[number].triangles);
      return {binary_[number].bounds, true, tree_.packets.size() - 1};
    }
    // Until there are eight, the two children of the largest inner one take its place.
    std::vector<std::size_t> members{binary_[number].left, binary_[number].right};
    while (members.size() < 8) {
      auto largest = members.end();
      for (auto at = members.begin(); at != members.end(); ++at)
        if (binary_[*at].left != 0 &&
            (largest == members.end() || binary_[*at].bounds.half_area() > binary_[*largest].bounds.half_area()))
          largest = at;
      if (largest == members.end()) break;
      const std::size_t opened = *largest;
      *largest = binary_[opened].left;
      members.push_back(binary_[opened].right);
    }
    const std::size_t node = tree_.nodes.size();
    tree_.nodes.emplace_back();
    for (const std::size_t member : members) {
      const Tree::Child child = emit(member);
      tree_.nodes[node].push_back(child);
    }
    return {binary_[number].bounds, false, node};
  }

  std::vector<Bounds> bounds_;
  std::vector<Binary> binary_;
  Tree tree_;
};

struct Visits {
  double nodes = 0, packets = 0;
  [[nodiscard]] double total() const { return nodes + packets; }
};

/// How many nodes and packets a random line through the root meets on average: ratios of surface
/// areas.
Visits expected_visits(const Tree& tree) {
  const double whole = tree.root.bounds.half_area();
  Visits visits{tree.root.is_packet ? 0.0 : 1.0, tree.root.is_packet ? 1.0 : 0.0};
  for (const auto& node : tree.nodes)
    for (const Tree::Child& child : node)
      (child.is_packet ? visits.packets : visits.nodes) += child.bounds.half_area() / whole;
  return visits;
}

struct Line {
  glm::dvec3 origin, direction;
};

/// The distance to the triangle; infinity where the ray misses it.
double distance(const TriangleCorners<float>& triangle, const Line& ray) {
  const glm::dvec3 a(triangle[0]), ab = glm::dvec3(triangle[1]) - a, ac = glm::dvec3(triangle[2]) - a;
  const glm::dvec3 p = glm::cross(ray.direction, ac), s = ray.origin - a, q = glm::cross(s, ab);
  const double determinant = glm::dot(ab, p);
  const double u = glm::dot(s, p) / determinant, v = glm::dot(ray.direction, q) / determinant;
  const double t = glm::dot(ac, q) / determinant;
  return u >= 0 && v >= 0 && u + v <= 1 && t > 0 ? t : std::numeric_limits<double>::infinity();
}

/// The nodes and packets that the search for the nearest hit visits, nearer children first.
Visits closest_hit_visits(const Tree& tree, const Triangles& triangles, const Line& ray, double& nearest) {
  struct Waiting {
    double entry;
    const Tree::Child* child;
  };
  Visits visits;
  nearest = std::numeric_limits<double>::infinity();
  std::vector<Waiting> stack{{0, &tree.root}};
  while (!stack.empty()) {
    const Waiting current = stack.back();
    stack.pop_back();
    if (current.entry > nearest) continue;
    if (current.child->is_packet) {
      ++visits.packets;
      for (const auto i : tree.packets[current.child->index]) nearest = std::min(nearest, distance(triangles[i], ray));
      continue;
    }
    ++visits.nodes;
    const std::size_t base = stack.size();
    for (const Tree::Child& child : tree.nodes[current.child->index]) {
      const double entry = child.bounds.entry(ray.origin, ray.direction, nearest);
      if (std::isfinite(entry)) stack.push_back({entry, &child});
    }
    std::sort(stack.begin() + static_cast<std::ptrdiff_t>(base), stack.end(),
              [](const Waiting& a, const Waiting& b) { return a.entry > b.entry; });
  }
  return visits;
}

// --- Inputs --------------------------------------------------------------------------------------

void add(Triangles& triangles, const Mesh& mesh) {
  for (const auto& t : mesh.triangles) {
    const auto corner = [&](std::size_t k) { return Vec3<float>(mesh.positions[static_cast<std::size_t>(t[k])]); };
    triangles.push_back({corner(0), corner(1), corner(2)});
  }
}

Triangles clutter(Philox& source) {
  Triangles triangles;
  for (int i = 0; i < 60; ++i)
    add(triangles, bumpy_ball(random_in_cube(source) * 5.0, random_magnitude(source, -1.5, 0), 9, source));
  return triangles;
}

/// Small and large, mostly long and thin.
Triangles soup(Philox& source) {
  Triangles triangles;
  for (int i = 0; i < 6000; ++i) {
    const glm::dvec3 center = random_in_cube(source) * 5.0, along = random_in_cube(source);
    const double size = random_magnitude(source, -2, 0);
    triangles.push_back({Vec3<float>(center - along * size), Vec3<float>(center + along * size),
                         Vec3<float>(center + random_in_cube(source) * (0.1 * size))});
  }
  return triangles;
}

/// `columns`² squares of two triangles; corner (i, j) is at `at(i, j)`.
template <class At>
Mesh grid(int columns, At&& at) {
  Mesh mesh;
  for (int i = 0; i <= columns; ++i)
    for (int j = 0; j <= columns; ++j) mesh.positions.push_back(at(i, j));
  for (int i = 0; i < columns; ++i)
    for (int j = 0; j < columns; ++j) {
      const int a = i * (columns + 1) + j, b = a + 1, c = a + columns + 1, d = c + 1;
      mesh.triangles.push_back({a, b, d});
      mesh.triangles.push_back({a, d, c});
    }
  return mesh;
}

Triangles terrain(Philox& source) {
  const glm::dvec3 phase = random_in_cube(source) * pi<double>;
  Triangles triangles;
  add(triangles, grid(64, [&](int i, int j) {
        const double x = i / 8.0, y = j / 8.0;
        const double height =
            std::sin(x + phase.x) * std::cos(y + phase.y) + 0.3 * std::sin(3.1 * x - 2.3 * y + phase.z);
        return glm::dvec3(x, height + 0.05 * uniform<double>(source), y);
      }));
  return triangles;
}

/// Five tessellated walls, a lamp and two boxes that are turned about the vertical.
Triangles room(Philox& source) {
  Triangles triangles;
  for (int wall = 0; wall < 5; ++wall)
    add(triangles, grid(8, [&](int i, int j) {
          glm::dvec3 at(0);
          at[(wall / 2 + 1) % 3] = i / 4.0 - 1;
          at[(wall / 2 + 2) % 3] = j / 4.0 - 1;
          at[wall / 2] = wall % 2 == 0 ? 1 : -1;
          return at;
        }));
  add(triangles, grid(1, [](int i, int j) { return glm::dvec3(i * 0.5 - 0.25, 0.99, j * 0.5 - 0.25); }));
  for (int k = 0; k < 2; ++k) {
    Mesh block = box({-0.3, 0, -0.3}, {0.3, k == 0 ? 0.6 : 1.2, 0.3});
    const double angle = pi<double> * uniform<double>(source);
    for (glm::dvec3& p : block.positions)
      p = {(k == 0 ? 0.35 : -0.35) + p.x * std::cos(angle) - p.z * std::sin(angle), p.y - 1,
           (k == 0 ? 0.3 : -0.3) + p.x * std::sin(angle) + p.z * std::cos(angle)};
    add(triangles, block);
  }
  return triangles;
}

// Cutting a cube of evenly spread triangles at x costs (1 + 2x) x + (3 − 2x)(1 − x) = 4x² − 4x + 3,
// least at the middle. The nearest border of 16 bins is at most 1/32 away: 4/32² over 2, which is
// 0.2 % a level, 3 % over the 15 levels of the largest input. Neither of two greedy builds is bound
// to be the better one, and among clusters the borders of bins may miss a gap: of ten seeds the
// ratios lie between 0.95 and 1.04. One in ten is what may be lost to that. Adding empty bins to
// boxes, a mistake that was made once, gives ratios from 1.5 to 12.
constexpr double limit = 1.1;

TEST_CASE("the tree is about as good as a full sweep's", "[bvh]") {
  struct Input {
    const char* name;
    Triangles (*make)(Philox&);
  };
  for (const Input& input :
       {Input{"clutter of balls", clutter}, Input{"thin soup", soup}, Input{"terrain", terrain}, Input{"room", room}}) {
    Philox source(gmis_test::seed(28));
    const Triangles triangles = input.make(source);
    const Library library(triangles);
    const FullSweep full_sweep(triangles);
    const Visits area = expected_visits(library.tree()), area_of_sweep = expected_visits(full_sweep.tree());

    Visits rays, rays_of_sweep;
    int differences = 0;
    const Bounds all = library.tree().root.bounds;
    for (int i = 0; i < 4000; ++i) {
      const glm::dvec3 in_box = (random_in_cube(source) + 1.0) * 0.5;
      const Line ray{all.lower + in_box * (all.upper - all.lower), glm::dvec3(random_direction<double>(source))};
      double t = 0, t_of_sweep = 0;
      const Visits one = closest_hit_visits(library.tree(), triangles, ray, t);
      const Visits other = closest_hit_visits(full_sweep.tree(), triangles, ray, t_of_sweep);
      differences += t == t_of_sweep ? 0 : 1;
      rays = {rays.nodes + one.nodes / 4000, rays.packets + one.packets / 4000};
      rays_of_sweep = {rays_of_sweep.nodes + other.nodes / 4000, rays_of_sweep.packets + other.packets / 4000};
    }
    std::printf(
        "%-17s %6zu triangles; line: %.3f nodes, %.3f packets (sweep %.3f, %.3f: %.3f); "
        "ray: %.3f, %.3f (sweep %.3f, %.3f: %.3f)\n",
        input.name, triangles.size(), area.nodes, area.packets, area_of_sweep.nodes, area_of_sweep.packets,
        area.total() / area_of_sweep.total(), rays.nodes, rays.packets, rays_of_sweep.nodes, rays_of_sweep.packets,
        rays.total() / rays_of_sweep.total());
    INFO(input.name);
    CHECK(differences == 0);
    CHECK(area.total() <= limit * area_of_sweep.total());
    CHECK(rays.total() <= limit * rays_of_sweep.total());
  }
}

}  // namespace
