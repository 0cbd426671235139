#pragma once

#include <cmath>
#include <glm/geometric.hpp>
#include <glm/vec3.hpp>
#include <optional>
#include <random>

#include "gmis/core/random.hpp"

/// Proposals with densities known in closed form.
namespace test {

inline constexpr double pi = 3.14159265358979323846;

struct Normal {
  double mean, sd;
  double sample(gmis::UniformSource auto& source) const {
    // Box and Muller, with 1 − u in (0, 1].
    const double radius = std::sqrt(-2.0 * std::log(1.0 - gmis::uniform<double>(source)));
    return mean + sd * radius * std::cos(2.0 * pi * gmis::uniform<double>(source));
  }
  double pdf(double x) const {
    const double z = (x - mean) / sd;
    return std::exp(-0.5 * z * z) / (sd * std::sqrt(2.0 * pi));
  }
};

/// Uniform on [low, high).
struct Uniform {
  double low = 0.0, high = 1.0;
  double sample(gmis::UniformSource auto& source) const { return low + (high - low) * gmis::uniform<double>(source); }
  double pdf(double x) const { return x >= low && x < high ? 1.0 / (high - low) : 0.0; }
};

/// Uniform on [0, 1), with `fault` for its density at samples above one half.
struct FaultyDensity {
  double fault;
  double sample(gmis::UniformSource auto& source) const { return gmis::uniform<double>(source); }
  double pdf(double x) const { return x > 0.5 ? fault : 1.0; }
};
/// `FaultyDensity`, by its logarithm.
struct FaultyLogarithm {
  double fault;
  double sample(gmis::UniformSource auto& source) const { return gmis::uniform<double>(source); }
  double log_pdf(double x) const { return x > 0.5 ? fault : 0.0; }
};

/// Density 1 + slope (x − 1/2) on [0, 1), |slope| < 2: positive everywhere.
struct Ramp {
  double slope;
  double sample(gmis::UniformSource auto& source) const {
    const double u = gmis::uniform<double>(source);
    const double b = 1.0 - 0.5 * slope;
    return 2.0 * u / (b + std::sqrt(b * b + 2.0 * slope * u));
  }
  double pdf(double x) const { return x >= 0.0 && x < 1.0 ? 1.0 + slope * (x - 0.5) : 0.0; }
};

/// `share` of a uniform density on [0, 1), the rest uniform on [low, high): a bump that still
/// covers everything.
struct Bump {
  double low, high, share;
  double sample(gmis::UniformSource auto& source) const {
    const bool wide = gmis::uniform<double>(source) < share;
    const double u = gmis::uniform<double>(source);
    return wide ? u : low + (high - low) * u;
  }
  double pdf(double x) const {
    return x >= 0.0 && x < 1.0 ? share + (x >= low && x < high ? (1.0 - share) / (high - low) : 0.0) : 0.0;
  }
};

/// Density (1 + slope z) / 4π on the unit sphere, 0 ≤ slope < 1, in float.
struct TiltedSphere {
  float slope;
  glm::vec3 sample(gmis::UniformSource auto& source) const {
    const float u = gmis::uniform<float>(source);
    // The cumulative distribution of z is (1 + z)/2 + slope (z² − 1)/4.
    const float z = slope == 0.0F ? 2.0F * u - 1.0F
                                  : (std::sqrt((1.0F - slope) * (1.0F - slope) + 4.0F * slope * u) - 1.0F) / slope;
    const float radius = std::sqrt(std::max(0.0F, 1.0F - z * z));
    const float phi = 2.0F * static_cast<float>(pi) * gmis::uniform<float>(source);
    return {radius * std::cos(phi), radius * std::sin(phi), z};
  }
  float pdf(const glm::vec3& direction) const { return (1.0F + slope * direction.z) / (4.0F * static_cast<float>(pi)); }
};

/// Isotropic normal in three dimensions.
struct Normal3 {
  glm::dvec3 mean;
  double sd;
  glm::dvec3 sample(gmis::UniformSource auto& source) const {
    const Normal axis{0.0, sd};
    const double x = axis.sample(source), y = axis.sample(source), z = axis.sample(source);
    return mean + glm::dvec3(x, y, z);
  }
  double log_pdf(const glm::dvec3& x) const {
    const glm::dvec3 d = (x - mean) / sd;
    return -0.5 * glm::dot(d, d) - 3.0 * std::log(sd * std::sqrt(2.0 * pi));
  }
};

}  // namespace test
