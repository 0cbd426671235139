#include <gmis_single.hpp>

double from_second_unit();

double from_second_unit() {
  return gmis::Vec3<double>(1, 2, 3).x;
}
