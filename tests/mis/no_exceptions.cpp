#include <csignal>
#include <cstdlib>
#include <vector>

#include "gmis/mis.hpp"
#include "gmis/mis/diagnostics.hpp"
#include "mis/proposals.hpp"

// Compiled with -fno-exceptions: the headers compile, right arguments serve, and a wrong one ends
// the program by abort.

int main() {
  const std::vector<test::Ramp> ramps{{-1.0}, {1.0}};
  gmis::Philox source(1);
  const auto estimate = gmis::estimate<gmis::Scheme::N3>([](double) { return 1.0; }, ramps, 10, source);
  const gmis::PilotSamples pilot([](double) { return 1.0; }, ramps, 10, source);
  if (estimate.rounds != 10 || pilot.problem().node_count() != 20) return 1;
  std::signal(SIGABRT, [](int) { std::_Exit(0); });
  const gmis::Groups<> groups(2, 0);
  return 2;
}
