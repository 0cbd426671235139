#include <cstdio>
#include <gmis/check/check_scene.hpp>

#include "adapter.hpp"
#include "world.hpp"

// Checks the adapter: whether its types do what they state. Run it when the adapter changes; the
// renderer does not need it.

int main() {
  const theirs::World world = theirs::make_world(64, 48);
  const adapter::Scene scene(world);

  const gmis::Findings findings = gmis::check_scene(scene);
  std::fputs(findings.text().c_str(), stderr);
  if (!findings.passes()) return 1;
}
