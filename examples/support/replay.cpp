#include "gmis/transport/output/replay.hpp"

#include <string>

#include "support/replay_text.hpp"

template gmis::ReplayedPath<gmis::tools::SceneSpectrum> gmis::replay(
    const gmis::Engine<gmis::tools::SceneType, gmis::BothSides>&, gmis::PathKind, std::uint32_t);

namespace gmis::tools {
namespace {

template <class Method>
ReplayedPath<SceneSpectrum> replay_with(const BuiltScene& scene, const RenderSettings& settings,
                                        const std::optional<PixelBounds>& crop, ThreadedExecutor& executor,
                                        const PathName& path) {
  Engine<SceneType, Method> engine(scene.scene(), settings, crop);
  if (path.kind == PathKind::light && path.number >= engine.light_tree_count())
    throw InputError("--replay: there is no light tree " + std::to_string(path.number) + ": an iteration has " +
                     std::to_string(engine.light_tree_count()));
  engine.prepare_replay(executor, path.iteration);
  return gmis::replay(engine, path.kind, path.number);
}

}  // namespace

ReplayedPath<SceneSpectrum> replay(const BuiltScene& scene, const RenderRequest& request, ThreadedExecutor& executor,
                                   const PathName& path) {
  RenderSettings settings = request.settings;
  if (request.candidates.size() > 1) {
    const std::uint32_t pilot_iterations = SceneEngine::pilot_iterations_for(request.expected_iterations);
    if (path.iteration <= pilot_iterations)
      throw InputError("--replay: a pilot renders the first " + std::to_string(pilot_iterations) +
                       " iterations, which cannot be replayed: choose a later one, or fix the counts by --connections");
    const auto engine = start(scene, request);
    while (engine->choice() == nullptr) engine->iterate(executor);
    settings.counts = engine->counts();
  }
  if (!settings.counts.traces_light()) {
    settings.light_split = LightSplit::none;
    return replay_with<CameraSide>(scene, settings, request.crop, executor, path);
  }
  if (settings.light_split != LightSplit::none)
    return replay_with<SplitTrees>(scene, settings, request.crop, executor, path);
  return replay_with<BothSides>(scene, settings, request.crop, executor, path);
}

}  // namespace gmis::tools
