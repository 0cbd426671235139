#pragma once

#include <functional>
#include <string>
#include <vector>

#include "adapters/altered_scene.hpp"
#include "gmis/check/check_scene.hpp"
#include "support/catch.hpp"

/// \file
/// Mistakes in what is rare: one surface, one wavelength, one light among many. Each is planted in
/// a sound scene by functions that change results of its members.

namespace gmis_test {

using gmis::Convention;

/// A mistake, and the conventions of which one must be named first.
template <gmis::Scene Inner>
struct RareMistake {
  std::string name;
  std::vector<Convention> causes;
  std::function<void(Alterations<Inner>&)> plant;
};

struct Named {
  int right_cause_first = 0, missed = 0;
};

/// Plants every mistake and counts those whose right cause is named first. The others are listed.
template <gmis::Scene Inner>
[[nodiscard]] Named name_mistakes(const Inner& scene, const std::vector<RareMistake<Inner>>& mistakes,
                                  const gmis::SceneCheckSettings& settings) {
  Named result;
  const Alterations<Inner> none;
  CHECK(gmis::check_scene(AlteredScene<Inner>(scene, none), settings).text() == "");
  for (const auto& mistake : mistakes) {
    Alterations<Inner> changes;
    mistake.plant(changes);
    const gmis::Findings findings = gmis::check_scene(AlteredScene<Inner>(scene, changes), settings);
    const std::vector<gmis::Finding> broken = findings.broken();
    const bool is_right = !broken.empty() && std::find(mistake.causes.begin(), mistake.causes.end(),
                                                       broken.front().convention) != mistake.causes.end();
    if (is_right)
      ++result.right_cause_first;
    else
      WARN(mistake.name << ": not named first\n" << findings.text());
    if (broken.empty()) ++result.missed;
    if (!broken.empty() && !broken.front().example) FAIL_CHECK(mistake.name << ": without an example");
  }
  return result;
}

/// True for points of a ball, a little beyond its surface included.
template <class V>
[[nodiscard]] auto in_ball(const V& center, double radius) {
  return
      [=](const auto& point) { return glm::length(glm::dvec3(point.position) - glm::dvec3(center)) < 1.02 * radius; };
}

/// Multiplies the stated forward density of a surface, in `evaluate` and in `sample`, whose weight
/// stays f |cos| / density, by `factor(point, to_prev, to_next)`.
template <gmis::Scene Inner, class Where, class Factor>
void scale_density(Alterations<Inner>& changes, Where where, Factor factor) {
  changes.evaluate = [=](const auto& point, const auto& to_prev, const auto& to_next, auto, auto& f) {
    if (!where(point)) return;
    f.pdf.forward.value *= factor(point, to_prev, to_next);
    f.pdf.reverse.value *= factor(point, to_next, to_prev);
  };
  changes.sample = [=](const auto& point, const auto& to_prev, auto, auto& s) {
    if (!where(point) || s.is_delta) return;
    const auto scale = factor(point, to_prev, s.to_next);
    s.pdf.forward.value *= scale;
    s.pdf.reverse.value *= factor(point, s.to_next, to_prev);
    s.weight = s.weight / scale;
  };
}

}  // namespace gmis_test
