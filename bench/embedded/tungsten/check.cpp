#include "gmis/check/check_scene.hpp"

#include <cstdio>

#include "adapter.hpp"
#include "load.hpp"

// Checks the adapter over one of Tungsten's scenes; prints what it breaks.
// Usage: PROGRAM FILE

int main(int argc, char* argv[]) {
  if (argc != 2) return 1;
  const adapter::Loaded loaded(argv[1]);
  const gmis::Findings findings = gmis::check_scene(adapter::Scene(*loaded.traceable));
  std::fputs(findings.text().c_str(), stdout);
  return findings.passes() ? 0 : 1;
}
