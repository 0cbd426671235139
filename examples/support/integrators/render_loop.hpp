#pragma once

#include <memory>
#include <span>
#include <string>

#include "gmis/transport/integrators.hpp"
#include "support/diagnostics.hpp"
#include "support/frame_source.hpp"
#include "support/render.hpp"

/// \file
/// The engine as a source of frames. Included by one source file per integrator.

namespace gmis::tools {

/// The engine records techniques only when asked to: one type for both halves the time to compile it.
template <class Integrator>
class EngineSource final : public FrameSource {
 public:
  EngineSource(const BuiltScene& built, const RenderRequest& request)
      : engine_(built.scene(), request.settings, request.crop) {
    engine_.keep_contributions(request.techniques || request.class_images);
  }

  void iterate(ThreadedExecutor& executor) override { engine_.iterate(executor); }
  void continue_after(std::uint32_t iteration) override { engine_.continue_after(iteration); }
  [[nodiscard]] std::span<const Spectrum> frame() const override { return engine_.frame(); }
  [[nodiscard]] const Counters& counters() const override { return engine_.counters(); }
  [[nodiscard]] const Counters& light_work() const override { return engine_.light_work(); }
  [[nodiscard]] const RejectionLog& rejections() const override { return engine_.rejections(); }
  [[nodiscard]] const PhaseSeconds& seconds() const override { return engine_.seconds(); }
  [[nodiscard]] std::size_t photon_bytes() const override { return engine_.photon_bytes(); }
  [[nodiscard]] const Tuning& tuning() const override { return engine_.tuning(); }
  [[nodiscard]] std::vector<Trial> trials() const override { return engine_.tuner().trials(); }
  void for_each_contribution(const Visit& visit) const override { engine_.for_each_contribution(visit); }
  [[nodiscard]] ReplayedPath<Spectrum> replay(ThreadedExecutor& executor, const PathName& path) override {
    if (path.kind == PathKind::light && path.number >= engine_.light_tree_count())
      throw InputError("--replay: there is no light tree " + std::to_string(path.number) + ": an iteration has " +
                       std::to_string(engine_.light_tree_count()));
    engine_.prepare_replay(executor, path.iteration);
    return gmis::replay(engine_, path.kind, path.number);
  }

 private:
  Engine<BuiltScene::SceneType, Integrator, true> engine_;
};

template <class Integrator>
[[nodiscard]] std::unique_ptr<FrameSource> start_with(const BuiltScene& scene, const RenderRequest& request) {
  return std::make_unique<EngineSource<Integrator>>(scene, request);
}

}  // namespace gmis::tools
