#pragma once

#include <optional>
#include <string>

#include "gmis/render/automatic_request.hpp"
#include "gmis/result/time_to_error.hpp"
#include "support/render.hpp"

/// \file
/// Plans in words.

namespace gmis::tools {

[[nodiscard]] const char* name_of(Technique technique);  ///< one word, as in file names
[[nodiscard]] const char* words_of(Technique technique);

/// "diffuse, glossy (roughness 0.1 to 0.3); area lights; thin lens".
[[nodiscard]] std::string text_of(const Effects& effects);
/// The names of the classes, with spaces between.
[[nodiscard]] std::string text_of(PathClassSet classes);

/// Lines of --explain: effects, classes, and each technique with on or off and why.
[[nodiscard]] std::string explain_plan(const RenderRequest& request, const Plan& plan);

/// One line per fact: what will be done, and why.
[[nodiscard]] std::string explain(const Options& options, const RenderRequest& request, const Plan& plan,
                                  const BuiltScene& scene, int threads);
/// The techniques that run with these counts, in one short line.
[[nodiscard]] std::string plan_of(const RenderRequest& request, const SampleCounts& counts);

/// "0.25 light trees a pixel, 2 connections a vertex, no merging".
[[nodiscard]] std::string text_of(const SampleCounts& counts);
/// Lines of --explain after the run: what a pilot chose, and what the nearest others would have
/// cost.
[[nodiscard]] std::string explain_choice(const Choice& choice, const Counters& work);

/// Lines of --explain after the run: whether lights were chosen for the receiver and emission was
/// guided, with the measured gains; empty where nothing was measured.
[[nodiscard]] std::string explain_lights(const LightUse& use);

/// A line on what may be wrong with the error of a result; empty where nothing is.
[[nodiscard]] std::string caution_of(const RenderResult& result, const RenderRequest& request, const Plan& plan);
/// "18 min", with two digits.
[[nodiscard]] std::string duration_text(double seconds);
/// A line for every price: error, iterations, processor time, wall time, whether reached. `last`:
/// the name of the last error where it is no number.
[[nodiscard]] std::string text_of(const std::optional<PriceTable>& prices, const char* last = "half of this");
/// Lines of --explain after a pilot: what each error is expected to cost.
[[nodiscard]] std::string explain_forecast(const PriceTable& prices);
/// "noise 1.2 %, bias of merging at most 0.4 %"; empty where nothing was merged or no error
/// is known.
[[nodiscard]] std::string noise_and_bias(const RenderSummary& result);

}  // namespace gmis::tools
