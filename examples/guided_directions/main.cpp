#include <array>
#include <cmath>
#include <cstdio>
#include <ctime>
#include <gmis/core/statistics.hpp>
#include <gmis/scene.hpp>
#include <gmis/transport.hpp>
#include <guided_directions/learn_directions.hpp>
#include <vector>

// Path tracing with learned directions, where it pays: the only lamp is inside a glass ball, and no
// next event reaches it. The guide is trained, frozen, and rendered with; the errors of both ways
// are printed over time. Both must have the same mean: the program fails where they have not.

namespace {

using Scene = gmis::scene::BvhScene<>;
using Picture = std::vector<gmis::Vec3<float>>;

Scene make_scene() {
  gmis::scene::SceneBuilder<> builder;
  const auto white = builder.add_material(gmis::scene::make_diffuse({0.7, 0.7, 0.7}));
  const auto warm = builder.add_material(gmis::scene::make_diffuse({0.7, 0.3, 0.2}));
  const auto glass = builder.add_material(gmis::scene::make_dielectric(1.5));
  const auto black = builder.add_material(gmis::scene::make_diffuse({0, 0, 0}));
  const auto wall = [&](const glm::dvec3& centre, const glm::dvec3& a, const glm::dvec3& b, std::size_t material) {
    const std::array<glm::dvec3, 4> corners{{centre - a - b, centre + a - b, centre + a + b, centre - a + b}};
    const std::array<std::array<int, 3>, 2> triangles{{{0, 1, 2}, {0, 2, 3}}};
    builder.add_mesh({corners, triangles}, material);
  };
  for (const double side : {-1.0, 1.0}) {
    wall({side, 0, 0}, {0, 1, 0}, {0, 0, 1}, warm);
    wall({0, side, 0}, {1, 0, 0}, {0, 0, 1}, white);
    wall({0, 0, side}, {1, 0, 0}, {0, 1, 0}, white);
  }
  builder.add_sphere({0.4, -0.6, 0.3}, 0.4, white);
  builder.add_sphere({0, 0.5, 0.1}, 0.25, glass);
  builder.add_sphere({0, 0.5, 0.1}, 0.1, black, gmis::scene::AreaEmission{{30, 30, 30}});
  builder.set_camera(gmis::scene::look_at({0, 0, -0.95}, {0, -0.1, 0}, {0, 1, 0}, 80, {32, 32}));
  return builder.build();
}

double seconds() {
  return static_cast<double>(std::clock()) / CLOCKS_PER_SEC;
}

double mean_of(const Picture& picture) {
  double sum = 0;
  for (const auto& pixel : picture) sum += static_cast<double>(gmis::mean_channel(pixel));
  return sum / static_cast<double>(picture.size());
}

/// Mean over pixels and channels of (x − r)² / (r² + 0.01).
double rel_mse(const Picture& picture, const Picture& reference) {
  double sum = 0;
  for (std::size_t i = 0; i < picture.size(); ++i)
    for (int channel = 0; channel < 3; ++channel) {
      const double x = static_cast<double>(picture[i][channel]), r = static_cast<double>(reference[i][channel]);
      sum += (x - r) * (x - r) / (r * r + 0.01);
    }
  return sum / (3.0 * static_cast<double>(picture.size()));
}

struct Rendered {
  Picture picture;
  double mean, standard_error;
};

/// Renders any scene, guided or not. With a reference it prints the error after 16, 32, 64 …
/// iterations.
template <class Engine, class Scene_>
Rendered render(const char* name, const Scene_& scene, const gmis::RenderSettings& settings, int iterations,
                const Picture* reference, double start) {
  Engine engine(scene, settings);
  gmis::SerialExecutor executor;
  Rendered result{Picture(engine.frame().size(), gmis::Vec3<float>(0)), 0, 0};
  double squares = 0;
  for (int i = 1; i <= iterations; ++i) {
    engine.iterate(executor);
    const Picture frame(engine.frame().begin(), engine.frame().end());
    const double mean = mean_of(frame);
    result.mean += mean / iterations;
    squares += mean * mean / iterations;
    const auto weight = 1.0F / static_cast<float>(i);
    for (std::size_t p = 0; p < frame.size(); ++p) result.picture[p] += (frame[p] - result.picture[p]) * weight;
    if (reference != nullptr && i >= 16 && (i & (i - 1)) == 0)
      std::printf("%-8s %6d iterations  %8.3f s  relMSE %.5f\n", name, i, seconds() - start,
                  rel_mse(result.picture, *reference));
  }
  result.standard_error = std::sqrt(std::max(0.0, squares - result.mean * result.mean) / (iterations - 1));
  return result;
}

}  // namespace

int main() {
  const Scene scene = make_scene();
  gmis::RenderSettings settings;
  settings.max_depth = 8;
  settings.counts = gmis::integrators::bpt;
  const Rendered reference = render<gmis::Engine<Scene>>("bpt", scene, settings, 500, nullptr, 0);

  settings.counts = gmis::integrators::pt;
  constexpr int iterations = 512;
  settings.seed = 1;
  const Rendered plain =
      render<gmis::PathTracer<Scene>>("plain", scene, settings, iterations, &reference.picture, seconds());

  // Train, freeze, and render the same scene with one lobe more at its surfaces.
  const double start = seconds();
  gmis::SerialExecutor executor;
  const gmis::GuideTraining training{.seed = 1, .max_depth = settings.max_depth};
  const gmis::DirectionGuide<float> guide = gmis::learn_directions(scene, training, executor);
  const gmis::GuidedScene<Scene> guided(scene, guide);
  std::printf("trained in %.3f s: %zu cells\n", seconds() - start, guide.cells().size());
  settings.seed = 2;
  const Rendered with_guide = render<gmis::PathTracer<gmis::GuidedScene<Scene>>>("guided", guided, settings, iterations,
                                                                                 &reference.picture, start);

  // Seeds are fixed: this either always passes or never. With others it would fail once in 10,000
  // runs by chance.
  const double error = std::hypot(plain.standard_error, with_guide.standard_error);
  const gmis::StatisticalTest test = gmis::t_test(with_guide.mean - plain.mean, error, iterations, 0);
  const bool agree = test.passes(1e-4);
  std::printf("means %.5f and %.5f, which %s: t = %.2f\n", plain.mean, with_guide.mean, agree ? "agree" : "differ",
              test.statistic);
  return agree ? 0 : 1;
}
