#include "support/render.hpp"

#include <stdexcept>
#include <string>

#include "support/progressive_render.hpp"

namespace gmis::tools {

Image image_of(const Picture& picture) {
  Image image(picture.size.x, picture.size.y);
  image.rgb = picture.values;
  return image;
}

std::unique_ptr<SceneEngine> start(const BuiltScene& scene, const RenderRequest& request) {
  auto engine = std::make_unique<SceneEngine>(scene.scene(), request.settings, request.candidates,
                                              request.expected_iterations, request.crop);
  engine->keep_contributions(request.techniques || request.class_pictures);
  return engine;
}

RenderResult render(const BuiltScene& scene, const RenderRequest& request, ThreadedExecutor& executor) {
  ProgressiveRender rendering(scene, request);
  if (!request.resume.empty()) try {
      rendering.resume(request.resume);
    } catch (const std::invalid_argument& error) {
      throw InputError(std::string("--resume: ") + error.what());
    }
  const gmis::RenderResult rendered = rendering.run(executor);
  RenderResult result{rendered,
                      image_of(rendered.picture),
                      image_of(rendered.variance),
                      image_of(rendered.half_a),
                      image_of(rendered.half_b),
                      {},
                      {}};
  for (const TechniquePicture& one : rendered.techniques)
    result.techniques.push_back({one.id, image_of(one.weighted), image_of(one.unweighted)});
  for (const ClassPicture& one : rendered.classes.classes)
    result.classes.classes.push_back({one.path_class, image_of(one.picture), one.contributions, one.cost});
  result.classes.unattributed_cost = rendered.classes.unattributed_cost;
  return result;
}

}  // namespace gmis::tools
