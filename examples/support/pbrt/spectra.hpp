#pragma once

#include <filesystem>
#include <optional>
#include <span>
#include <string>

#include "support/scene_description.hpp"

/// \file
/// Spectra as linear sRGB.

namespace gmis::tools::pbrt {

/// The CIE 1931 colour-matching functions at a wavelength in nanometres, by the fit of Wyman, Sloan
/// and Shirley (Simple analytic approximations to the CIE XYZ color matching functions, JCGT 2013).
[[nodiscard]] glm::dvec3 color_matching(double wavelength);

/// A black body of this temperature in kelvins, with luminance 1, `in_gamut`.
[[nodiscard]] Rgb blackbody(double kelvins);

/// The bearer of a spectrum. Light of the spectrum D65 is white, a surface of any constant spectrum
/// is grey.
enum class SpectrumOf { light, surface };

/// A spectrum given by pairs of wavelength (in nanometres, growing) and value, linear between them
/// and 0 beyond them. A light of the constant 1 has luminance 1. Channels outside the gamut are
/// negative.
[[nodiscard]] Rgb rgb_of_spectrum(std::span<const double> pairs, SpectrumOf of = SpectrumOf::surface);

/// The spectrum that is 1 at all wavelengths.
[[nodiscard]] Rgb rgb_of_constant(SpectrumOf of);

/// Channels below 0 cut to 0, the others scaled so that the luminance stays.
[[nodiscard]] Rgb in_gamut(const Rgb& color);

/// pbrt's names of metals ("metal-Cu-eta"), glasses ("glass-BK7") and illuminants ("stdillum-D65");
/// nothing for others.
[[nodiscard]] std::optional<Rgb> named_spectrum(const std::string& name);
/// All these names, separated by commas.
[[nodiscard]] std::string known_spectra();

/// The pairs in a text file, where '#' begins a comment; nothing when it holds anything but numbers
/// or is no regular file.
[[nodiscard]] std::optional<std::vector<double>> read_spectrum(const std::filesystem::path& file);

}  // namespace gmis::tools::pbrt
