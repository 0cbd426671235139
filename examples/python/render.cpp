// gmis-render's steps for Python: from a scene file to numpy arrays.
#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <atomic>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "support/choices.hpp"
#include "support/first_hit_layers.hpp"
#include "support/load_scene.hpp"
#include "support/options.hpp"
#include "support/output.hpp"
#include "support/scene_files.hpp"
#include "support/session.hpp"

namespace py = pybind11;

namespace gmis::tools {
namespace {

using namespace py::literals;

/// Rows, columns and the first `channels` channels of an image; None without pixels.
py::object array_of(const Image& image, int channels = 3) {
  if (image.rgb.empty()) return py::none();
  std::vector<py::ssize_t> shape{image.height, image.width};
  if (channels > 1) shape.push_back(channels);
  py::array_t<float> result(shape);
  float* out = result.mutable_data();
  const auto count = static_cast<std::size_t>(channels);
  for (std::size_t pixel = 0; pixel < image.rgb.size(); pixel += 3)
    for (std::size_t c = 0; c < count; ++c) *out++ = image.rgb[pixel + c];
  return result;
}

/// The convergence log: an array for each column, NaN where a figure is unknown.
py::dict columns_of(const std::vector<ConvergencePoint>& log) {
  const auto column = [&](auto value) {
    py::array_t<double> result(static_cast<py::ssize_t>(log.size()));
    for (std::size_t i = 0; i < log.size(); ++i) result.mutable_data()[i] = value(log[i]);
    return result;
  };
  static constexpr double unknown = std::numeric_limits<double>::quiet_NaN();
  using Point = const ConvergencePoint&;
  return py::dict("iteration"_a = column([](Point p) { return static_cast<double>(p.iteration); }),
                  "cpu_seconds"_a = column([](Point p) { return p.cpu_seconds; }),
                  "wall_seconds"_a = column([](Point p) { return p.wall_seconds; }),
                  "error"_a = column([](Point p) { return p.estimated_error.value_or(unknown); }),
                  "lower"_a = column([](Point p) { return p.interval ? p.interval->lower : unknown; }),
                  "upper"_a = column([](Point p) { return p.interval ? p.interval->upper : unknown; }));
}

py::list rows_of(const std::optional<PriceTable>& table) {
  py::list rows;
  if (!table) return rows;
  for (const Price& price : table->prices)
    rows.append(py::dict("error"_a = price.error, "iterations"_a = price.iterations,
                         "cpu_seconds"_a = price.cpu_seconds, "wall_seconds"_a = price.wall_seconds,
                         "is_reached"_a = price.is_reached));
  return rows;
}

py::dict render_file(const std::string& file, std::optional<double> error, std::optional<double> seconds,
                     std::optional<std::uint32_t> iterations, const std::string& integrator,
                     std::optional<std::array<int, 2>> size, std::uint64_t seed, int threads, int max_depth) {
  const auto is_positive = [](const auto& limit) { return !limit || *limit > 0; };
  if (!is_positive(error) || !is_positive(seconds) || !is_positive(iterations) || max_depth < 1 || threads < 0)
    throw InputError("error, seconds, iterations and max_depth must be positive, and threads not negative");
  if (size && ((*size)[0] < 1 || (*size)[1] < 1)) throw InputError("a picture needs a positive width and height");
  Options options;
  options.integrator = integrator_of(integrator);
  options.lights = default_lights(options.integrator);
  options.emission = default_emission(options.integrator);
  options.size = size;
  options.seed = seed;
  options.threads = threads;
  options.max_depth = max_depth;
  options.relative_error = error;
  options.seconds = seconds;
  options.iterations = iterations;
  if (!error && !seconds && !iterations) options.iterations = 64;

  std::atomic<bool> is_interrupted = false;
  LoadedScene loaded;
  std::vector<ImageLayer> layers;
  RenderResult result;
  {
    const py::gil_scoped_release release;
    loaded = load_scene(find_scene(file), options.size, Strictness::strict, options.lights);
    const BuiltScene& scene = *loaded.built;
    RenderRequest request = request_of(options, scene);
    request.intervals = true;
    request.interrupt = &is_interrupted;
    // Without a path of any class no error is ever known, and none would end the run.
    if (plan_for_scene(scene, request.settings).classes.is_empty() && !seconds && !iterations)
      request.budget.iterations = 1;
    request.on_iteration = [&](const RunState&) {
      const py::gil_scoped_acquire acquire;
      if (!is_interrupted && PyErr_CheckSignals() != 0) is_interrupted = true;
    };
    ThreadedExecutor executor(options.threads);
    result = render(scene, request, executor);
    layers = first_hit_layers(scene, request.crop, executor);
  }
  if (is_interrupted) {
    py::error_already_set raised;
    if (!raised.matches(PyExc_KeyboardInterrupt)) throw raised;  // Ctrl-C ends the run with the picture so far
  }

  py::list notes;
  for (const Diagnostic& diagnostic : loaded.diagnostics) notes.append(diagnostic.to_string());
  const bool has_interval = result.error && result.error->is_calibrated();
  py::dict picture("beauty"_a = array_of(result.image), "variance"_a = array_of(result.variance));
  for (const ImageLayer& layer : layers)
    picture[py::str(layer.name)] = array_of(layer.image, static_cast<int>(layer.channels.size()));
  picture["error"] = result.error ? py::object(py::float_(result.error->relative_error)) : py::none();
  picture["interval"] = has_interval
                            ? py::object(py::make_tuple(result.error->interval.lower, result.error->interval.upper))
                            : py::none();
  picture["log"] = columns_of(result.log);
  picture["prices"] = rows_of(result.prices);
  picture["iterations"] = result.iterations;
  picture["stopped_by"] = name_of(result.stopped_by);
  picture["wall_seconds"] = result.wall_seconds;
  picture["cpu_seconds"] = result.cpu_seconds;
  picture["is_trustworthy"] = result.is_trustworthy;
  picture["notes"] = notes;
  return picture;
}

}  // namespace
}  // namespace gmis::tools

PYBIND11_MODULE(_render, module) {
  py::register_exception<gmis::tools::InputError>(module, "SceneError", PyExc_ValueError);
  module.def("render", &gmis::tools::render_file);
}
