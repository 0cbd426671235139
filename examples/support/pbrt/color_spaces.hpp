#pragma once

#include <glm/mat3x3.hpp>
#include <glm/vec2.hpp>
#include <optional>
#include <string>

namespace gmis::tools::pbrt {

/// Chromaticities (x, y) of CIE 1931.
struct Primaries {
  glm::dvec2 red, green, blue, white;
};

/// XYZ from linear RGB with these primaries; white has Y = 1.
[[nodiscard]] glm::dmat3 xyz_from_rgb(const Primaries& primaries);
/// Bradford's adaptation of XYZ from one white to another.
[[nodiscard]] glm::dmat3 adaptation(const glm::dvec2& from_white, const glm::dvec2& to_white);
/// Linear sRGB from the linear RGB of a space of pbrt-v4: srgb, dci-p3, rec2020 or aces2065-1.
/// White stays white. Nothing for another name.
[[nodiscard]] std::optional<glm::dmat3> srgb_from(const std::string& space);
/// The effect of `whitebalance` of pbrt's film on linear sRGB: light of this temperature in
/// kelvins, on the CIE's daylight locus (below 4000 K on that of black bodies), becomes white.
[[nodiscard]] glm::dmat3 white_balance(double kelvins);

}  // namespace gmis::tools::pbrt
