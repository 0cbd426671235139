#include "support/pbrt/spectra.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <fstream>
#include <glm/geometric.hpp>
#include <glm/mat3x3.hpp>
#include <sstream>
#include <string>

namespace gmis::tools::pbrt {
namespace {

struct NamedMetal {
  const char* name;
  Rgb eta, k;
};

// The measured spectra behind pbrt-v4's names (src/pbrt/util/spectrum.cpp), each brought to linear
// sRGB by `rgb_of_spectrum`. There CuZn is Querry's (1985), 70 % copper and 30 % zinc, and TiO2 is
// rutile, extraordinary ray, by Devore (1951); both as refractiveindex.info lists them.
constexpr std::array known_metals{
    NamedMetal{"Cu", {0.1697, 0.9709, 1.213}, {3.236, 2.594, 2.355}},
    NamedMetal{"Au", {0.1213, 0.3926, 1.587}, {3.296, 2.522, 1.762}},
    NamedMetal{"Ag", {0.1288, 0.1231, 0.1522}, {3.999, 3.299, 2.361}},
    NamedMetal{"Al", {1.369, 0.9326, 0.5728}, {7.644, 6.620, 5.319}},
    NamedMetal{"CuZn", {0.4325, 0.5140, 1.146}, {3.584, 2.695, 1.750}},
    NamedMetal{"MgO", {1.734, 1.741, 1.754}, {0, 0, 0}},
    NamedMetal{"TiO2", {2.870, 2.954, 3.195}, {0, 0, 0}},
};

struct NamedGlass {
  const char* name;
  double eta;  ///< at 587.56 nm (helium d)
};

// n_d of Schott's catalogue. pbrt's program calls the flints SF5, SF10 and SF11 F5, F10 and F11,
// its documentation does not.
constexpr std::array known_glasses{
    NamedGlass{"glass-BK7", 1.51680},   NamedGlass{"glass-BAF10", 1.67003}, NamedGlass{"glass-FK51A", 1.48656},
    NamedGlass{"glass-LASF9", 1.85025}, NamedGlass{"glass-SF5", 1.67270},   NamedGlass{"glass-F5", 1.67270},
    NamedGlass{"glass-SF10", 1.72825},  NamedGlass{"glass-F10", 1.72825},   NamedGlass{"glass-SF11", 1.78472},
    NamedGlass{"glass-F11", 1.78472},
};

/// Linear RGB of rec. 709 primaries and D65.
Rgb from_xyz(const glm::dvec3& xyz) {
  return {3.2404542 * xyz.x - 1.5371385 * xyz.y - 0.4985314 * xyz.z,
          -0.9692660 * xyz.x + 1.8760108 * xyz.y + 0.0415560 * xyz.z,
          0.0556434 * xyz.x - 0.2040259 * xyz.y + 1.0572252 * xyz.z};
}

constexpr Rgb luminance_weights{0.2126, 0.7152, 0.0722};

constexpr int first_wavelength = 360, last_wavelength = 830;

/// ∫ of a spectrum times the colour-matching functions, by the midpoint rule over nanometres.
template <class Spectrum>
glm::dvec3 xyz_of(const Spectrum& spectrum) {
  glm::dvec3 sum(0);
  for (int nm = first_wavelength; nm < last_wavelength; ++nm) sum += color_matching(nm + 0.5) * spectrum(nm + 0.5);
  return sum;
}

/// Planck's law, per wavelength, in any unit.
double planck(double wavelength, double kelvins) {
  const double metres = wavelength * 1e-9;
  constexpr double second_constant = 0.014387769;  // hc/k
  return 1e-32 / (std::pow(metres, 5) * std::expm1(second_constant / (metres * kelvins)));
}

}  // namespace

glm::dvec3 color_matching(double wavelength) {
  const auto lobe = [&](double middle, double width_below, double width_above) {
    const double t = (wavelength - middle) / (wavelength < middle ? width_below : width_above);
    return std::exp(-t * t / 2);
  };
  return {1.056 * lobe(599.8, 37.9, 31.0) + 0.362 * lobe(442.0, 16.0, 26.7) - 0.065 * lobe(501.1, 20.4, 26.2),
          0.821 * lobe(568.8, 46.9, 40.5) + 0.286 * lobe(530.9, 16.3, 31.1),
          1.217 * lobe(437.0, 11.8, 36.0) + 0.681 * lobe(459.0, 26.0, 13.8)};
}

Rgb blackbody(double kelvins) {
  const glm::dvec3 xyz = xyz_of([&](double nm) { return planck(nm, kelvins); });
  const Rgb rgb = glm::max(from_xyz(xyz / xyz.y), Rgb(0));
  return rgb / glm::dot(rgb, luminance_weights);
}

Rgb in_gamut(const Rgb& color) {
  const Rgb cut = glm::max(color, Rgb(0));
  if (cut == color) return color;
  const double wanted = glm::dot(color, luminance_weights), found = glm::dot(cut, luminance_weights);
  return wanted > 0 ? cut * (wanted / found) : Rgb(0);
}

Rgb rgb_of_constant(SpectrumOf of) {
  if (of == SpectrumOf::surface) return Rgb(1);
  const glm::dvec3 xyz = xyz_of([](double) { return 1.0; });
  return from_xyz(xyz / xyz.y);
}

Rgb rgb_of_spectrum(std::span<const double> pairs, SpectrumOf of) {
  const auto value = [&](double nm) {
    std::size_t i = 0;
    while (i < pairs.size() && pairs[i] <= nm) i += 2;
    if (i == 0 || i >= pairs.size()) return 0.0;
    const double share = (nm - pairs[i - 2]) / (pairs[i] - pairs[i - 2]);
    return pairs[i - 1] * (1 - share) + pairs[i + 1] * share;
  };
  const glm::dvec3 constant = xyz_of([](double) { return 1.0; });
  const Rgb rgb = from_xyz(xyz_of(value) / constant.y);
  return of == SpectrumOf::light ? rgb : rgb / rgb_of_constant(SpectrumOf::light);
}

std::optional<Rgb> named_spectrum(const std::string& name) {
  for (const NamedMetal& metal : known_metals) {
    if (name == std::string("metal-") + metal.name + "-eta") return metal.eta;
    if (name == std::string("metal-") + metal.name + "-k") return metal.k;
  }
  for (const NamedGlass& glass : known_glasses)
    if (name == glass.name) return Rgb(glass.eta);
  if (name == "stdillum-D65") return Rgb(1);
  if (name == "stdillum-A") return blackbody(2855.5);
  return {};
}

std::string known_spectra() {
  std::string list;
  for (const NamedMetal& metal : known_metals) list += std::string("metal-") + metal.name + "-eta and -k, ";
  for (const NamedGlass& glass : known_glasses) list += glass.name + std::string(", ");
  return list + "stdillum-A, stdillum-D65";
}

std::optional<std::vector<double>> read_spectrum(const std::filesystem::path& file) {
  std::error_code error;
  if (!std::filesystem::is_regular_file(file, error)) return {};
  std::ifstream stream(file);
  std::vector<double> numbers;
  constexpr std::size_t most = 100'000;
  for (std::string line; std::getline(stream, line) && numbers.size() < most;) {
    std::istringstream words(line.substr(0, line.find('#')));
    for (double number = 0; words >> number;) numbers.push_back(number);
    if (!words.eof()) return {};
  }
  return numbers;
}

}  // namespace gmis::tools::pbrt
