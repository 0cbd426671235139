#include "gmis/transport/output/replay.hpp"

#include <bit>
#include <string>
#include <utility>

#include "support/progressive_render.hpp"
#include "support/replay_text.hpp"

template gmis::ReplayedPath<gmis::tools::SceneSpectrum> gmis::replay(
    const gmis::Engine<gmis::tools::SceneType, gmis::BothSides>&, gmis::PathKind, std::uint32_t);

namespace gmis::tools {
namespace {

template <class Method>
ReplayedPath<SceneSpectrum> replay_with(const BuiltScene& scene, const RenderSettings& settings,
                                        const std::optional<PixelBounds>& crop, ThreadedExecutor& executor,
                                        const PathName& path, double merging_gain) {
  Engine<SceneType, Method> engine(scene.scene(), settings, crop);
  engine.scale_merging(merging_gain);
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
  double merging_gain = 0.0;
  if (request.candidates.size() > 1) {
    // The pilot chooses the counts, and later iterations the disk and merging's gain, after 4, 8, 16 … of them.
    gmis::RenderRequest same = request;
    same.interrupt = nullptr;
    Render<SceneType> run(scene.scene(), std::move(same));
    const auto counts_are_known = [&] {
      return run.engine().choice() != nullptr &&
             (!run.engine().counts().merges || run.progress().iterations >= std::bit_floor(path.iteration - 1));
    };
    while (!counts_are_known() && run.advance(executor)) {
    }
    settings.counts = run.engine().counts();
    merging_gain = run.engine().merging_gain();
  }
  if (!settings.counts.traces_light()) {
    settings.light_split = LightSplit::none;
    return replay_with<CameraSide>(scene, settings, request.crop, executor, path, merging_gain);
  }
  if (settings.light_split != LightSplit::none)
    return replay_with<SplitTrees>(scene, settings, request.crop, executor, path, merging_gain);
  return replay_with<BothSides>(scene, settings, request.crop, executor, path, merging_gain);
}

}  // namespace gmis::tools
