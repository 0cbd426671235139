#include "support/render.hpp"

#include <filesystem>
#include <stdexcept>
#include <string>
#include <vector>

#include "gmis/render/join_runs.hpp"
#include "support/engines/engines.hpp"
#include "support/progressive_render.hpp"

namespace gmis::tools {

std::unique_ptr<SceneEngine> start(const BuiltScene& scene, const RenderRequest& request) {
  auto engine = std::make_unique<SceneEngine>(engines_for(scene, request), request.settings, request.candidates,
                                              request.expected_iterations, request.crop);
  engine->keep_contributions(request.keeps_contributions());
  return engine;
}

namespace {

/// --resume with its files, in the order in which messages count them.
std::string resume_argument(const std::vector<std::filesystem::path>& files) {
  std::string text = "--resume";
  for (const auto& file : files) text += (&file == &files.front() ? " " : ", ") + file.string();
  return text;
}

gmis::RenderResult rendered(const BuiltScene& scene, const RenderRequest& request, ThreadedExecutor& executor) {
  try {
    if (request.resume.size() > 1)
      return join_runs<SceneSpectrum>(request, scene.scene().camera().resolution(), request.resume,
                                      engines_for(scene, request).properties);
    ProgressiveRender rendering(scene, request);
    if (!request.resume.empty()) rendering.resume(request.resume.front());
    if (request.on_log)
      for (const ConvergencePoint& point : rendering.log().points()) request.on_log(point);
    return rendering.run(executor);
  } catch (const std::invalid_argument& error) {
    if (!request.resume.empty()) throw InputError(resume_argument(request.resume_files) + ": " + error.what());
    if (request.ranks.count() == 1 && !request.part) throw;
    throw InputError(error.what());
  }
}

}  // namespace

RenderResult render(const BuiltScene& scene, const RenderRequest& request, ThreadedExecutor& executor) {
  const gmis::RenderResult rendered = tools::rendered(scene, request, executor);
  RenderResult result{rendered,
                      image_of(rendered.picture),
                      image_of(rendered.variance),
                      image_of(rendered.half_a),
                      image_of(rendered.half_b),
                      {},
                      {},
                      {}};
  for (const TechniquePicture& one : rendered.techniques)
    result.techniques.push_back({one.id, image_of(one.weighted), image_of(one.unweighted)});
  for (const ClassPicture& one : rendered.classes.classes)
    result.classes.classes.push_back({one.path_class, image_of(one.picture), one.contributions, one.cost});
  for (const LightPicture& one : rendered.by_light) result.by_light.push_back({one.group, image_of(one.picture)});
  result.classes.unattributed_cost = rendered.classes.unattributed_cost;
  return result;
}

}  // namespace gmis::tools
