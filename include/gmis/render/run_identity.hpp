#pragma once

#include <algorithm>
#include <charconv>
#include <cstddef>
#include <cstdint>
#include <initializer_list>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "gmis/core/attributes.hpp"
#include "gmis/core/instruction_set.hpp"
#include "gmis/render/render_request.hpp"

namespace gmis {

namespace detail {

/// Numbers with all their digits, separated.
GMIS_RARE [[nodiscard]] inline std::string text_of(std::initializer_list<double> numbers, char separator) {
  std::string text;
  for (const double number : numbers) {
    char digits[32];
    if (!text.empty()) text.push_back(separator);
    text.append(digits, std::to_chars(digits, digits + sizeof digits, number).ptr);
  }
  return text;
}

/// `SampleCounts` by name, as text.
GMIS_RARE [[nodiscard]] inline std::string text_of(const SampleCounts& counts) {
  const std::pair<const char*, double> numbers[] = {{"light_paths", counts.light_paths},
                                                    {"radius_factor", counts.radius_factor},
                                                    {"connections", counts.connections},
                                                    {"splats", counts.splats},
                                                    {"merges", counts.merges},
                                                    {"extends_camera", counts.extends_camera},
                                                    {"connects_paired_tree", counts.connects_paired_tree},
                                                    {"next_events", counts.next_events},
                                                    {"emitter_hits", counts.emitter_hits},
                                                    {"local_merges", counts.local_merges}};
  std::string text;
  for (const auto& [name, number] : numbers)
    text.append(text.empty() ? "" : ", ").append(name).append(" ").append(text_of({number}, ' '));
  return text;
}

}  // namespace detail

/// The properties that a checkpoint must have in common with the run that goes on from it, each
/// with its value in words. Settings that change no sample are left out: limits, threads,
/// callbacks, the reference.
struct RunIdentity {
  /// A name and its value, as text.
  struct Property {
    std::string name;   ///< what it is called
    std::string value;  ///< as text

    /// Reads or writes the state, by archive.
    template <class Archive>
    void exchange_state(Archive& archive) {
      archive(name, value);
    }
  };
  // Names of properties that not every use of a checkpoint asks for.
  static constexpr std::string_view seed = "the seed";                        ///< of the random numbers
  static constexpr std::string_view instruction_set = "the instruction set";  ///< `gmis::instruction_set`

  static constexpr std::string_view part = "the part of the run";  ///< `RenderRequest::part`

  std::vector<Property> properties;  ///< in the order in which they were added

  /// Adds a property.
  GMIS_RARE void add(std::string_view name, std::string value) {
    properties.push_back({std::string(name), std::move(value)});
  }
  /// Adds a number with all its digits.
  GMIS_RARE void add(std::string_view name, double value) { add(name, detail::text_of({value}, ' ')); }

  /// The value of a property; empty when there is none of this name.
  [[nodiscard]] std::string value_of(std::string_view name) const {
    for (const Property& property : properties)
      if (property.name == name) return property.value;
    return {};
  }

  /// The first property that differs and must not, in words; empty when there is none.
  GMIS_RARE [[nodiscard]] std::string difference_to(const RunIdentity& other,
                                                    std::span<const std::string_view> may_differ = {}) const {
    for (std::size_t i = 0; i < std::max(properties.size(), other.properties.size()); ++i) {
      if (i >= properties.size() || i >= other.properties.size())
        return (i < properties.size() ? properties : other.properties)[i].name + " is in one of the two only";
      if (properties[i].name != other.properties[i].name)
        return properties[i].name + " is in the place of " + other.properties[i].name;
      const bool must_be_equal =
          std::find(may_differ.begin(), may_differ.end(), properties[i].name) == may_differ.end();
      if (must_be_equal && properties[i].value != other.properties[i].value)
        return properties[i].name + " differs: " + properties[i].value + ", not " + other.properties[i].value;
    }
    return {};
  }

  template <class Archive>
  void exchange_state(Archive& archive) {
    archive(properties);
  }
};

/// The identity of a run with this request. `resolution`: of the camera; `scalar_bytes`: of the
/// scalar.
GMIS_RARE [[nodiscard]] inline RunIdentity identity_of(const RenderRequest& request, glm::ivec2 resolution,
                                                       int channels, std::size_t scalar_bytes) {
  RunIdentity identity;
  const RenderSettings& settings = request.settings;
  identity.add("the scene", request.scene_name);
  for (const auto& [name, value] : request.scene_properties) identity.add(name, value);
  identity.add(RunIdentity::instruction_set, std::string(instruction_set));
  const glm::dvec2 size(resolution);
  identity.add("the size of the picture", detail::text_of({size.x, size.y}, 'x'));
  identity.add("the number of channels", channels);
  identity.add("the precision", static_cast<double>(scalar_bytes));
  const PixelBounds crop = request.crop.value_or(PixelBounds{{0, 0}, resolution});
  const glm::dvec2 lower(crop.lower), upper(crop.upper);
  identity.add("the crop", detail::text_of({lower.x, lower.y, upper.x, upper.y}, ','));
  identity.add(RunIdentity::seed, std::to_string(settings.seed));
  identity.add("the sampler", static_cast<int>(settings.sampler));
  identity.add("the emission", static_cast<int>(settings.emission));
  identity.add("the greatest depth", settings.max_depth);
  identity.add("the merging radius", settings.radius.value_or(0.0));
  identity.add("alpha", settings.alpha);
  std::string classes = "all, unclassified";
  if (settings.path_classes) {
    classes.clear();
    settings.path_classes->for_each([&](PathClass path_class) { classes.append(name_of(path_class)).push_back(' '); });
  }
  identity.add("the set of path classes", std::move(classes));
  identity.add("the number of samples of the techniques", detail::text_of(settings.counts));
  std::string candidates;
  for (const SampleCounts& one : request.candidates) candidates.append(detail::text_of(one)).push_back(';');
  identity.add("the set of candidates", std::move(candidates));
  const std::pair<bool, const char*> parts_kept[] = {{request.intervals || request.budget.relative_error, "errors"},
                                                     {request.halves, "halves"},
                                                     {request.techniques, "images of techniques"},
                                                     {request.class_pictures, "images of path classes"},
                                                     {request.light_pictures, "images of lights"}};
  std::string kept = "picture";
  for (const auto& [is_kept, name] : parts_kept)
    if (is_kept) kept.append(" + ").append(name);
  identity.add("what is kept", std::move(kept));
  std::string part = "all of it";
  if (request.part) {
    const glm::dvec3 numbers(request.part->first, request.part->last, request.part->of);
    part = detail::text_of({numbers.x, numbers.y}, '-').append(" of ").append(detail::text_of({numbers.z}, ' '));
  }
  identity.add(RunIdentity::part, std::move(part));
  return identity;
}

}  // namespace gmis
