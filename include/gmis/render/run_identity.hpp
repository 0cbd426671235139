#pragma once

#include <algorithm>
#include <charconv>
#include <cstddef>
#include <cstdint>
#include <initializer_list>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "gmis/render/render_request.hpp"

namespace gmis {

/// What a checkpoint must have in common with the run that goes on from it: each property with its value in words. What
/// changes no sample is left out: limits, threads, callbacks, the reference.
struct RunIdentity {
  struct Property {
    std::string name, value;

    template <class Archive>
    void exchange_state(Archive& archive) {
      archive(name, value);
    }
  };
  std::vector<Property> properties;

  void add(std::string_view name, std::string value) { properties.push_back({std::string(name), std::move(value)}); }
  void add(std::string_view name, double value) {
    char text[32];
    const auto end = std::to_chars(text, text + sizeof text, value).ptr;
    add(name, std::string(text, end));
  }

  /// Whole numbers, with commas between.
  void add(std::string_view name, std::initializer_list<int> values) {
    std::string text;
    for (const int value : values) text.append(text.empty() ? "" : ",").append(std::to_string(value));
    add(name, std::move(text));
  }

  /// The first property that differs, in words; empty when none does.
  [[nodiscard]] std::string difference_to(const RunIdentity& other) const {
    for (std::size_t i = 0; i < std::max(properties.size(), other.properties.size()); ++i) {
      if (i >= properties.size() || i >= other.properties.size() || properties[i].name != other.properties[i].name)
        return "its format differs";
      if (properties[i].value != other.properties[i].value)
        return std::string(properties[i].name)
            .append(" differs: ")
            .append(properties[i].value)
            .append(", not ")
            .append(other.properties[i].value);
    }
    return {};
  }

  template <class Archive>
  void exchange_state(Archive& archive) {
    archive(properties);
  }
};

/// The identity of a run with this request. `resolution`: of the camera; `scalar_bytes`: of the scalar.
[[nodiscard]] inline RunIdentity identity_of(const RenderRequest& request, glm::ivec2 resolution, int channels,
                                             std::size_t scalar_bytes) {
  RunIdentity identity;
  const RenderSettings& settings = request.settings;
  const auto append_counts = [](std::string& text, const SampleCounts& counts) {
    RunIdentity one;
    one.add("", counts.light_paths);
    text.append(one.properties[0].value);
    for (const int count : {counts.connections, int{counts.splats}, int{counts.merges}, counts.camera_children,
                            int{counts.next_events}, int{counts.emitter_hits}})
      text.append(",").append(std::to_string(count));
    text.append(";");
  };
  identity.add("the scene", request.scene_name);
  identity.add("the size of the picture", {resolution.x, resolution.y});
  identity.add("the number of channels", {channels});
  identity.add("the precision", static_cast<double>(scalar_bytes));
  const PixelBounds crop = request.crop.value_or(PixelBounds{{0, 0}, resolution});
  identity.add("the crop", {crop.lower.x, crop.lower.y, crop.upper.x, crop.upper.y});
  identity.add("the seed", std::to_string(settings.seed));
  identity.add("the greatest depth", {settings.max_depth});
  identity.add("the merging radius", settings.radius ? *settings.radius : 0.0);
  identity.add("alpha", settings.alpha);
  identity.add("the splitting of light trees", {static_cast<int>(settings.light_split)});
  identity.add("the scheme", {static_cast<int>(settings.scheme)});
  identity.add("the number of rounds", {settings.rounds});
  identity.add("the budget of light trees", {settings.light_tree_budget});
  std::string classes = "all, unclassified";
  if (settings.path_classes) {
    classes.clear();
    settings.path_classes->for_each([&](PathClass path_class) { classes.append(name_of(path_class)).append(" "); });
  }
  identity.add("the set of path classes", classes);
  std::string counts, candidates;
  append_counts(counts, settings.counts);
  identity.add("the number of samples of the techniques", counts);
  for (const SampleCounts& one : request.candidates) append_counts(candidates, one);
  identity.add("the set of candidates", candidates);
  identity.add("what is kept", {int{request.intervals || request.budget.relative_error}, int{request.halves},
                                int{request.techniques}, int{request.class_pictures}});
  return identity;
}

}  // namespace gmis
