#include "support/pbrt/color_spaces.hpp"

#include <glm/matrix.hpp>
#include <map>

#include "support/pbrt/spectra.hpp"

namespace gmis::tools::pbrt {
namespace {

constexpr glm::dvec2 d65(0.3127, 0.3290);
const Primaries srgb{{0.64, 0.33}, {0.30, 0.60}, {0.15, 0.06}, d65};

glm::dvec3 xyz_of(const glm::dvec2& xy) {
  return {xy.x / xy.y, 1, (1 - xy.x - xy.y) / xy.y};
}

glm::dmat3 diagonal(const glm::dvec3& d) {
  return {{d.x, 0, 0}, {0, d.y, 0}, {0, 0, d.z}};
}

/// Chromaticity on the CIE daylight locus (CIE 15, 3.1), below 4000 K on that of black bodies.
glm::dvec2 white_of(double kelvins) {
  if (kelvins < 4000) {
    const glm::dvec3 xyz = xyz_from_rgb(srgb) * blackbody(kelvins);
    return glm::dvec2(xyz) / (xyz.x + xyz.y + xyz.z);
  }
  const double t = 1e3 / kelvins;
  const double x = kelvins <= 7000 ? ((-4.6070 * t + 2.9678) * t + 0.09911) * t + 0.244063
                                   : ((-2.0064 * t + 1.9018) * t + 0.24748) * t + 0.237040;
  return {x, (-3 * x + 2.870) * x - 0.275};
}

}  // namespace

glm::dmat3 xyz_from_rgb(const Primaries& p) {
  const glm::dmat3 unscaled(xyz_of(p.red), xyz_of(p.green), xyz_of(p.blue));
  return unscaled * diagonal(glm::inverse(unscaled) * xyz_of(p.white));
}

glm::dmat3 adaptation(const glm::dvec2& from_white, const glm::dvec2& to_white) {
  // Bradford's matrix, column by column.
  const glm::dmat3 cones{{0.8951, -0.7502, 0.0389}, {0.2664, 1.7135, -0.0685}, {-0.1614, 0.0367, 1.0296}};
  return glm::inverse(cones) * diagonal((cones * xyz_of(to_white)) / (cones * xyz_of(from_white))) * cones;
}

std::optional<glm::dmat3> srgb_from(const std::string& space) {
  static const std::map<std::string, Primaries> spaces{
      {"srgb", srgb},
      {"dci-p3", {{0.680, 0.320}, {0.265, 0.690}, {0.150, 0.060}, d65}},
      {"rec2020", {{0.708, 0.292}, {0.170, 0.797}, {0.131, 0.046}, d65}},
      {"aces2065-1", {{0.7347, 0.2653}, {0.0, 1.0}, {0.0001, -0.0770}, {0.32168, 0.33767}}}};
  if (space == "srgb") return glm::dmat3(1);
  const auto found = spaces.find(space);
  if (found == spaces.end()) return {};
  return glm::inverse(xyz_from_rgb(srgb)) * adaptation(found->second.white, d65) * xyz_from_rgb(found->second);
}

glm::dmat3 white_balance(double kelvins) {
  const glm::dmat3 xyz = xyz_from_rgb(srgb);
  return glm::inverse(xyz) * adaptation(white_of(kelvins), d65) * xyz;
}

}  // namespace gmis::tools::pbrt
