#include "support/statistics.hpp"

#include <sys/resource.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "support/instruction_set.hpp"
#include "support/plan_text.hpp"
#include "support/replay_text.hpp"

namespace gmis::tools {

using Json = nlohmann::ordered_json;

std::size_t peak_memory_bytes() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
#if defined(__APPLE__)
  constexpr std::size_t unit = 1;
#else
  constexpr std::size_t unit = 1024;
#endif
  return static_cast<std::size_t>(usage.ru_maxrss) * unit;
}

namespace {

Json counts_of(const Counters& c) {
  return {{"camera_paths", c.camera_paths},
          {"light_subpaths", c.light_subpaths},
          {"rays", c.rays},
          {"shadow_rays", c.shadow_rays},
          {"connections", c.connections},
          {"splats", c.splats},
          {"merge_queries", c.merge_queries},
          {"merges", c.merges},
          {"photons_stored", c.photons_stored},
          {"projections", c.projections},
          {"grids_built", c.grids_built},
          {"contributions", c.contributions}};
}

Json rejected_json(const std::vector<RejectedPath>& paths) {
  constexpr const char* causes[] = {"non_finite", "negative", "zero_pdf"};
  Json json = Json::array();
  for (const RejectedPath& rejected : paths)
    json.push_back({{"path", text_of(rejected.path)},
                    {"count", rejected.count},
                    {"cause", causes[static_cast<std::size_t>(rejected.cause)]},
                    {"technique", rejected.technique ? Json(text_of(*rejected.technique)) : Json(nullptr)}});
  return json;
}

Json counts_json(const SampleCounts& counts) {
  return {{"light_paths", counts.light_paths},
          {"connections", counts.connects_paired_tree ? Json("paired") : Json(counts.connections)},
          {"splats", counts.splats},
          {"merges", counts.merges},
          {"local_merges", counts.local_merges},
          {"radius_factor", counts.radius_factor},
          {"extends_camera", counts.extends_camera},
          {"next_events", counts.next_events},
          {"emitter_hits", counts.emitter_hits}};
}

Json classes_json(PathClassSet classes) {
  Json json = Json::array();
  classes.for_each([&](PathClass path_class) { json.push_back(gmis::name_of(path_class)); });
  return json;
}

/// The part of the mean that each class adds, and its cost: processor time by its share of the
/// counted operations.
Json class_images_json(const RenderResult& result) {
  Json json;
  for (const ClassImage& one : result.classes.classes)
    json[std::string(gmis::name_of(one.path_class))] = {{"mean", mean_of(one.image)},
                                                        {"contributions", one.contributions},
                                                        {"cost", one.cost},
                                                        {"cpu_seconds", one.cost * result.cpu_seconds}};
  json["unattributed"] = {{"cost", result.classes.unattributed_cost},
                          {"cpu_seconds", result.classes.unattributed_cost * result.cpu_seconds}};
  return json;
}

Json effects_json(const Effects& effects) {
  Json json{{"diffuse", effects.diffuse},
            {"glossy", effects.glossy},
            {"purely_glossy", effects.purely_glossy},
            {"roughness", nullptr},
            {"specular_reflection", effects.specular_reflection},
            {"specular_transmission", effects.specular_transmission},
            {"shading_normals", effects.shading_normals},
            {"area_lights", effects.area_lights},
            {"point_lights", effects.point_lights},
            {"spot_lights", effects.spot_lights},
            {"directional_lights", effects.directional_lights},
            {"environment_lights", effects.environment_lights},
            {"thin_lens", effects.thin_lens}};
  if (effects.glossy) json["roughness"] = {effects.least_roughness, effects.greatest_roughness};
  return json;
}

/// Each technique as it is in this rendering, and what the scene's plan says of it.
Json techniques_json(const SampleCounts& counts, const RunFacts& facts) {
  Json json;
  for (const TechniquePlan& technique : facts.scene_plan.techniques)
    json[name_of(technique.technique)] = {{"on", counts.has(technique.technique)},
                                          {"called_for", technique.is_on},
                                          {"rule", sentence_of(technique.rule)},
                                          {"makes", classes_json(technique.makes)}};
  return json;
}

Json forecast_json(const Forecast& forecast) {
  Json json = counts_json(forecast.counts);
  json["variance"] = forecast.variance;
  json["squared_bias"] = forecast.squared_bias;
  json["cost"] = forecast.cost;
  json["missing_share"] = forecast.missing_share;
  return json;
}

Json choice_json(const Choice& choice, const Counters& work) {
  Json json;
  json["chosen"] = choice.chosen ? forecast_json(choice.forecasts[*choice.chosen]) : Json(nullptr);
  json["expected_iterations"] = choice.expected_iterations;
  json["pilot_iterations"] = choice.pilot_iterations;
  json["pilot_share"] = choice.pilot_cost / cost_of(work);
  json["forecasts"] = Json::array();
  for (const Forecast& forecast : choice.forecasts) json["forecasts"].push_back(forecast_json(forecast));
  return json;
}

Json gain_json(const std::optional<double>& gain) {
  return gain ? Json(*gain) : Json(nullptr);
}

Json light_use_json(const LightUse& use) {
  return {{"chooses_for_receiver", use.chooses_for_receiver},
          {"receiver_gain", gain_json(use.receiver_gain)},
          {"guides_emission", use.guides_emission},
          {"emission_gain", gain_json(use.emission_gain)}};
}

/// The pixels that make most of the error by their column and row in the image.
Json error_json(const std::optional<ErrorEstimate>& error, int width) {
  const bool is_calibrated = error && error->is_calibrated();
  Json json{{"relative_error", error ? Json(error->relative_error) : Json(nullptr)},
            {"relative_error_trimmed", error ? Json(error->relative_error_trimmed) : Json(nullptr)},
            {"is_calibrated", is_calibrated},
            {"doubt", error ? Json(gmis::name_of(error->doubt)) : Json(nullptr)},
            {"interval", nullptr},
            {"worst_pixels", Json::array()}};
  if (is_calibrated) json["interval"] = {error->interval.lower, error->interval.upper};
  if (error)
    for (const PixelShare& one : error->worst)
      if (one.share > 0) {
        const int pixel = static_cast<int>(one.pixel);
        json["worst_pixels"].push_back({{"x", pixel % width}, {"y", pixel / width}, {"share", one.share}});
      }
  return json;
}

Json number_or_null(double value) {
  return std::isfinite(value) ? Json(value) : Json(nullptr);
}

Json prediction_json(const std::optional<PriceTable>& table, double iterations) {
  if (!table) return nullptr;
  // The squared error of n iterations: (independent · n + merging · Σ i^(1 − alpha)) / n²,
  // times 1 − evenness · (1 − √(8 / n)) from n = 8 on.
  return {{"slope", table->law.slope_at(iterations)},
          {"independent", table->law.independent},
          {"merging", table->law.merging},
          {"alpha", table->law.alpha},
          {"evenness", table->law.evenness},
          {"seconds_to_half_error", number_or_null(table->prices.back().wall_seconds)}};
}

Json prices_json(const std::optional<PriceTable>& table) {
  Json json = Json::array();
  if (!table) return json;
  for (std::size_t i = 0; i < PriceTable::usual_errors.size(); ++i) {  // the price of half the error may follow
    const Price& price = table->prices[i];
    json.push_back({{"error", price.error},
                    {"iterations", number_or_null(price.iterations)},
                    {"cpu_seconds", number_or_null(price.cpu_seconds)},
                    {"wall_seconds", number_or_null(price.wall_seconds)},
                    {"is_reached", price.is_reached}});
  }
  return json;
}

}  // namespace

