#include <csignal>
#include <cstdlib>

#include "all_headers.hpp"

// Every header with -fno-exceptions and -fno-rtti. A wrong argument then ends the program by abort.

#if defined(__cpp_exceptions) || defined(__cpp_rtti)
#error "this file is to be compiled with -fno-exceptions -fno-rtti"
#endif

int main() {
  gmis::scene::SceneBuilder<float> builder;
  const auto white = builder.add_material(gmis::scene::make_diffuse<float>({0.5, 0.5, 0.5}));
  builder.add_sphere({0, 0, 5}, 1, white);
  std::signal(SIGABRT, [](int) { std::_Exit(EXIT_SUCCESS); });
  builder.add_sphere({0, 0, 5}, -1, white);
  return EXIT_FAILURE;
}
