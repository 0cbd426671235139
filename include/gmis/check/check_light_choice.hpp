#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <map>
#include <span>
#include <utility>
#include <vector>

#include "gmis/check/compare.hpp"
#include "gmis/check/density_test.hpp"
#include "gmis/check/surface_points.hpp"
#include "gmis/core/light_choice.hpp"

namespace gmis::detail {

/// The lights of a scene, and checks of how it chooses them: for emission, and for next events at a
/// receiver.
template <Scene Sc>
class LightChoiceCheck {
 public:
  using T = ScalarOf<typename Sc::Spectrum>;
  using Light = typename Sc::Light;
  using Point = SurfacePoint<T>;
  /// Groups of findings that are lights have numbers from here.
  static constexpr std::size_t first_group = 1000;

  /// `level`: chance of a false alarm of all tests together.
  LightChoiceCheck(const Sc& scene, double level, Findings& findings)
      : scene_(scene), level_(level), findings_(findings) {}

  /// The most likely lights first.
  [[nodiscard]] const std::vector<const Light*>& lights() const noexcept { return lights_; }

  /// Chooses lights as the engine does for emission, and counts how often each is chosen. `hits`:
  /// hits of rays, whose lights are added.
  void choose(std::size_t count, std::span<const CheckedHit<Sc>> hits, Philox& source) {
    std::map<const Light*, std::size_t> chosen, first_draw;
    for (std::size_t i = 0; i < count; ++i) {
      const auto choice = scene_.sample_light(uniform<T>(source));
      if (choice.light == nullptr) continue;
      first_draw.emplace(choice.light, i);
      if (++chosen[choice.light] > 16) continue;
      compare(findings_, Convention::light_choice, static_cast<double>(choice.selection_probability),
              static_cast<double>(scene_.selection_probability(*choice.light)), 1e-3);
    }
    for (std::size_t i = 0; i < hits.size(); ++i)
      if (const Light* light = hits[i].hit.light; light != nullptr && chosen.emplace(light, 0).second)
        first_draw.emplace(light, count + i);
    std::vector<std::pair<std::size_t, const Light*>> order;
    for (const auto& [light, times] : chosen) order.push_back({times, light});
    // Pointers differ from run to run: an order of their own would make the checks differ, too.
    // Lights of one count come in the order in which they were drawn.
    std::sort(order.begin(), order.end(), [&](const auto& a, const auto& b) {
      return a.first != b.first ? a.first > b.first : first_draw[a.second] < first_draw[b.second];
    });
    for (const auto& [times, light] : order) {
      findings_.look_at(first_group + lights_.size(), {});
      lights_.push_back(light);
      judge_frequency(Convention::light_frequency, times, count,
                      static_cast<double>(scene_.selection_probability(*light)),
                      level_ / (2.0 * static_cast<double>(order.size())));
      if (light->is_infinite() && !light->is_delta()) {
        bool is_listed = false;
        for (const Light* listed : scene_.infinite_lights()) is_listed = is_listed || listed == light;
        findings_.judge(Convention::light_infinite_list, is_listed);
      }
    }
  }

  /// The light choice of a scene that chooses for the receiver, at this receiver. `share`: of the
  /// level.
  void choose_at(const CheckedHit<Sc>& receiver, std::size_t count, double share,
                 Philox& source) requires SceneWithReceiverChoice<Sc> {
    const Point& from = receiver.hit.point;
    const Vec3<double> at(from.position);
    std::map<const Light*, std::size_t> chosen;
    for (const Light* light : lights_) chosen[light] = 0;
    for (std::size_t i = 0; i < count; ++i) {
      const auto choice = scene_.sample_light(from, uniform<T>(source));
      if (choice.light == nullptr) continue;
      if (++chosen[choice.light] > 16) continue;
      findings_.look_at(group_of(choice.light), {at});
      compare(findings_, Convention::receiver_choice, static_cast<double>(choice.selection_probability),
              static_cast<double>(scene_.selection_probability(*choice.light, from)), 1e-3);
    }
    const double alarm = level_ * share / (2.0 * static_cast<double>(chosen.size()));
    for (const auto& [light, times] : chosen) {
      findings_.look_at(group_of(light), {at});
      judge_frequency(Convention::receiver_frequency, times, count,
                      static_cast<double>(scene_.selection_probability(*light, from)), alarm);
    }
    for (const Light* light : lights_) {
      findings_.look_at(group_of(light), {at});
      if (reaches(*light, receiver, source))
        findings_.count(Convention::receiver_reach, scene_.selection_probability(*light, from) > T(0));
    }
  }

 private:
  [[nodiscard]] std::size_t group_of(const Light* light) const {
    const auto place = std::find(lights_.begin(), lights_.end(), light);
    return first_group + static_cast<std::size_t>(place - lights_.begin());
  }
  void judge_frequency(Convention convention, std::size_t times, std::size_t count, double p, double level) {
    findings_.judge(convention, fits_frequency(times, count, p, level), p,
                    static_cast<double>(times) / static_cast<double>(count));
  }
  /// True when one of 16 samples of the light is seen from the receiver and scattered there: most
  /// of a light may be hidden, and a light that no receiver sees tells nothing.
  [[nodiscard]] bool reaches(const Light& light, const CheckedHit<Sc>& receiver, Philox& source) const {
    const Point& from = receiver.hit.point;
    const auto is_seen = [&] {
      const T u = uniform<T>(source);
      const auto sample = light.sample_next_event(from, {u, uniform<T>(source)});
      if (!sample || is_black(sample->weight)) return false;
      const auto f = receiver.hit.bsdf.evaluate(-receiver.ray.direction, sample->to_light, TransportMode::radiance);
      return !is_black(f.value) &&
             scene_.visible(light.is_infinite() ? leave(from, sample->to_light)
                                                : segment(from, sample->origin, sample->to_light));
    };
    for (int i = 0; i < 16; ++i)
      if (is_seen()) return true;
    return false;
  }

  const Sc& scene_;
  double level_;
  Findings& findings_;
  std::vector<const Light*> lights_;
};

}  // namespace gmis::detail
