#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdio>
#include <limits>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "gmis/check/convention.hpp"
#include "gmis/core/math.hpp"

/// \file
/// The report of `check_scene`, `check_camera`, `check_light` and `SurfaceCheck`.

namespace gmis {

/// One case that breaks a convention: where it was met, and the two numbers that differ. A number
/// that does not apply is NaN.
struct FindingExample {
  Vec3<double> at{0};       ///< the surface point, or the receiver of a next event, in scene units
  Vec3<double> to_prev{0};  ///< unit; zero where no direction applies
  Vec3<double> to_next{0};  ///< unit; zero where no direction applies
  double found = std::numeric_limits<double>::quiet_NaN();   ///< as the adapter states it
  double wanted = std::numeric_limits<double>::quiet_NaN();  ///< as it should be by what the adapter states elsewhere

  /// The case in words, without a place that is not known, and without numbers that are not known
  /// or look the same: "at (1, 2, 3), to_prev (…), to_next (…): 0.5 in place of 0.25".
  [[nodiscard]] std::string text() const {
    const Vec3<double> none(0);
    std::string result;
    if (at != none || to_prev != none || to_next != none) result = "at " + text_of(at);
    if (to_prev != none) result += ", to_prev " + text_of(to_prev);
    if (to_next != none) result += ", to_next " + text_of(to_next);
    const std::string number = text_of(found), other = text_of(wanted);
    if (std::isnan(found) || std::isnan(wanted) || number == other) return result;
    return result + (result.empty() ? "" : ": ") + number + " in place of " + other;
  }

 private:
  [[nodiscard]] static std::string text_of(const Vec3<double>& v) {
    std::array<char, 80> text{};
    std::snprintf(text.data(), text.size(), "(%.4g, %.4g, %.4g)", v.x, v.y, v.z);
    return text.data();
  }
  [[nodiscard]] static std::string text_of(double number) {
    std::array<char, 40> text{};
    std::snprintf(text.data(), text.size(), "%.6g", number);
    return text.data();
  }
};

/// One broken convention.
struct Finding {
  Convention convention = Convention::camera_ray_unit;  ///< what is broken
  std::size_t broken = 0;                               ///< cases that break it, of all groups
  std::size_t tried = 0;                                ///< cases tried, of all groups
  std::optional<FindingExample> example;                ///< one of the cases

  /// The convention in words, the number of cases, and the example on a second line.
  [[nodiscard]] std::string text() const {
    std::string result(sentence_of(convention));
    result += " [" + std::to_string(broken) + " of " + std::to_string(tried) + " cases]\n";
    const std::string text = example ? example->text() : "";
    if (!text.empty()) result += "  for example " + text + "\n";
    return result;
  }
};

/// The findings of a check. Cases are counted by groups, such as the surfaces of one material or
/// the samples of one light, so that a mistake in something rare is not lost among many cases of
/// others.
class Findings {
 public:
  /// The cases that follow belong to this group, and were met at `place`.
  void look_at(std::size_t group, const FindingExample& place) {
    group_ = group;
    place_ = place;
  }
  /// The direction of the cases that follow.
  void look_along(const Vec3<double>& to_next) { place_.to_next = to_next; }

  /// Counts one case. `found` and `wanted`: for the example.
  void count(Convention convention, bool holds, double found = unknown, double wanted = unknown) {
    Tally& tally = tallies_[{convention, group_}];
    ++tally.tried;
    add_site(convention, holds);
    if (holds) return;
    ++tally.broken;
    keep_example(tally, found, wanted);
  }
  /// A verdict that rests on many cases at once.
  void judge(Convention convention, bool holds, double found = unknown, double wanted = unknown) {
    Tally& tally = tallies_[{convention, group_}];
    ++tally.tried;
    if (holds) return;
    ++tally.broken;
    tally.is_judged_broken = true;
    keep_example(tally, found, wanted);
  }
  /// Joins the cases of another check, group by group.
  void add(const Findings& other) {
    for (const auto& [key, tally] : other.tallies_) {
      Tally& own = tallies_[key];
      own.tried += tally.tried;
      own.broken += tally.broken;
      own.is_judged_broken = own.is_judged_broken || tally.is_judged_broken;
      if (!own.example) own.example = tally.example;
    }
    for (std::size_t i = 0; i < convention_count; ++i)
      sites_[i].insert(sites_[i].end(), other.sites_[i].begin(), other.sites_[i].end());
  }

