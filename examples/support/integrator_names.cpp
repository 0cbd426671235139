#include <charconv>
#include <cmath>
#include <iterator>
#include <optional>
#include <sstream>

#include "support/diagnostics.hpp"
#include "support/options.hpp"

namespace gmis::tools {

namespace {

/// A number above 0 as the text before `end` gives it.
std::optional<double> positive_number_of(const char* begin, const char* end) {
  double value = 0;
  const auto [next, error] = std::from_chars(begin, end, value);
  if (error != std::errc{} || next != end || !(value > 0) || !std::isfinite(value)) return {};
  return value;
}

}  // namespace

IntegratorChoice integrator_of(const std::string& name, const std::string& option) {
  if (name == name_of(IntegratorChoice::automatic)) return IntegratorChoice::automatic;
  for (const IntegratorChoice integrator : all_integrators)
    if (name == name_of(integrator)) return integrator;
  throw InputError(option + " " + in_quotes(name) + " is not known: use auto, pt, lt, bpt, ppm, bpm, vcm or gmis");
}

SplitChoice split_of(const std::string& name, const std::string& option) {
  for (const SplitChoice split : {SplitChoice::none, SplitChoice::paper, SplitChoice::budgeted, SplitChoice::local})
    if (name == name_of(split)) return split;
  throw InputError(option + " " + in_quotes(name) + " is not known: use local, none, paper or budgeted");
}

bool connects(IntegratorChoice integrator) {
  return integrator == IntegratorChoice::bpt || integrator == IntegratorChoice::vcm ||
         integrator == IntegratorChoice::gmis || integrator == IntegratorChoice::automatic;
}

bool merges(IntegratorChoice integrator) {
  return integrator == IntegratorChoice::ppm || integrator == IntegratorChoice::bpm ||
         integrator == IntegratorChoice::vcm || integrator == IntegratorChoice::gmis ||
         integrator == IntegratorChoice::automatic;
}

bool traces_light(IntegratorChoice integrator) {
  return integrator != IntegratorChoice::pt;
}

bool makes_next_events(IntegratorChoice integrator) {
  return connects(integrator) || integrator == IntegratorChoice::pt;
}

scene::LightSelection default_lights(IntegratorChoice integrator) {
  return integrator == IntegratorChoice::automatic ? scene::LightSelection::learned : scene::LightSelection::by_power;
}

Emission default_emission(IntegratorChoice integrator) {
  return integrator == IntegratorChoice::automatic ? Emission::learned : Emission::power;
}

const char* name_of(IntegratorChoice integrator) {
  constexpr const char* names[] = {"pt", "lt", "bpt", "ppm", "bpm", "vcm", "gmis", "auto"};
  return names[static_cast<std::size_t>(integrator)];
}

const char* name_of(SplitChoice split) {
  constexpr const char* names[] = {"none", "paper", "budgeted", "local"};
  return names[static_cast<std::size_t>(split)];
}

const char* name_of(scene::LightSelection lights) {
  switch (lights) {
    case scene::LightSelection::by_power:
      return "power";
    case scene::LightSelection::by_receiver:
      return "receiver";
    case scene::LightSelection::learned:
      break;
  }
  return "learned";
}

RadiusChoice radius_of(const std::string& text) {
  const bool is_in_scene_units = !text.empty() && text.back() == 'u';
  const auto value = positive_number_of(text.data(), text.data() + text.size() - (is_in_scene_units ? 1 : 0));
  if (!value)
    throw InputError("--radius " + in_quotes(text) +
                     " must be a number above 0, in pixel widths, or with the suffix u, such as 0.01u, in scene units");
  return {*value, is_in_scene_units};
}

std::string argument_of(double value) {
  char text[32];
  const auto [end, error] = std::to_chars(std::begin(text), std::end(text), value);
  return {text, end};
}

std::string argument_of(const RadiusChoice& radius) {
  return argument_of(radius.value) + (radius.is_in_scene_units ? "u" : "");
}

std::string text_of(const RadiusChoice& radius) {
  std::ostringstream text;
  text << radius.value << (radius.is_in_scene_units ? " scene units" : " pixel widths");
  return text.str();
}

}  // namespace gmis::tools
