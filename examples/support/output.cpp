#include "support/output.hpp"

#include <algorithm>
#include <string>

#include "support/plan_text.hpp"
#include "support/technique_sheet.hpp"

namespace gmis::tools {

std::filesystem::path file_beside(const std::filesystem::path& output, const char* suffix) {
  auto file = output;
  return file.replace_filename(output.stem().string() + suffix + output.extension().string());
}

void write_output(const RenderResult& result, const std::filesystem::path& output, bool halves,
                  const ImageExtras& extras) {
  write_image(result.image, output, extras);
  if (!halves) return;
  ImageExtras of_halves = extras;
  of_halves.layers.clear();
  write_image(result.half_a, file_beside(output, "_a"), of_halves);
  write_image(result.half_b, file_beside(output, "_b"), of_halves);
}

std::filesystem::path class_folder(const std::filesystem::path& output) {
  return output.parent_path() / (output.stem().string() + "_classes");
}

namespace {

/// Endings of the images in folders: of one in float, and of a sheet of them.
std::string float_ending() {
  return has_exr() ? ".exr" : ".pfm";
}
std::string sheet_ending() {
  return has_png() ? ".png" : ".pfm";
}

std::filesystem::path file_of_class(const std::filesystem::path& folder, PathClass path_class) {
  return folder / (std::string(gmis::name_of(path_class)) + float_ending());
}
std::filesystem::path sheet_of_classes(const std::filesystem::path& folder) {
  return folder / ("sheet" + sheet_ending());
}

}  // namespace

std::vector<std::filesystem::path> files_of_classes(const std::filesystem::path& folder) {
  std::vector<std::filesystem::path> files{sheet_of_classes(folder)};
  PathClassSet::all().for_each([&](PathClass path_class) { files.push_back(file_of_class(folder, path_class)); });
  return files;
}

bool may_be_of_technique(const std::filesystem::path& name) {
  const std::string stem = name.stem().string(), ending = name.extension().string();
  if (ending == sheet_ending() && (stem == "pyramid" || stem == "pyramid_unweighted")) return true;
  return ending == float_ending() &&
         std::any_of(all_techniques.begin(), all_techniques.end(),
                     [&](Technique technique) { return stem.starts_with(std::string(name_of(technique)) + "_s"); });
}

void write_classes(const RenderResult& result, const std::filesystem::path& folder) {
  // Images that an earlier run left there would be taken for a part of this picture.
  std::error_code ignored;
  PathClassSet::all().for_each(
      [&](PathClass path_class) { std::filesystem::remove(file_of_class(folder, path_class), ignored); });
  for (const ClassImage& one : result.classes.classes) write_image(one.image, file_of_class(folder, one.path_class));
  write_image(class_sheet(result.classes.classes), sheet_of_classes(folder));
}

namespace {

std::string file_name_of(const TechniqueId& id) {
  return std::string(name_of(id.technique)) + "_s" + std::to_string(id.s) + "_t" + std::to_string(id.t);
}

}  // namespace

std::vector<ImageLayer> layers_of(const RenderResult& result, const Options& options) {
  std::vector<ImageLayer> layers;
  if (options.layers && !result.variance.rgb.empty()) layers.push_back({"variance", "RGB", result.variance});
  if (options.layers)
    for (const ClassImage& one : result.classes.classes)
      layers.push_back({std::string(gmis::name_of(one.path_class)), "RGB", one.image});
  if (options.technique_layers)
    for (const TechniqueImage& one : result.techniques) layers.push_back({file_name_of(one.id), "RGB", one.weighted});
  for (const LightImage& one : result.by_light) layers.push_back({name_of_light(one.group), "RGB", one.image});
  return layers;
}

void write_techniques(const RenderResult& result, const std::filesystem::path& folder) {
  const std::string ending = float_ending();
  for (const TechniqueImage& technique : result.techniques) {
    const std::string name = file_name_of(technique.id);
    write_image(technique.weighted, folder / (name + ending));
    write_image(technique.unweighted, folder / (name + "_unweighted" + ending));
  }
  write_image(technique_sheet(result.techniques, true), folder / ("pyramid" + sheet_ending()));
  write_image(technique_sheet(result.techniques, false), folder / ("pyramid_unweighted" + sheet_ending()));
}

}  // namespace gmis::tools
