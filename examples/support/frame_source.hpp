#pragma once

#include <cstddef>
#include <functional>
#include <memory>
#include <span>
#include <vector>

#include "gmis/result/counters.hpp"
#include "gmis/transport/contribution.hpp"
#include "gmis/transport/engine.hpp"
#include "gmis/transport/replay.hpp"
#include "gmis/transport/tuning.hpp"
#include "support/build_scene.hpp"
#include "support/executor.hpp"

namespace gmis::tools {

struct MeasuredChoice;

/// An integrator at work on a scene: one estimate of the whole picture after the other. The one virtual call an
/// iteration lets everything above be compiled once, not once per integrator.
class FrameSource {
 public:
  using Spectrum = BuiltScene::SceneType::Spectrum;
  using Visit = std::function<void(const Contribution<Spectrum>&)>;

  FrameSource() = default;
  virtual ~FrameSource() = default;
  FrameSource(const FrameSource&) = delete;
  FrameSource& operator=(const FrameSource&) = delete;

  virtual void iterate(ThreadedExecutor& executor) = 0;
  /// For a source that has made nothing yet: it goes on where another one stopped.
  virtual void continue_after(std::uint32_t iteration) = 0;
  /// What the latest iteration alone gives, by rows from the upper left; black outside the crop.
  [[nodiscard]] virtual std::span<const Spectrum> frame() const = 0;
  [[nodiscard]] virtual const Counters& counters() const = 0;
  /// The part of them that light trees took.
  [[nodiscard]] virtual const Counters& light_work() const = 0;
  /// The first paths of which something was left out.
  [[nodiscard]] virtual const RejectionLog& rejections() const = 0;
  [[nodiscard]] virtual const PhaseSeconds& seconds() const = 0;
  [[nodiscard]] virtual std::size_t photon_bytes() const = 0;
  /// The counts that the latest iteration was made with, and how they were measured.
  [[nodiscard]] virtual const Tuning& tuning() const = 0;
  [[nodiscard]] virtual std::vector<Trial> trials() const = 0;
  /// How techniques and counts were chosen, once they are; nothing where there was no choice to make.
  [[nodiscard]] virtual const MeasuredChoice* choice() const { return nullptr; }
  /// Every contribution of the latest iteration; none unless the request was for techniques.
  virtual void for_each_contribution(const Visit& visit) const = 0;
  /// One path of a run, traced again alone; of a source that has made nothing but others of the same
  /// iteration.
  [[nodiscard]] virtual ReplayedPath<Spectrum> replay(ThreadedExecutor& executor, const PathName& path) = 0;
};

}  // namespace gmis::tools
