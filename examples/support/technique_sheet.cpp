#include "support/technique_sheet.hpp"

#include <algorithm>
#include <array>
#include <string>
#include <string_view>

namespace gmis::tools {
namespace {

// Three by five dots each, by rows, the highest bit first.
constexpr std::string_view glyph_names = "0123456789stmLSDGE+";
constexpr std::array<unsigned, 19> glyphs{
    0b111'101'101'101'111, 0b010'110'010'010'111, 0b111'001'111'100'111, 0b111'001'111'001'111, 0b101'101'111'001'001,
    0b111'100'111'001'111, 0b111'100'111'101'111, 0b111'001'010'010'010, 0b111'101'111'101'111, 0b111'101'111'001'111,
    0b011'100'010'001'110, 0b010'111'010'010'011, 0b000'111'111'101'101, 0b100'100'100'100'111, 0b111'100'111'001'111,
    0b110'101'101'101'110, 0b111'100'101'101'111, 0b111'100'110'100'111, 0b000'010'111'010'000};
constexpr int dot = 2;                 ///< pixels a dot of a glyph
constexpr int glyph_width = 4 * dot;   ///< with the gap to the next one
constexpr int label_height = 7 * dot;  ///< with gaps above and below
constexpr int gap = 4;                 ///< between images

void write_text(Image& sheet, int left, int top, const std::string& text) {
  for (const char letter : text) {
    if (const std::size_t place = glyph_names.find(letter); place != std::string_view::npos)
      for (int y = 0; y < 5 * dot; ++y)
        for (int x = 0; x < 3 * dot; ++x)
          if ((glyphs[place] >> (14 - (y / dot * 3 + x / dot)) & 1U) != 0 && left + x < sheet.width)
            for (std::size_t c = 0; c < 3; ++c) sheet.rgb[sheet.index(left + x, top + y) + c] = 0.6F;
    left += glyph_width;
  }
}

/// A whole factor by which images become about a hundred pixels wide: above 1 repeats pixels, below
/// averages them.
struct Zoom {
  int repeat = 1, average = 1;

  explicit Zoom(int width) {
    constexpr int fewest = 64, most = 128;
    while (width * repeat < fewest) ++repeat;
    while (width / average > most) ++average;
  }
  [[nodiscard]] int of(int length) const { return std::max(1, length * repeat / average); }
};

void place(Image& sheet, int left, int top, const Image& image, const Zoom& zoom) {
  for (int y = 0; y < zoom.of(image.height); ++y)
    for (int x = 0; x < zoom.of(image.width); ++x)
      for (std::size_t c = 0; c < 3; ++c) {
        float sum = 0, count = 0;
        for (int j = 0; j < zoom.average; ++j)
          for (int i = 0; i < zoom.average; ++i) {
            const int from_x = x / zoom.repeat * zoom.average + i, from_y = y / zoom.repeat * zoom.average + j;
            if (from_x >= image.width || from_y >= image.height) continue;
            sum += image.rgb[image.index(from_x, from_y) + c];
            count += 1;
          }
        sheet.rgb[sheet.index(left + x, top + y) + c] = sum / count;
      }
}

}  // namespace

Image class_sheet(const std::vector<ClassImage>& classes) {
  if (classes.empty()) return Image(1, 1);
  constexpr int most_columns = 5;
  const int count = static_cast<int>(classes.size()), columns = std::min(count, most_columns);
  const Zoom zoom(classes[0].image.width);
  std::size_t longest = 0;
  for (const ClassImage& one : classes) longest = std::max(longest, gmis::name_of(one.path_class).size());
  const int cell_width =
      std::max(zoom.of(classes[0].image.width) + gap, static_cast<int>(longest) * glyph_width + glyph_width);
  const int cell_height = zoom.of(classes[0].image.height) + label_height + gap;
  Image sheet(gap + columns * cell_width, gap + (count + columns - 1) / columns * cell_height);
  std::fill(sheet.rgb.begin(), sheet.rgb.end(), 0.03F);
  for (int i = 0; i < count; ++i) {
    const ClassImage& one = classes[static_cast<std::size_t>(i)];
    const int left = gap + i % columns * cell_width, top = gap + i / columns * cell_height;
    write_text(sheet, left, top + dot, std::string(gmis::name_of(one.path_class)));
    place(sheet, left, top + label_height, one.image, zoom);
  }
  return sheet;
}

int edges_of(const TechniqueId& id) {
  return id.s + id.t - (id.technique == Technique::merge ? 2 : 1);
}

Image technique_sheet(const std::vector<TechniqueImage>& techniques, bool is_weighted) {
  int most_edges = 0, connection_columns = 0, merge_columns = 0;
  for (const TechniqueImage& technique : techniques) {
    most_edges = std::max(most_edges, edges_of(technique.id));
    int& columns = technique.id.technique == Technique::merge ? merge_columns : connection_columns;
    columns = std::max(columns, technique.id.s + 1 - (technique.id.technique == Technique::merge ? 2 : 0));
  }
  if (techniques.empty()) return Image(1, 1);
  const Zoom zoom(techniques[0].weighted.width);
  const int cell_width = zoom.of(techniques[0].weighted.width) + gap;
  const int cell_height = zoom.of(techniques[0].weighted.height) + label_height + gap;
  const int between = connection_columns > 0 && merge_columns > 0 ? 4 * gap : 0;

  Image sheet(gap + (connection_columns + merge_columns) * cell_width + between, gap + most_edges * cell_height);
  std::fill(sheet.rgb.begin(), sheet.rgb.end(), 0.03F);
  for (const TechniqueImage& technique : techniques) {
    const bool is_merge = technique.id.technique == Technique::merge;
    const int column = is_merge ? connection_columns + technique.id.s - 2 : technique.id.s;
    const int left = gap + column * cell_width + (is_merge ? between : 0);
    const int top = gap + (edges_of(technique.id) - 1) * cell_height;
    write_text(sheet, left, top + dot,
               std::string(is_merge ? "m " : "") + "s" + std::to_string(technique.id.s) + "t" +
                   std::to_string(technique.id.t));
    place(sheet, left, top + label_height, is_weighted ? technique.weighted : technique.unweighted, zoom);
  }
  return sheet;
}

}  // namespace gmis::tools