std::string statistics_json(const RenderResult& result, const RunFacts& facts) {
  const Options& options = *facts.options;
  Json json;
  json["integrator"] = name_of(options.integrator);
  json["plan"] = facts.plan;
  json["effects"] = effects_json(facts.scene_plan.effects);
  json["path_classes"] = {{"occurring", classes_json(facts.scene_plan.occurring)},
                          {"rendered", classes_json(facts.scene_plan.classes)}};
  json["techniques"] = techniques_json(result.counts, facts);
  json["version"] = GMIS_VERSION;
  json["isa"] = instruction_set;
  json["emission"] = facts.options->emission == Emission::learned ? "learned" : "power";
  json["sampler"] = facts.options->sampler == Sampler::sobol ? "sobol" : "independent";
  json["scene"] = options.scene;
  json["width"] = result.image.width;
  json["height"] = result.image.height;
  json["max_depth"] = options.max_depth;
  json["split"] = name_of(options.split);
  json["scheme"] = gmis::name_of(options.scheme);
  json["radius"] = result.radius;
  json["alpha"] = options.alpha;
  json["light_paths"] = result.counts.light_paths;
  json["lights"] = name_of(options.lights);
  json["light_use"] = light_use_json(result.lights);
  json["seed"] = result.joined_seeds.empty() ? Json(options.seed) : Json(result.joined_seeds);
  json["threads"] = facts.threads;
  json["iterations"] = result.iterations;
  json["stopped_by"] = gmis::name_of(result.stopped_by);
  json["image_hash"] = image_hash(result.image);
  json["seconds"] = {{"wall", result.wall_seconds},
                     {"cpu", result.cpu_seconds},
                     {"phase",
                      {{"read", facts.read_seconds},
                       {"build", facts.build_seconds},
                       {"light", result.phases.light},
                       {"grid", result.phases.grid},
                       {"camera", result.phases.camera},
                       {"film", result.phases.film}}}};
  json["sample_counts"] = counts_json(result.counts);
  if (result.choice) json["choice"] = choice_json(*result.choice, result.counters);
  json["counts"] = counts_of(result.counters);
  json["rejected"] = {{"non_finite", result.counters.rejected_non_finite},
                      {"negative", result.counters.rejected_negative},
                      {"zero_pdf", result.counters.rejected_zero_pdf},
                      {"limit", std::isfinite(options.max_rejected) ? Json(options.max_rejected) : Json(nullptr)},
                      {"paths", rejected_json(result.rejected_paths)}};
  if (options.class_images) json["classes"] = class_images_json(result);
  for (const LightImage& one : result.by_light)
    json["by_light"][name_of_light(one.group)] = {{"mean", mean_of(one.image)}};
  json["estimate"] = {{"mean", result.estimate.mean}};
  // One iteration says nothing about its own variance.
  const bool has_variance = result.iterations > 1;
  json["estimate"]["variance"] = has_variance ? Json(result.estimate.variance) : Json(nullptr);
  json["estimate"].update(error_json(result.error, result.image.width));
  const auto& bias = result.merging_bias;
  json["estimate"]["merging_bias"] = bias ? Json(bias->relative_bias) : Json(nullptr);
  json["estimate"]["merging_bias_bound"] = bias ? Json(bias->bound()) : Json(nullptr);
  json["estimate"]["merging_bias_of_mean"] = bias ? Json(bias->of_mean) : Json(nullptr);
  json["estimate"]["merging_bias_of_mean_error"] = bias ? Json(bias->standard_error_of_mean) : Json(nullptr);
  json["estimate"]["merging_bias_made_up"] = bias ? Json(bias->made_up) : Json(nullptr);
  json["prediction"] = prediction_json(result.prices, static_cast<double>(result.iterations));
  json["forecast"] = prices_json(result.forecast);
  json["prices"] = prices_json(result.prices);
  json["memory"] = {{"peak_bytes", peak_memory_bytes()}, {"photon_bytes", result.photon_bytes}};
  if (facts.error)
    json["error"] = {{"relmse", facts.error->relmse},
                     {"relmse_trimmed", facts.error->relmse_trimmed},
                     {"rmse", facts.error->rmse},
                     {"ratio_of_means", facts.ratio_of_means}};
  return json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

}  // namespace gmis::tools
