#include <cstdlib>

#include "all_headers.hpp"
#include "gmis/gmis.hpp"

float from_second_unit();

int main() {
  return from_second_unit() == gmis::Vec3<float>(1, 2, 3).z ? EXIT_SUCCESS : EXIT_FAILURE;
}
