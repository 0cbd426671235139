// The check of a camera with a reconstruction filter wider than a pixel.
#include "gmis/check/check_camera.hpp"

#include <optional>
#include <vector>

#include "support/catch.hpp"
#include "support/seed.hpp"
#include "transport/filtered_pinhole.hpp"

using namespace gmis;
using gmis_test::FilteredPinhole;
using gmis_test::Gaussian;
using gmis_test::Tent;

namespace {

/// The first finding when a mistake is planted in a larger picture.
template <class Filter>
std::optional<Convention> named(bool FilteredPinhole<Filter>::*mistake) {
  FilteredPinhole<Filter> wrong{{64, 48}, {0, 0, 0}, 0.014};
  wrong.*mistake = true;
  Philox source(gmis_test::seed(8));
  const std::vector<Finding> found = check_camera(wrong, source).broken();
  return found.empty() ? std::nullopt : std::optional(found.front().convention);
}

}  // namespace

TEMPLATE_TEST_CASE("the check of a camera names what a filter could hide", "[check]", Tent, Gaussian) {
  using Pinhole = FilteredPinhole<TestType>;
  CHECK(named(&Pinhole::is_density_of_picture) == Convention::camera_density);
  CHECK(named(&Pinhole::lacks_a_cosine) == Convention::camera_density);
  // The tent is narrow enough that a pixel is found which its ray cannot reach.
  CHECK((named(&Pinhole::shifts_pixel) == Convention::camera_filter ||
         named(&Pinhole::shifts_pixel) == Convention::camera_pixel));
  CHECK(named(&Pinhole::ignores_filter) == Convention::camera_filter);
}

TEST_CASE("the check of a camera knows of filters", "[check]") {
  Philox source(gmis_test::seed(7));
  for (const glm::ivec2 size : {glm::ivec2(10, 8), glm::ivec2(64, 48), glm::ivec2(5, 4)}) {
    CHECK(check_camera(FilteredPinhole<Tent>{size}, source).text() == "");
    CHECK(check_camera(FilteredPinhole<Gaussian>{size}, source).text() == "");
    CHECK(check_camera(FilteredPinhole<Gaussian>{size, {0, 0, 0}, 0.01}, source).text() == "");
  }
  FilteredPinhole<Tent> wrong;
  wrong.fault = 0.5;
  CHECK(check_camera(wrong, source).is_broken(Convention::camera_two_densities));
}
