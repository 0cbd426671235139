#pragma once

#include <algorithm>
#include <charconv>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "gmis/core/attributes.hpp"
#include "gmis/core/instruction_set.hpp"
#include "gmis/render/render_request.hpp"

namespace gmis {

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
  GMIS_RARE void add(std::string_view name, double value) {
    char text[32];
    const auto end = std::to_chars(text, text + sizeof text, value).ptr;
    add(name, std::string(text, end));
  }

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
      if (i >= properties.size()) return other.properties[i].name + " is only in this run";
      if (i >= other.properties.size()) return properties[i].name + " is only in the checkpoint";
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
  const auto counts_text = [](const SampleCounts& counts) {
    RunIdentity parts;
    parts.add("", counts.light_paths);
    parts.add("", counts.radius_factor);
    for (const int count : {counts.connections, int{counts.splats}, int{counts.merges}, int{counts.extends_camera},
                            int{counts.connects_paired_tree}, int{counts.next_events}, int{counts.emitter_hits},
                            int{counts.local_merges}})
      parts.add("", count);
    std::string text;
    for (const RunIdentity::Property& part : parts.properties) text.append(part.value).append(1, ' ');
    return text;
  };
  identity.add("the scene", request.scene_name);
  for (const auto& [name, value] : request.scene_properties) identity.add(name, value);
  identity.add(RunIdentity::instruction_set, std::string(instruction_set));
  identity.add("the size of the picture", std::to_string(resolution.x) + "x" + std::to_string(resolution.y));
  identity.add("the number of channels", channels);
  identity.add("the precision", static_cast<double>(scalar_bytes));
  const PixelBounds crop = request.crop.value_or(PixelBounds{{0, 0}, resolution});
  identity.add("the crop", std::to_string(crop.lower.x) + "," + std::to_string(crop.lower.y) + "," +
                               std::to_string(crop.upper.x) + "," + std::to_string(crop.upper.y));
  identity.add(RunIdentity::seed, std::to_string(settings.seed));
  identity.add("the sampler", static_cast<int>(settings.sampler));
  identity.add("the emission", static_cast<int>(settings.emission));
  identity.add("the greatest depth", settings.max_depth);
  identity.add("the merging radius", settings.radius ? *settings.radius : 0.0);
  identity.add("alpha", settings.alpha);
  std::string classes = "all, unclassified";
  if (settings.path_classes) {
    classes.clear();
    settings.path_classes->for_each([&](PathClass path_class) { classes += std::string(name_of(path_class)) + " "; });
  }
  identity.add("the set of path classes", classes);
  identity.add("the number of samples of the techniques", counts_text(settings.counts));
  std::string candidates;
  for (const SampleCounts& one : request.candidates) candidates += counts_text(one) + ";";
  identity.add("the set of candidates", candidates);
  identity.add("what is kept", std::to_string(request.intervals || request.budget.relative_error) +
                                   std::to_string(request.halves) + std::to_string(request.techniques) +
                                   std::to_string(request.class_pictures) + std::to_string(request.light_pictures));
  identity.add(RunIdentity::part, request.part ? std::to_string(request.part->first) + " to " +
                                                     std::to_string(request.part->last) + " of " +
                                                     std::to_string(request.part->of)
                                               : std::string("all of it"));
  return identity;
}

}  // namespace gmis
