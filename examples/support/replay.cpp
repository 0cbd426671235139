#include "gmis/transport/replay/replay.hpp"

#include <optional>
#include <string>
#include <utility>

#include "support/progressive_render.hpp"
#include "support/replay_text.hpp"

template gmis::ReplayedPath<gmis::tools::SceneSpectrum> gmis::replay(
    const gmis::Engine<gmis::tools::SceneType, gmis::BothSides>&, gmis::PathKind, std::uint32_t);

namespace gmis::tools {
namespace {

/// The changes that a run has made before the iteration of the path.
struct Changes {
  std::optional<double> radius_factor;
  double merging_gain = 0.0;
};

template <class Method>
ReplayedPath<SceneSpectrum> replay_with(const BuiltScene& scene, const RenderSettings& settings,
                                        const std::optional<PixelBounds>& crop, ThreadedExecutor& executor,
                                        const PathName& path, const Changes& changes,
                                        const typename Engine<SceneType, Method>::Split::Settings& split = {}) {
  Engine<SceneType, Method> engine(scene.scene(), settings, crop, split);
  if (path.kind == PathKind::light && path.number >= engine.light_tree_count())
    throw InputError("--replay: there is no light tree " + std::to_string(path.number) + ": an iteration has " +
                     std::to_string(engine.light_tree_count()));
  if (changes.radius_factor) engine.merge_within(*changes.radius_factor);
  engine.scale_merging(changes.merging_gain);
  engine.prepare_replay(executor, path.iteration);
  return gmis::replay(engine, path.kind, path.number);
}

}  // namespace

ReplayedPath<SceneSpectrum> replay(const BuiltScene& scene, const RenderRequest& request, ThreadedExecutor& executor,
                                   const PathName& path) {
  RenderSettings settings = request.settings;
  Changes changes;
  if (request.candidates.size() > 1) {
    // The pilot chooses the counts; the iterations before that of the path choose the disk and the
    // gain of merging.
    RenderRequest same = request;
    same.interrupt = nullptr;
    ProgressiveRender run(scene, same);
    const auto counts_are_known = [&] {
      const Choice* const choice = run.engine().choice();
      return choice != nullptr &&
             (!run.engine().engine().counts().merges ||
              next_choice_of_merging(run.progress().iterations, choice->expected_iterations) >= path.iteration);
    };
    while (!counts_are_known() && run.advance(executor)) {
    }
    settings.counts = run.engine().engine().counts();
    changes = {settings.counts.radius_factor, run.engine().engine().merging_gain()};
    if (const Choice& choice = *run.engine().choice(); choice.chosen)
      settings.counts = choice.forecasts[*choice.chosen].counts;
  }
  if (!settings.counts.traces_light())
    return replay_with<CameraSide>(scene, settings, request.crop, executor, path, changes);
  if (request.sampler)
    return replay_with<SplitTrees>(scene, settings, request.crop, executor, path, changes, *request.sampler);
  return replay_with<BothSides>(scene, settings, request.crop, executor, path, changes);
}

}  // namespace gmis::tools