  /// The broken conventions, causes first: in the order of `Convention`.
  [[nodiscard]] std::vector<Finding> broken() const {
    std::vector<Finding> result;
    for (std::size_t i = 0; i < convention_count; ++i)
      if (const auto convention = static_cast<Convention>(i); is_broken(convention)) {
        result.push_back({convention, 0, tried(convention), {}});
        add_broken_cases(result.back());
      }
    return result;
  }
  /// True when in some group, or in some place, more cases break the convention than rounding
  /// explains, or when a verdict says so.
  [[nodiscard]] bool is_broken(Convention convention) const {
    for (const auto& [key, tally] : tallies_)
      if (key.first == convention && is_beyond_rounding(convention, tally)) return true;
    return is_broken_in_one_place(convention);
  }
  /// True when the cases of this group break the convention.
  [[nodiscard]] bool is_broken(Convention convention, std::size_t group) const {
    const auto found = tallies_.find({convention, group});
    return found != tallies_.end() && is_beyond_rounding(convention, found->second);
  }
  /// Cases tried for a convention; 0 says that nothing is known about it.
  [[nodiscard]] std::size_t tried(Convention convention) const {
    std::size_t result = 0;
    for (const auto& [key, tally] : tallies_)
      if (key.first == convention) result += tally.tried;
    return result;
  }
  /// True when no convention is broken.
  [[nodiscard]] bool passes() const { return broken().empty(); }

  /// For each broken convention a line, and one with an example; empty when none is broken.
  [[nodiscard]] std::string text() const {
    std::string result;
    for (const Finding& finding : broken()) result += finding.text();
    return result;
  }

 private:
  static constexpr double unknown = std::numeric_limits<double>::quiet_NaN();

  struct Tally {
    std::size_t tried = 0, broken = 0;
    bool is_judged_broken = false;
    std::optional<FindingExample> example;
  };
  /// The cases of one convention at one point.
  struct Site {
    Vec3<double> at;
    std::size_t tried = 0, broken = 0;
    [[nodiscard]] bool is_bad() const noexcept { return 2 * broken >= tried; }
  };

  /// Rounding spoils single cases: at edges and at silhouettes.
  [[nodiscard]] static bool is_beyond_rounding(Convention convention, const Tally& tally) noexcept {
    if (tally.is_judged_broken) return true;
    const double tried = static_cast<double>(tally.tried), expected = tolerated(convention) * tried;
    const double limit = std::max(3.0, std::min(tried, expected + 3.0 * std::sqrt(expected)));
    return static_cast<double>(tally.broken) >= limit;
  }
  /// The share of cases that may break a convention by rounding.
  [[nodiscard]] static constexpr double tolerated(Convention convention) noexcept {
    // Far from the horizon no rounding hides a side, and none makes a value of a light negative.
    if (convention == Convention::bsdf_reflects_only || convention == Convention::bsdf_leak ||
        convention == Convention::light_value)
      return 0.0;
    return convention == Convention::hit_normal_slant ? 0.25 : 0.05;
  }

  /// A fault of one small object shares a group with all surfaces like it. Its cases lie together:
  /// of the six sites nearest to one, itself included, at least five are bad, for at least four of
  /// them. Rounding leaves sound sites in between.
  [[nodiscard]] bool is_broken_in_one_place(Convention convention) const {
    const std::vector<Site>& sites = sites_[static_cast<std::size_t>(convention)];
    constexpr std::size_t near = 6, most_bad = 5, least = 4;
    if (sites.size() < 4 * near) return false;
    std::size_t clustered = 0;
    std::vector<std::pair<double, bool>> others(sites.size());
    for (const Site& site : sites) {
      if (!site.is_bad()) continue;
      for (std::size_t i = 0; i < sites.size(); ++i) {
        const Vec3<double> offset = sites[i].at - site.at;
        others[i] = {glm::dot(offset, offset), sites[i].is_bad()};
      }
      std::nth_element(others.begin(), others.begin() + near - 1, others.end());
      const auto bad = std::count_if(others.begin(), others.begin() + near, [](const auto& o) { return o.second; });
      if (static_cast<std::size_t>(bad) >= most_bad && ++clustered >= least) return true;
    }
    return false;
  }

  void add_site(Convention convention, bool holds) {
    std::vector<Site>& sites = sites_[static_cast<std::size_t>(convention)];
    if (sites.empty() || sites.back().at != place_.at) sites.push_back({place_.at});
    ++sites.back().tried;
    if (!holds) ++sites.back().broken;
  }
  void keep_example(Tally& tally, double found, double wanted) const {
    if (tally.example) return;
    tally.example = place_;
    tally.example->found = found;
    tally.example->wanted = wanted;
  }
  void add_broken_cases(Finding& finding) const {
    bool is_of_broken_group = false;
    for (const auto& [key, tally] : tallies_) {
      if (key.first != finding.convention || tally.broken == 0) continue;
      finding.broken += tally.broken;
      const bool is_worse = is_beyond_rounding(key.first, tally) && !is_of_broken_group;
      if (!finding.example || is_worse) finding.example = tally.example;
      is_of_broken_group = is_of_broken_group || is_worse;
    }
  }

  std::size_t group_ = 0;
  FindingExample place_;
  std::map<std::pair<Convention, std::size_t>, Tally> tallies_;
  std::array<std::vector<Site>, convention_count> sites_;
};

}  // namespace gmis
