#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "gmis/check/check_scene.hpp"
#include "gmis/core/statistics.hpp"
#include "gmis/scene/scene_builder.hpp"
#include "gmis/transport/engine/engine.hpp"
#include "gmis/transport/state/integrators.hpp"
#include "support/catch.hpp"
#include "support/seed.hpp"

// A camera with a reconstruction filter wider than a pixel, by the rule of docs/your-renderer.md:
// `sample_ray` draws the point of the film with the density h(x − c_p) of its pixel, `project`
// chooses pixel p with the probability h(x − c_p) / H(x), H(x) = Σ_p h(x − c_p), and both state the
// density of all pixels' rays together, H(x) / (A cos³). All techniques then have one factor h / H
// in common, which cancels in the weights. Here h is a tent, with H = 1, or a truncated Gaussian,
// whose H varies.

namespace {

using glm::dvec2;
using glm::dvec3;
using glm::ivec2;

/// A filter in one dimension, 0 beyond a pixel's width from the centre; the filter of the film is a
/// product of two.
struct Tent {
  static double h(double x) { return std::max(0.0, 1.0 - std::abs(x)); }
  /// The inverse of its distribution function.
  static double sample(double u) { return u < 0.5 ? std::sqrt(2.0 * u) - 1.0 : 1.0 - std::sqrt(2.0 * (1.0 - u)); }
};
struct Gaussian {
  static constexpr double sd = 0.4;
  static double distribution(double x) { return 0.5 * std::erfc(-x / (sd * std::sqrt(2.0))); }
  static double h(double x) {
    constexpr double pi = 3.14159265358979323846;
    if (std::abs(x) >= 1.0) return 0.0;
    return std::exp(-0.5 * x * x / (sd * sd)) / (sd * std::sqrt(2.0 * pi)) / (distribution(1.0) - distribution(-1.0));
  }
  static double sample(double u) {
    const double wanted = distribution(-1.0) + u * (distribution(1.0) - distribution(-1.0));
    double low = -1.0, high = 1.0;
    for (int i = 0; i < 50; ++i) (distribution((low + high) / 2.0) < wanted ? low : high) = (low + high) / 2.0;
    return (low + high) / 2.0;
  }
};

/// A pinhole at `eye` that looks along +z, x to the right and y down.
template <class Filter>
struct FilteredPinhole {
  using Spectrum = dvec3;
  ivec2 size{10, 8};
  dvec3 eye{0, 0, 0};  // where the built-in scene puts its camera
  double step = 0.1;   // side of a pixel on the plane at distance 1
  double fault = 1.0;

  [[nodiscard]] ivec2 resolution() const { return size; }
  [[nodiscard]] bool has_parallel_rays() const { return false; }
  [[nodiscard]] double filter_radius() const { return 1.0; }
  /// Σ_p h(x − c_p) in one dimension: the pixels around, inside the picture or not.
  static double sum(double x) {
    double total = 0.0;
    for (int p = static_cast<int>(std::floor(x)) - 2; p <= static_cast<int>(std::floor(x)) + 2; ++p)
      total += Filter::h(x - (p + 0.5));
    return total;
  }
  /// One of the pixels around, with the probability h / H.
  static int choose(double x, double u) {
    const int first = static_cast<int>(std::floor(x)) - 2;
    double left = u * sum(x);
    for (int p = first; p <= first + 4; ++p) {
      left -= Filter::h(x - (p + 0.5));
      if (left < 0.0) return p;
    }
    return static_cast<int>(std::floor(x));
  }
  [[nodiscard]] double density(const dvec2& film, double cosine) const {
    return sum(film.x) * sum(film.y) / (step * step * cosine * cosine * cosine);
  }
  [[nodiscard]] std::optional<gmis::CameraSample<Spectrum>> sample_ray(ivec2 pixel, dvec2 uv, dvec2) const {
    const dvec2 film = dvec2(pixel) + 0.5 + dvec2(Filter::sample(uv.x), Filter::sample(uv.y));
    const dvec3 direction = glm::normalize(dvec3((film - 0.5 * dvec2(size)) * step, 1.0));
    return gmis::CameraSample<Spectrum>{{eye, {}, {}, 0}, direction, Spectrum(1), density(film, direction.z) * fault};
  }
  [[nodiscard]] std::optional<gmis::CameraProjection<Spectrum>> project(const dvec3& point, dvec2 uv) const {
    const dvec3 offset = point - eye;
    if (!(offset.z > 0)) return std::nullopt;
    const dvec2 film = dvec2(offset) / (offset.z * step) + 0.5 * dvec2(size);
    const ivec2 pixel(choose(film.x, uv.x), choose(film.y, uv.y));
    if (pixel.x < 0 || pixel.y < 0 || pixel.x >= size.x || pixel.y >= size.y) return std::nullopt;
    const dvec3 direction = glm::normalize(offset);
    return gmis::CameraProjection<Spectrum>{
        pixel, {eye, {}, {}, 0}, -direction, Spectrum(1), density(film, direction.z)};
  }
};

/// A wall, half white and half black, a lamp in front of it, and a strip that covers a part of the
/// wall: sharp edges within pixels and at the border of the picture.
template <class Filter>
class Room {
 public:
  using Built = gmis::scene::BvhScene<double>;
  using Spectrum = dvec3;
  using Bsdf = Built::Bsdf;
  using Light = Built::Light;
  using Camera = FilteredPinhole<Filter>;

