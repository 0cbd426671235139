#include "support/diagnostics.hpp"
#include "support/options.hpp"

namespace gmis::tools {

IntegratorChoice integrator_of(const std::string& name) {
  if (name == name_of(IntegratorChoice::automatic)) return IntegratorChoice::automatic;
  for (const IntegratorChoice integrator : all_integrators)
    if (name == name_of(integrator)) return integrator;
  throw InputError("--integrator " + in_quotes(name) + " is not known: use auto, pt, lt, bpt, ppm, bpm, vcm or gmis");
}

SplitChoice split_of(const std::string& name) {
  for (const SplitChoice split :
       {SplitChoice::none, SplitChoice::paper, SplitChoice::budgeted, SplitChoice::adaptive, SplitChoice::local})
    if (name == name_of(split)) return split;
  throw InputError("--split " + in_quotes(name) + " is not known: use local, none, paper, budgeted or adaptive");
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

const char* name_of(IntegratorChoice integrator) {
  constexpr const char* names[] = {"pt", "lt", "bpt", "ppm", "bpm", "vcm", "gmis", "auto"};
  return names[static_cast<std::size_t>(integrator)];
}

const char* name_of(SplitChoice split) {
  constexpr const char* names[] = {"none", "paper", "budgeted", "adaptive", "local"};
  return names[static_cast<std::size_t>(split)];
}

}  // namespace gmis::tools
