#include "support/render.hpp"

#include <filesystem>
#include <sstream>
#include <stdexcept>
#include <string>
#include <string_view>
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

/// --resume, and the files that a message speaks of: "checkpoint 2 …", "checkpoints 1 and 3 …".
std::string files_of(const std::string& message, const std::vector<std::filesystem::path>& files) {
  std::string text = "--resume";
  if (files.size() == 1) return text + " " + files[0].string();
  constexpr std::string_view start = "checkpoint";
  if (!message.starts_with(start)) return text;
  std::stringstream words(message.substr(start.size() + (message.starts_with("checkpoints") ? 1 : 0)));
  std::string between;
  std::size_t number = 0;
  for (bool goes_on = true; goes_on && words >> number && number >= 1 && number <= files.size();) {
    text += (between.empty() ? " " : " and ") + files[number - 1].string();
    goes_on = static_cast<bool>(words >> between) && between == "and";
  }
  return text;
}

gmis::RenderResult rendered(const BuiltScene& scene, const RenderRequest& request, ThreadedExecutor& executor) {
  try {
    if (request.resume.size() > 1)
      return join_runs<SceneSpectrum>(request, scene.scene().camera().resolution(), request.resume,
                                      engines_for(scene, request).properties);
    ProgressiveRender rendering(scene, request);
    if (!request.resume.empty()) rendering.resume(request.resume.front());
    return rendering.run(executor);
  } catch (const std::invalid_argument& error) {
    if (!request.resume.empty()) throw InputError(files_of(error.what(), request.resume_files) + ": " + error.what());
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
