#pragma once

#include <array>
#include <cmath>
#include <limits>
#include <memory>
#include <optional>
#include <vector>

/// \file
/// An existing renderer, which knows nothing of gmis. Everything is in double, with vectors of its
/// own.
///
/// - Directions are those in which light travels: `arriving` points *into* the surface, `leaving`
///   away from it.
/// - Materials are virtual and see directions in the frame of the surface, whose third axis is the
///   normal.
/// - The value of a material includes the cosine of `leaving`.
/// - Rows of pixels count from the *lower* left.

namespace theirs {

struct Vector {
  double x = 0, y = 0, z = 0;
};
inline Vector operator+(const Vector& a, const Vector& b) {
  return {a.x + b.x, a.y + b.y, a.z + b.z};
}
inline Vector operator-(const Vector& a, const Vector& b) {
  return {a.x - b.x, a.y - b.y, a.z - b.z};
}
inline Vector operator*(double s, const Vector& a) {
  return {s * a.x, s * a.y, s * a.z};
}
inline double dot(const Vector& a, const Vector& b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}
inline Vector cross(const Vector& a, const Vector& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
inline Vector unit(const Vector& a) {
  return (1 / std::sqrt(dot(a, a))) * a;
}

struct Basis {
  Vector s, t, normal;
  explicit Basis(const Vector& n) : normal(n) {
    s = unit(std::abs(n.x) > 0.5 ? cross(n, Vector{0, 1, 0}) : cross(n, Vector{1, 0, 0}));
    t = cross(n, s);
  }
  [[nodiscard]] Vector to_local(const Vector& w) const { return {dot(w, s), dot(w, t), dot(w, normal)}; }
  [[nodiscard]] Vector to_world(const Vector& w) const { return w.x * s + w.y * t + w.z * normal; }
};

inline constexpr double pi = 3.14159265358979323846;

inline Vector cosine_hemisphere(double u, double v) {
  const double r = std::sqrt(u), turn = 2 * pi * v;
  return {r * std::cos(turn), r * std::sin(turn), std::sqrt(1 - u)};
}

struct Scattered {
  Vector leaving;
  Vector weight;        ///< value / density
  double density;       ///< per steradian, or the probability of this lobe
  double density_back;  ///< of the way back
  bool is_specular;
  double index = 1;  ///< of the side it leaves to, over that of the side it came from
};

/// All directions in the frame of the surface.
class Material {
 public:
  virtual ~Material() = default;
  [[nodiscard]] virtual bool is_specular() const = 0;
  [[nodiscard]] virtual Vector albedo() const = 0;
  [[nodiscard]] virtual Vector value(const Vector& arriving, const Vector& leaving) const = 0;
  [[nodiscard]] virtual double density(const Vector& arriving, const Vector& leaving) const = 0;
  [[nodiscard]] virtual std::optional<Scattered> scatter(const Vector& arriving, double u, double v,
                                                         double w) const = 0;
};

/// Diffuse, on both sides.
class Matt : public Material {
 public:
  explicit Matt(const Vector& colour) : colour_(colour) {}
  [[nodiscard]] bool is_specular() const override { return false; }
  [[nodiscard]] Vector albedo() const override { return colour_; }
  [[nodiscard]] Vector value(const Vector& arriving, const Vector& leaving) const override {
    return arriving.z * leaving.z < 0 ? (std::abs(leaving.z) / pi) * colour_ : Vector{};
  }
  [[nodiscard]] double density(const Vector& arriving, const Vector& leaving) const override {
    return arriving.z * leaving.z < 0 ? std::abs(leaving.z) / pi : 0;
  }
  [[nodiscard]] std::optional<Scattered> scatter(const Vector& arriving, double, double v, double w) const override {
    Vector leaving = cosine_hemisphere(v, w);
    if (arriving.z > 0) leaving.z = -leaving.z;
    return Scattered{leaving, colour_, density(arriving, leaving), std::abs(arriving.z) / pi, false};
  }

 private:
  Vector colour_;
};

/// Smooth glass; the normal points out of it. Weights are those of power: nothing is lost.
class Glass : public Material {
 public:
  explicit Glass(double index) : index_(index) {}
  [[nodiscard]] bool is_specular() const override { return true; }
  [[nodiscard]] Vector albedo() const override { return {1, 1, 1}; }
  [[nodiscard]] Vector value(const Vector&, const Vector&) const override { return {}; }
  [[nodiscard]] double density(const Vector&, const Vector&) const override { return 0; }
  [[nodiscard]] std::optional<Scattered> scatter(const Vector& arriving, double u, double, double) const override {
    const double index = arriving.z < 0 ? index_ : 1 / index_, cosine = std::abs(arriving.z);
    const double squared = 1 - (1 - cosine * cosine) / (index * index);
    const double inside = squared > 0 ? std::sqrt(squared) : 0;
    const double across = (cosine - index * inside) / (cosine + index * inside);
    const double along = (index * cosine - inside) / (index * cosine + inside);
    const double reflected = squared > 0 ? (across * across + along * along) / 2 : 1;
    if (u < reflected) return Scattered{{arriving.x, arriving.y, -arriving.z}, {1, 1, 1}, reflected, reflected, true};
    const Vector leaving{arriving.x / index, arriving.y / index, std::copysign(inside, arriving.z)};
    return Scattered{leaving, {1, 1, 1}, 1 - reflected, 1 - reflected, true, index};
  }

 private:
  double index_;
};

struct Lamp;

struct Shape {
  std::shared_ptr<const Material> material;
  const Lamp* lamp = nullptr;
  // A ball, or a parallelogram: a corner and two sides.
  bool is_ball = false;
  Vector corner, side_a, side_b;
  double radius = 0;

  [[nodiscard]] Vector normal_at(const Vector& point) const {
    return is_ball ? unit(point - corner) : unit(cross(side_a, side_b));
  }
  [[nodiscard]] std::optional<double> meet(const Vector& origin, const Vector& way, double farthest) const {
    const auto within = [&](double t) { return t > 1e-9 && t < farthest; };
    if (is_ball) {
      const Vector out = origin - corner;
      const double b = dot(out, way), d = b * b - dot(out, out) + radius * radius;
      if (d < 0) return {};
      for (const double t : {-b - std::sqrt(d), -b + std::sqrt(d)})
        if (within(t)) return t;
      return {};
    }
    const Vector n = cross(side_a, side_b);
    const double slope = dot(way, n);
    if (slope == 0) return {};
    const double t = dot(corner - origin, n) / slope;
    if (!within(t)) return {};
    const Vector at = origin + t * way - corner;
    const double u = dot(cross(at, side_b), n) / dot(n, n), v = dot(cross(side_a, at), n) / dot(n, n);
    if (u < 0 || u > 1 || v < 0 || v > 1) return {};
    return t;
  }
};

/// A parallelogram that shines on the side of its normal.
struct Lamp {
  Shape shape;
  Vector radiance;
  [[nodiscard]] double area() const {
    const Vector n = cross(shape.side_a, shape.side_b);
    return std::sqrt(dot(n, n));
  }
};

struct Eye {
  Vector position, right, up, forward;     ///< unit
  double half_width = 1, half_height = 1;  ///< of the picture at distance 1
  int columns = 1, rows = 1;
};

struct World {
  std::vector<Shape> shapes;
  std::vector<std::unique_ptr<Lamp>> lamps;
  Eye eye;

  void add_lamp(const Vector& corner, const Vector& a, const Vector& b, const Vector& radiance) {
    lamps.push_back(std::make_unique<Lamp>());
    Lamp& lamp = *lamps.back();
    lamp.shape = {std::make_shared<Matt>(Vector{}), &lamp, false, corner, a, b};
    lamp.radiance = radiance;
    shapes.push_back(lamp.shape);
  }

  struct Meeting {
    const Shape* shape;
    Vector point;
  };
  [[nodiscard]] std::optional<Meeting> first(const Vector& origin, const Vector& way, double farthest) const {
    std::optional<Meeting> nearest;
    for (const Shape& shape : shapes)
      if (const auto t = shape.meet(origin, way, farthest)) {
        farthest = *t;
        nearest = Meeting{&shape, origin + *t * way};
      }
    return nearest;
  }
};

}  // namespace theirs
