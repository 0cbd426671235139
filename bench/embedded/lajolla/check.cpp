#include "gmis/check/check_scene.hpp"

#include <cstdio>
#include <memory>

#include "adapter.hpp"
#include "parsers/parse_scene.h"

// Checks the adapter over one of lajolla's scenes; prints what it breaks.
// Usage: PROGRAM FILE

int main(int argc, char* argv[]) {
  if (argc != 2) return 1;
  const std::unique_ptr<Scene> theirs = parse_scene(argv[1], rtcNewDevice(nullptr));
  const gmis::Findings findings = gmis::check_scene(adapter::Scene(*theirs));
  std::fputs(findings.text().c_str(), stdout);
  return findings.passes() ? 0 : 1;
}
