#include "all_headers.hpp"
#include "gmis/gmis.hpp"

float from_second_unit();

float from_second_unit() {
  return gmis::Vec3<float>(1, 2, 3).z;
}
