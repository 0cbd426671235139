#include "support/plan_text.hpp"

#include <algorithm>
#include <cmath>
#include <iomanip>
#include <sstream>

namespace gmis::tools {

const char* name_of(Technique technique) {
  constexpr const char* names[] = {"emitter_hit", "next_event", "connect", "splat", "merge"};
  return names[static_cast<std::size_t>(technique)];
}

const char* words_of(Technique technique) {
  constexpr const char* words[] = {"emitter hits", "next event", "connections", "splats", "merging"};
  return words[static_cast<std::size_t>(technique)];
}

std::string text_of(const Effects& effects) {
  std::ostringstream text;
  const char* separator = "";
  const auto say = [&](bool holds, const auto& what) {
    if (!holds) return;
    text << separator << what;
    separator = ", ";
  };
  say(effects.diffuse, "diffuse");
  if (effects.glossy) {
    say(true, "glossy (roughness ");
    text << effects.least_roughness;
    if (effects.greatest_roughness > effects.least_roughness) text << " to " << effects.greatest_roughness;
    text << ")";
  }
  say(effects.specular_reflection, "mirrors");
  say(effects.specular_transmission, "glass");
  say(effects.shading_normals, "shading normals");
  if (*separator == '\0') text << "nothing that scatters";
  separator = "; ";
  say(effects.area_lights, "area lights");
  say(effects.point_lights, "point lights");
  say(effects.spot_lights, "spot lights");
  say(effects.directional_lights, "directional lights");
  say(effects.environment_lights, "environment");
  if (!effects.has_lights()) say(true, "no light");
  separator = "; ";
  say(effects.thin_lens, "thin lens");
  return text.str();
}

std::string text_of(PathClassSet classes) {
  std::string text;
  classes.for_each([&](PathClass path_class) {
    if (!text.empty()) text += ' ';
    text += gmis::name_of(path_class);
  });
  return text.empty() ? "none" : text;
}

std::string explain_plan(const RenderRequest& request, const Plan& plan) {
  std::ostringstream text;
  text << "effects     " << text_of(plan.effects) << "\n";
  text << "paths       of at most " << request.settings.max_depth << " segments: " << text_of(plan.occurring) << "\n";
  if (plan.leaves_out_classes()) text << "rendered    of these: " << text_of(plan.classes) << "\n";
  const bool is_planned = request.integrator == IntegratorChoice::automatic;
  const SampleCounts& counts = request.settings.counts;
  for (const TechniquePlan& technique : plan.techniques) {
    const std::string words = words_of(technique.technique);
    const bool is_on = counts.has(technique.technique);
    text << "  " << words << std::string(13 - words.size(), ' ') << (is_on ? "on: " : "off: ");
    if (!is_planned)
      text << (is_on ? "" : "not ") << "in " << name_of(request.integrator) << "; the scene alone would have it "
           << (technique.is_on ? "on: " : "off: ");
    if (technique.rule == PlanRule::needed)
      text << "no other technique makes " << text_of(classes_only_by(technique.technique, plan));
    else
      text << sentence_of(technique.rule);
    text << "\n";
  }
  if (request.integrator != IntegratorChoice::lt && request.integrator != IntegratorChoice::ppm &&
      request.integrator != IntegratorChoice::bpm) {
    const PathClassSet lacking = lacking_classes(plan, counts);
    if (!lacking.is_empty())
      text << "lacks       " << text_of(lacking) << (plan.effects.has_extended_lights() ? ", of some lights" : "")
           << "\n";
  }
  return text.str();
}

std::string text_of(const SampleCounts& counts) {
  std::ostringstream text;
  if (!counts.traces_light()) {
    return "path tracing alone";
  }
  text << counts.light_paths << (counts.light_paths == 1.0 ? " light tree" : " light trees") << " a pixel, ";
  if (counts.connects_paired_tree)
    text << "connections with the paired tree, ";
  else if (counts.connections > 0)
    text << counts.connections << (counts.connections == 1 ? " connection" : " connections") << " a vertex, ";
  else
    text << "no connections, ";
  if (!counts.merges)
    text << "no merging";
  else
    text << "merging" << (counts.local_merges ? " after narrow lobes" : "");
  if (counts.merges && counts.radius_factor != 1.0) text << " within " << counts.radius_factor << " times the radius";
  return text.str();
}

std::string explain_choice(const Choice& choice, const Counters& work) {
  std::ostringstream text;
  text << std::setprecision(3);
  if (!choice.chosen) return "measured    nothing: the pilot saw no pixel; the counts are unchanged\n";
  const Forecast& chosen = choice.forecasts[*choice.chosen];
  const double iterations = choice.expected_iterations;
  text << "measured    in " << choice.pilot_iterations << " iterations of some pixels, "
       << 100.0 * choice.pilot_cost / cost_of(work) << " % of the counted work: " << text_of(chosen.counts) << "\n";
  std::vector<Forecast> others = choice.forecasts;
  std::sort(others.begin(), others.end(),
            [&](const Forecast& a, const Forecast& b) { return a.work(iterations) < b.work(iterations); });
  const auto line = [&](const Forecast& other) {
    text << "expected    " << other.work(iterations) / chosen.work(iterations)
         << " times its work for the same error with " << text_of(other.counts);
    if (other.missing_share > negligible_share)
      text << ", which misses " << 100.0 * other.missing_share << " % of the light";
    text << "\n";
  };
  const auto is_plain = [](const Forecast& f) {
    return (!f.counts.traces_light() || (f.counts.light_paths == 1.0 && f.counts.connections == 1));
  };
  for (const Forecast& other : others)
    if (is_plain(other) && !(other.counts == chosen.counts)) line(other);
  return text.str();
}

std::string explain_lights(const LightUse& use) {
  std::ostringstream text;
  text << std::setprecision(3);
  if (use.receiver_gain)
    text << "lights      for next events chosen " << (use.chooses_for_receiver ? "for the receiver" : "by power")
         << ": choosing for the receiver divides their second moment by " << *use.receiver_gain << "\n";
  if (use.emission_gain)
    text << "emission    " << (use.guides_emission ? "guided" : "by power")
         << ": the learned guide divides the second moment of arriving light by " << *use.emission_gain << "\n";
  return text.str();
}

namespace {

/// Why no light was found, if the plan tells; else empty.
std::string reason_for_nothing(const RenderRequest& request, const Plan& plan) {
  if (plan.occurring.is_empty()) return "; in this scene no path leads from a light to the camera";
  if (plan.classes.is_empty()) return "; --effects keeps no path that this scene has";
  const PathClassSet lacking = lacking_classes(plan, request.settings.counts);
  if (!lacking.is_empty()) return "; these techniques do not make " + text_of(lacking);
  return {};
}

/// The techniques that the scene calls for and this integrator has not; empty where a pilot has
/// chosen.
std::string techniques_left_out(const RenderResult& result, const RenderRequest& request, const Plan& plan) {
  std::string names;
  if (request.integrator == IntegratorChoice::automatic) return names;
  for (const TechniquePlan& technique : plan.techniques) {
    if (!technique.is_on || result.counts.has(technique.technique)) continue;
    names += std::string(names.empty() ? "" : " and ") + words_of(technique.technique);
  }
  return names;
}

/// The technique or the path class that made most of a pixel, where images of techniques or of
/// classes are there to tell; empty otherwise.
std::string maker_of(const RenderResult& result, std::size_t pixel) {
  const auto brightness = [&](const Image& image) {
    return image.rgb[3 * pixel] + image.rgb[3 * pixel + 1] + image.rgb[3 * pixel + 2];
  };
  std::string name;
  float most = 0;
  for (const TechniqueImage& technique : result.techniques)
    if (brightness(technique.weighted) > most) {
      most = brightness(technique.weighted);
      name = std::string(words_of(technique.id.technique)) + " (s = " + std::to_string(technique.id.s) +
             ", t = " + std::to_string(technique.id.t) + ")";
    }
  if (!name.empty()) return name;
  for (const ClassImage& one : result.classes.classes)
    if (brightness(one.image) > most) {
      most = brightness(one.image);
      name = "paths " + std::string(gmis::name_of(one.path_class));
    }
  return name;
}

}  // namespace

std::string caution_of(const RenderResult& result, const RenderRequest& request, const Plan& plan) {
  if (!result.error) return {};
  const ErrorEstimate& error = *result.error;
  if (error.doubt == ErrorDoubt::nothing_found)
    return "caution     nothing has been found yet: no pixel differs between iterations" +
           reason_for_nothing(request, plan) + "\n";
  if (error.doubt != ErrorDoubt::rare_events && error.doubt != ErrorDoubt::few_pixels) return {};
  std::ostringstream text;
  text << std::setprecision(2) << "caution     ";
  if (const double share = error.share_of_worst(); share > ErrorCalibration{}.largest_share_of_worst) {
    const auto width = static_cast<std::size_t>(result.image.width);
    text << 100 * share << " % of the squared error is in the pixels";
    for (const PixelShare& one : error.worst)
      if (one.share > 0) text << ' ' << one.pixel % width << ',' << one.pixel / width;
    if (const std::string maker = maker_of(result, error.worst[0].pixel); !maker.empty())
      text << " (the first mostly by " << maker << ")";
    text << "; ";
  }
  text << "rare, bright samples dominate the error estimate: it has no interval, and --error does not stop the run";
  if (const std::string more = techniques_left_out(result, request, plan); !more.empty())
    text << "; --integrator auto would add " << more << ", which this scene calls for";
  text << "\n";
  return text.str();
}

std::string duration_text(double seconds) {
  if (!std::isfinite(seconds)) return "never";
  struct Unit {
    double seconds;
    const char* name;
  };
  constexpr Unit units[] = {{31557600, "years"}, {86400, "days"}, {3600, "h"}, {60, "min"}, {1, "s"}, {1e-3, "ms"}};
  const Unit* unit = units;
  // "94 s" says more than "1.6 min".
  while (unit->seconds > 1e-3 && seconds < (unit->seconds > 1 ? 1.65 : 1.0) * unit->seconds) ++unit;
  const double value = seconds / unit->seconds;
  std::ostringstream text;
  text << std::fixed << std::setprecision(value < 9.95 ? 1 : 0) << value << ' ' << unit->name;
  return text.str();
}

std::string explain_forecast(const PriceTable& prices) {
  return "price       the pilot's forecast, without rare bright samples and merging's bias\n" +
         text_of(prices, nullptr);
}

std::string noise_and_bias(const RenderSummary& result) {
  if (!result.error || result.error->doubt == ErrorDoubt::nothing_found || !result.merging_bias) return {};
  const double bound = result.merging_bias->bound();
  if (bound == 0.0) return {};  // nothing was merged
  std::ostringstream text;
  text << std::setprecision(2) << "noise " << 100 * result.error->relative_error << " %, bias of merging at most "
       << 100 * bound << " %";
  return text.str();
}

std::string text_of(const std::optional<PriceTable>& prices, const char* last) {
  if (!prices) return {};
  std::ostringstream text;
  const auto whole = [](double value) {
    std::ostringstream number;
    number << std::fixed << std::setprecision(0) << value;
    return number.str();
  };
  const auto line = [&](const auto& error, const auto& iterations, const auto& cpu, const auto& wall,
                        const char* what) {
    text << std::left << std::setw(12) << error << std::right << std::setw(12) << iterations << std::setw(12) << cpu
         << std::setw(12) << wall << "  " << what << '\n';
  };
  line("error", "iterations", "processor", "wall", "");
  for (std::size_t i = 0; i < prices->prices.size(); ++i) {
    const Price& price = prices->prices[i];
    std::ostringstream error;
    if (last == nullptr || i + 1 < prices->prices.size())
      error << 100 * price.error << " %";
    else
      error << last;
    if (!std::isfinite(price.iterations))
      line(error.str(), "-", "-", "-", "not in sight: the error does not fall");
    else
      line(error.str(), whole(price.iterations), duration_text(price.cpu_seconds), duration_text(price.wall_seconds),
           price.is_reached ? "reached" : "predicted");
  }
  return text.str();
}

std::string plan_of(const RenderRequest& request, const SampleCounts& counts) {
  std::string plan;
  for (const Technique technique : all_techniques) {
    if (!counts.has(technique)) continue;
    if (!plan.empty()) plan += ", ";
    plan += words_of(technique);
    if (technique != Technique::connect) continue;
    plan += counts.connects_paired_tree ? " (paired" : " (" + std::to_string(counts.connections);
    plan += " a vertex)";
  }
  if (!counts.extends_camera && counts.has(Technique::merge)) plan += " at the first non-specular vertex";
  if (counts.has(Technique::merge) && counts.local_merges) plan += " (photons that come from narrow lobes)";
  if (request.integrator == IntegratorChoice::gmis && request.split != SplitChoice::local) {
    plan += "; subpaths split: " + std::string(name_of(request.split));
    if (request.sampler) plan += " by " + std::string(gmis::name_of(request.sampler->scheme));
  }
  return plan.empty() ? "nothing" : plan;
}

std::string explain(const Options& options, const RenderRequest& request, const Plan& plan, const BuiltScene& scene,
                    int threads) {
  std::ostringstream text;
  const glm::ivec2 resolution = scene.scene().camera().resolution();
  text << "scene       " << scene.summary() << "\n";
  text << "picture     " << resolution.x << "x" << resolution.y;
  if (request.crop)
    text << ", cropped to " << request.crop->lower.x << "," << request.crop->lower.y << " to " << request.crop->upper.x
         << "," << request.crop->upper.y;
  text << "\nintegrator  " << name_of(request.integrator);
  const SampleCounts& counts = request.settings.counts;
  if (options.lights == scene::LightSelection::by_receiver)
    text << "\nlights      of next events by power, distance and orientation as the receiver sees them";
  if (options.emission == Emission::learned && options.integrator != IntegratorChoice::automatic)
    text << "\nemission    of light subpaths learned: where their light is needed";
  text << "\ntechniques  " << plan_of(request, counts) << "\n" << explain_plan(request, plan);
  if (request.candidates.size() > 1)
    text << "choice      a pilot chooses among " << request.candidates.size()
         << " sets of counts, each with these techniques or fewer\n";
  const bool is_merging = counts.has(Technique::merge);
  if (counts.traces_light()) text << "light       " << counts.light_paths << " trees a pixel\n";
  if (request.integrator == IntegratorChoice::lt)
    text << "lacks       what is seen in mirrors and through glass, except the lights themselves\n";
  if (is_merging)
    text << "radius      "
         << counts.radius_factor * (request.settings.radius ? *request.settings.radius : default_radius(scene.scene()))
         << " = " << text_of(options.radius.value_or(RadiusChoice{counts.radius_factor * 0.4})) << ", times i^"
         << (request.settings.alpha - 1) / 2 << "\n";
  if (request.split == SplitChoice::paper && request.integrator == IntegratorChoice::gmis)
    text << "bias        this split policy drops the unfinished subpaths at the end of its budget: the picture is too "
            "dark\n";
  text << "threads     " << threads << "\nstops       ";
  const char* separator = "";
  const auto stop = [&](const auto& value, const char* unit) {
    text << separator << "after " << value << unit;
    separator = " or ";
  };
  if (request.budget.iterations) stop(*request.budget.iterations, " iterations");
  if (request.budget.seconds) stop(*request.budget.seconds, " seconds");
  if (request.budget.relative_error) text << separator << "at a relative error of " << *request.budget.relative_error;
  text << "\n";
  return text.str();
}

}  // namespace gmis::tools