  Room() : built_(build()) {}
  Camera pinhole;

  [[nodiscard]] auto intersect(const gmis::Ray<double>& ray) const { return built_.intersect(ray); }
  [[nodiscard]] bool visible(const gmis::Ray<double>& ray) const { return built_.visible(ray); }
  [[nodiscard]] auto sample_light(double u) const { return built_.sample_light(u); }
  [[nodiscard]] double selection_probability(const Light& light) const { return built_.selection_probability(light); }
  [[nodiscard]] auto infinite_lights() const { return built_.infinite_lights(); }
  [[nodiscard]] const Camera& camera() const { return pinhole; }

 private:
  static Built build() {
    using namespace gmis::scene;
    SceneBuilder<double> builder;
    const auto white = builder.add_material(make_diffuse<double>({0.8, 0.8, 0.8}));
    const auto dark = builder.add_material(make_diffuse<double>({0.1, 0.1, 0.1}));
    const auto black = builder.add_material(make_diffuse<double>({0, 0, 0}));
    const auto rectangle = [&](double x0, double x1, double y0, double y1, double z, std::size_t material) {
      const std::vector<dvec3> corners{{x0, y0, z}, {x1, y0, z}, {x1, y1, z}, {x0, y1, z}};
      builder.add_mesh({corners, std::vector<std::array<int, 3>>{{0, 2, 1}, {0, 3, 2}}}, material);
    };
    rectangle(-6, 0.13, -6, 6, 0, white);
    rectangle(0.13, 6, -6, 6, 0, dark);
    rectangle(-0.55, -0.4, -3, 3, -0.2, dark);
    builder.add_sphere({-0.3, 2.5, -1.5}, 0.6, black, AreaEmission{{4, 4, 4}});
    builder.set_camera(look_at({0, 0, -3}, {0, 0, 0}, {0, 1, 0}, 45, {10, 8}));
    return builder.build();
  }
  Built built_;
};

struct PixelMeans {
  std::vector<double> mean, variance;        // of the mean
  double total = 0.0, total_variance = 0.0;  // sum over the pixels
};

template <class EngineType, class Scene>
PixelMeans render(const Scene& scene, const gmis::SampleCounts& counts, int batches, int iterations) {
  gmis::RenderSettings settings;
  settings.counts = counts;
  settings.counts.light_paths *= 4;
  settings.max_depth = 4;
  settings.radius = 0.05;
  settings.seed = gmis_test::seed(counts.next_events ? 5 : 6);
  gmis::SerialExecutor serial;
  EngineType engine(scene, settings);
  const std::size_t pixels = engine.frame().size();
  std::vector<double> sum(pixels + 1), squares(pixels + 1);  // the last: of all pixels
  for (int b = 0; b < batches; ++b) {
    std::vector<double> batch(pixels + 1);
    for (int i = 0; i < iterations; ++i) {
      engine.iterate(serial);
      for (std::size_t p = 0; p < pixels; ++p) batch[p] += engine.frame()[p].y / iterations;
    }
    for (std::size_t p = 0; p < pixels; ++p) batch[pixels] += batch[p];
    for (std::size_t p = 0; p <= pixels; ++p) sum[p] += batch[p], squares[p] += batch[p] * batch[p];
  }
  PixelMeans result;
  const auto variance_of = [&](std::size_t p) {
    const double mean = sum[p] / batches;
    return std::max(0.0, squares[p] / batches - mean * mean) / (batches - 1);
  };
  for (std::size_t p = 0; p < pixels; ++p) {
    result.mean.push_back(sum[p] / batches);
    result.variance.push_back(variance_of(p));
  }
  result.total = sum[pixels] / batches;
  result.total_variance = variance_of(pixels);
  return result;
}

/// Pixels whose difference is above `limit` standard errors.
int different(const PixelMeans& a, const PixelMeans& b, double limit) {
  int count = 0;
  for (std::size_t p = 0; p < a.mean.size(); ++p)
    if (std::abs(a.mean[p] - b.mean[p]) > limit * std::sqrt(a.variance[p] + b.variance[p]) + 1e-12) ++count;
  return count;
}

/// The difference of both pictures' means, in standard errors.
double difference(const PixelMeans& a, const PixelMeans& b) {
  return (a.total - b.total) / std::sqrt(a.total_variance + b.total_variance);
}

// 80 pixels and their mean, two filters, two comparisons each, at a rate of 1e-6 in all: 3e-9 for
// each, 6.0 standard errors of a normal distribution. A mean of 64 batches follows Student's t with
// about 120 degrees of freedom: 6.4.
constexpr double limit = 6.4;
constexpr int batches = 64, iterations = 40;

template <class Filter>
void check_agreement() {
  const Room<Filter> room;
  const auto path = render<gmis::PathTracer<Room<Filter>>>(room, gmis::integrators::pt, batches, iterations);
  const auto light = render<gmis::Engine<Room<Filter>>>(room, gmis::integrators::lt, batches, iterations);
  const auto both = render<gmis::Engine<Room<Filter>>>(room, gmis::integrators::bpt, batches, iterations);
  CHECK(different(path, light, limit) == 0);
  CHECK(different(path, both, limit) == 0);
  CHECK(std::abs(difference(path, light)) < limit);
  CHECK(std::abs(difference(path, both)) < limit);
  CHECK(*std::min_element(path.mean.begin(), path.mean.end()) > 0);

  // One end states another density: the weights of a path no longer sum to one.
  Room<Filter> wrong;
  wrong.pinhole.fault = 8;
  const auto biased = render<gmis::Engine<Room<Filter>>>(wrong, gmis::integrators::bpt, batches, iterations);
  CHECK(std::abs(difference(path, biased)) > 2 * limit);
}

}  // namespace

static_assert(gmis::Scene<Room<Tent>>);

TEST_CASE("with a filter, light tracing and path tracing agree pixel by pixel: a tent", "[transport]") {
  check_agreement<Tent>();
}

TEST_CASE("with a filter, light tracing and path tracing agree pixel by pixel: a Gaussian", "[transport]") {
  check_agreement<Gaussian>();
}

TEST_CASE("the check of a camera knows of filters", "[transport]") {
  gmis::Philox source(gmis_test::seed(7));
  CHECK(check_camera(FilteredPinhole<Tent>(), source).text() == "");
  CHECK(check_camera(FilteredPinhole<Gaussian>(), source).text() == "");
  FilteredPinhole<Tent> wrong;
  wrong.fault = 0.5;
  CHECK(check_camera(wrong, source).is_broken(gmis::Convention::camera_two_densities));
}
