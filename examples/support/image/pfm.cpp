#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <fstream>

#include "support/diagnostics.hpp"
#include "support/image/formats.hpp"

namespace gmis::tools {
namespace {

std::uint32_t swapped(std::uint32_t word) {
  return (word >> 24U) | ((word >> 8U) & 0xFF00U) | ((word << 8U) & 0xFF0000U) | (word << 24U);
}

constexpr bool native_is_little = std::endian::native == std::endian::little;

}  // namespace

void write_pfm(const Image& image, const std::filesystem::path& file) {
  std::ofstream stream(file, std::ios::binary);
  stream << "PF\n" << image.width << ' ' << image.height << "\n-1.0\n";
  const std::size_t row_size = 3 * static_cast<std::size_t>(image.width);
  std::vector<std::uint32_t> row(row_size);
  for (int y = image.height - 1; y >= 0; --y) {
    std::memcpy(row.data(), image.rgb.data() + image.index(0, y), row_size * sizeof(float));
    if constexpr (!native_is_little) std::transform(row.begin(), row.end(), row.begin(), swapped);
    stream.write(reinterpret_cast<const char*>(row.data()), static_cast<std::streamsize>(row_size * sizeof(float)));
  }
  stream.flush();
  if (!stream)
    throw OutputError(file.string() + ": this file cannot be written: check that the folder exists and has space");
}

Image read_pfm(const std::filesystem::path& file, LoadBudget* budget) {
  std::ifstream stream(file, std::ios::binary);
  if (!stream) throw InputError(file.string() + ": this file cannot be read: check its name");
  std::string kind;
  int width = 0, height = 0;
  double scale = 0;
  stream >> kind >> width >> height >> scale;
  stream.get();
  constexpr int largest = 32768;
  if (!stream || (kind != "PF" && kind != "Pf") || width < 1 || height < 1 || width > largest || height > largest ||
      scale == 0 || !std::isfinite(scale))
    throw InputError(file.string() + ": this is no PFM file");
  const std::size_t channels = kind == "PF" ? 3 : 1;
  std::error_code error;
  const std::uintmax_t size = std::filesystem::file_size(file, error);
  if (!error &&
      size < channels * sizeof(float) * static_cast<std::uintmax_t>(width) * static_cast<std::uintmax_t>(height))
    throw InputError(file.string() + ": this PFM file ends too early");
  count_pixels(budget, file, width, height);
  Image image(width, height);
  const bool must_swap = (scale < 0) != native_is_little;
  const auto factor = static_cast<float>(std::abs(scale));
  const std::size_t row_size = channels * static_cast<std::size_t>(width);
  std::vector<std::uint32_t> row(row_size);
  for (int y = height - 1; y >= 0; --y) {
    stream.read(reinterpret_cast<char*>(row.data()), static_cast<std::streamsize>(row_size * sizeof(float)));
    if (!stream) throw InputError(file.string() + ": this PFM file ends too early");
    if (must_swap) std::transform(row.begin(), row.end(), row.begin(), swapped);
    float* const pixels = image.rgb.data() + image.index(0, y);
    for (std::size_t i = 0; i < 3 * static_cast<std::size_t>(width); ++i)
      pixels[i] = std::bit_cast<float>(row[channels == 3 ? i : i / 3]);
    if (factor != 1)
      std::for_each_n(pixels, 3 * static_cast<std::size_t>(width), [&](float& value) { value *= factor; });
  }
  return image;
}

}  // namespace gmis::tools
