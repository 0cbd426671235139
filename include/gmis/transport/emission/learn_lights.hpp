#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <numeric>
#include <optional>
#include <span>
#include <unordered_map>
#include <utility>
#include <vector>

#include "gmis/core/light_choice.hpp"
#include "gmis/core/measure.hpp"
#include "gmis/core/random.hpp"
#include "gmis/transport/emission/any_learned_lights.hpp"
#include "gmis/transport/emission/emission_guide.hpp"
#include "gmis/transport/state/first_hit.hpp"
#include "gmis/transport/state/scatter.hpp"

namespace gmis {

/// Light that arrives at a vertex x_1 of a camera subpath from a point x_0 of a light.
template <std::floating_point T, class L>
struct Arrival {
  const L* light;                ///< which
  SurfacePoint<T> origin;        ///< x_0; not used for an infinite light
  Vec3<T> direction;             ///< unit, from x_0 to x_1
  Vec3<T> receiver;              ///< x_1
  T first;                       ///< the light's `EmissionDensity::first`
  T mass;                        ///< estimated contribution to the picture
  T next_event_share = 1;        ///< of `mass`: `detail::next_event_share`
  T chosen = 1;                  ///< probability with which the light was chosen
  T by_power = 1;                ///< probability with which light subpaths choose it
  bool has_narrow_lobe = false;  ///< x_1
};

/// Light that arrives in a scene of this type.
template <Scene Sc>
using ArrivalIn = Arrival<ScalarOf<typename Sc::Spectrum>, typename Sc::Light>;

namespace detail {

/// Share of an arrival that next events make by the balance heuristic. The rest is made by rays
/// that meet the light by chance, drawn with `density` per steradian by the BSDF of `receiver`:
/// much of a uniform sky, all but nothing of a small lamp. Light subpaths are not needed for it. 1
/// for a delta light.
template <class S, class L>
[[nodiscard]] ScalarOf<S> next_event_share(const LightChoice<ScalarOf<S>, L>& choice, const NextEventSample<S>& sample,
                                           const SurfacePoint<ScalarOf<S>>& receiver, ScalarOf<S> density) {
  using T = ScalarOf<S>;
  if (choice.light->is_delta()) return T(1);
  if (!choice.light->is_infinite()) {
    const Vec3<T> offset = sample.origin.position - receiver.position;
    density *=
        solid_angle_per_area(glm::dot(sample.origin.geometric_normal, sample.to_light), glm::dot(offset, offset));
  }
  return T(1) / (T(1) + density / (choice.selection_probability * sample.next_event_density));
}

/// Follows one camera subpath and takes one sample of the lights at each of its vertices, also at
/// specular ones, where next events are impossible: light subpaths are needed there most. At a
/// surface with a narrow lobe the BSDF is replaced by that of a diffuse surface with its albedo.
template <Scene Sc, UniformSource Source, class Found>
void find_arrivals(const Sc& scene, glm::ivec2 pixel, int max_depth, Source source, Found&& found) {
  using T = ScalarOf<typename Sc::Spectrum>;
  source.at_vertex(0);
  const auto [u, v, u_lens, v_lens] = uniforms<T, 4>(source);
  const auto sample = scene.camera().sample_ray(pixel, Vec2<T>{u, v}, Vec2<T>{u_lens, v_lens});
  if (!sample) return;
  SurfacePoint<T> from = sample->origin;
  Vec3<T> direction = sample->direction;
  T throughput = mean_channel(sample->weight);
  bool is_specular = true;  // all events so far
  for (int depth = 1; depth < max_depth; ++depth) {
    const auto hit = depth == 1 ? first_hit(scene, from, direction) : scene.intersect(leave(from, direction));
    if (!hit) return;
    const T albedo = survival_probability(hit->bsdf);
    if (albedo == T(0)) return;
    const T survival = is_specular ? T(1) : camera_survival(albedo);
    source.at_vertex(static_cast<std::uint32_t>(2 * depth));
    const auto [u_light, u_x, u_y] = uniforms<T, 3>(source);
    const auto choice = sample_light_for(scene, hit->point, u_light, true);
    if (choice.light != nullptr)
      if (const auto light = choice.light->sample_next_event(hit->point, Vec2<T>{u_x, u_y})) {
        const T cosine = std::abs(glm::dot(hit->point.shading_normal, light->to_light));
        T response = mean_channel(hit->bsdf.albedo()) / pi<T>;
        T density = cosine / pi<T>;
        const bool is_narrow = hit->bsdf.is_purely_delta() || has_narrow_lobe(hit->bsdf);
        if (!is_narrow) {
          const auto bsdf = hit->bsdf.evaluate(-direction, light->to_light, TransportMode::radiance);
          response = mean_channel(bsdf.value);
          density = bsdf.pdf.forward.value;
        }
        const T mass = throughput * response * mean_channel(light->weight) * (cosine / choice.selection_probability);
        if (mass > T(0) && std::isfinite(mass) && is_usable_density(light->next_event_density) &&
            scene.visible(choice.light->is_infinite() ? leave(hit->point, light->to_light)
                                                      : segment(hit->point, light->origin, light->to_light)))
          found(ArrivalIn<Sc>{choice.light, light->origin, -light->to_light, hit->point.position, light->density.first,
                              mass, next_event_share(choice, *light, hit->point, survival * density),
                              choice.selection_probability, scene.selection_probability(*choice.light), is_narrow});
      }
    source.at_vertex(static_cast<std::uint32_t>(2 * depth + 1));
    const Vec3<T> to_prev = -direction;
    const auto next = scatter<false>(
        ScatteringVertex<typename Sc::Bsdf>{
            hit->bsdf, hit->point, to_prev, TransportMode::radiance, survival, {T(1), T(1)}, {T(1), T(1)}},
        source);
    if (!next) return;
    throughput *= mean_channel(next->weight);
    is_specular = is_specular && next->is_delta;
    from = hit->point;
    direction = next->to_next;
  }
}

/// The quantiles of values with masses: `found[i]` is the least value that together with those
/// below it has at least the mass `wanted[i]`, or the largest value where all have less. `wanted`
/// increases; `below` is mass that counts as below all values. Reorders the values.
template <std::floating_point T>
void find_quantiles(std::span<std::pair<T, double>> values, double below, std::span<const double> wanted,
                    std::span<T> found) {
  if (wanted.empty()) return;
  if (values.size() == 1) {
    std::fill(found.begin(), found.end(), values[0].first);
    return;
  }
  const std::size_t middle = values.size() / 2;
  std::nth_element(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(middle), values.end(),
                   [](const auto& a, const auto& b) { return a.first < b.first; });
  double left = below;
  for (const auto& [value, mass] : values.first(middle)) left += mass;
  const auto split = static_cast<std::size_t>(std::upper_bound(wanted.begin(), wanted.end(), left) - wanted.begin());
  find_quantiles(values.first(middle), below, wanted.first(split), found.first(split));
  find_quantiles(values.subspan(middle), left, wanted.subspan(split), found.subspan(split));
}

/// The aim of one light: the centre is the median of the receivers in each coordinate, and the
/// rings have the same mass, of which an arrival has at most `most`. Nothing when no line comes
/// towards the centre. All arrivals are of one light.
template <std::floating_point T, class L>
[[nodiscard]] std::optional<Aim<T>> aim_at(std::span<const Arrival<T, L>* const> arrivals, double most) {
  constexpr T narrowest = T(1e-3), least_growth = T(1.05);
  constexpr std::size_t rings = Aim<T>::rings;
  std::vector<std::pair<T, double>> values;
  const auto add = [&](T value, const Arrival<T, L>& arrival) {
    values.emplace_back(value, std::min(static_cast<double>(arrival.mass), most));
  };
  const auto sum_of_masses = [&] {
    return std::accumulate(values.begin(), values.end(), 0.0, [](double sum, const auto& v) { return sum + v.second; });
  };
  Vec3<T> centre;
  for (int axis = 0; axis < 3; ++axis) {
    values.clear();
    for (const auto* arrival : arrivals) add(arrival->receiver[axis], *arrival);
    const double half = 0.5 * sum_of_masses();
    find_quantiles<T>(values, 0.0, std::span(&half, 1), std::span(&centre[axis], 1));
  }
  values.clear();
  for (const auto* arrival : arrivals) {
    const bool is_towards =
        arrival->light->is_infinite() || glm::dot(centre - arrival->origin.position, arrival->direction) > T(0);
    if (is_towards) add(glm::length(glm::cross(centre - arrival->receiver, arrival->direction)), *arrival);
  }
  if (values.empty()) return std::nullopt;
  const double mass = sum_of_masses();
  std::array<double, rings> wanted{};
  std::array<T, rings> distances{};
  for (std::size_t k = 0; k < rings; ++k) wanted[k] = mass * (static_cast<double>(k + 1) / static_cast<double>(rings));
  find_quantiles<T>(values, 0.0, wanted, distances);
  if (!(distances.back() > T(0))) return std::nullopt;
  typename Aim<T>::Radii radii{};
  radii[1] = narrowest * distances.back();
  for (std::size_t k = 1; k < radii.size(); ++k)
    radii[k] = std::max({distances[k - 1], radii[k], radii[k - 1] * least_growth});
  return Aim<T>(centre, radii);
}

/// The table over `start_numbers` of one light: the masses in the bins, each arrival's at most
/// `most`, spread by (1 2 1)/4 along either axis.
template <std::floating_point T, class L>
[[nodiscard]] SquareTable<T> table_of(std::span<const Arrival<T, L>* const> arrivals, double most) {
  using Table = SquareTable<T>;
  std::array<double, Table::size> masses{};
  for (const auto* arrival : arrivals)
    if (const auto numbers = arrival->light->start_numbers(arrival->origin, arrival->direction))
      masses[Table::bin_of(*numbers)] += std::min(static_cast<double>(arrival->mass), most);
  return Table(Table::smoothed(masses), 0.1);
}

}  // namespace detail

/// Learns the guide from arrivals of all lights: a light is chosen by the mass that next events
/// make (`next_event_share`), its table and aim follow all of the mass. The order of the lights in
/// it does not depend on addresses. A light with less than a thousandth of the mass keeps its own
/// emission, and so do all but the 64 with the most mass.
template <Scene Sc>
[[nodiscard]] EmissionGuide<Sc> guide_from(std::span<const ArrivalIn<Sc>* const> arrivals) {
  using L = typename Sc::Light;
  using T = ScalarOf<typename Sc::Spectrum>;
  constexpr std::size_t most_lights = 64, least_arrivals = 16;
  constexpr double least_share = 1e-3, own_share = 0.25, largest = 32.0;
  // Single arrivals must not rule the guide: a next event next to a lamp has no bound.
  double total = 0;
  for (const auto* arrival : arrivals) total += static_cast<double>(arrival->mass);
  const double most = largest * total / static_cast<double>(std::max<std::size_t>(1, arrivals.size()));
  struct Part {
    double mass = 0;
    std::vector<const Arrival<T, L>*> arrivals;
  };
  std::vector<Part> parts;
  std::unordered_map<const L*, std::size_t> part_of;
  total = 0;
  for (const auto* arrival : arrivals) {
    const auto [found, is_new] = part_of.try_emplace(arrival->light, parts.size());
    if (is_new) parts.emplace_back();
    Part& part = parts[found->second];
    const double mass = std::min(static_cast<double>(arrival->mass), most);
    const double of_next_events = mass * static_cast<double>(arrival->next_event_share);
    total += of_next_events;
    part.mass += of_next_events;
    part.arrivals.push_back(arrival);
  }
  std::erase_if(parts, [&](const Part& part) {
    return !(part.mass > 0) || part.mass < least_share * total || part.arrivals.size() < least_arrivals;
  });
  std::stable_sort(parts.begin(), parts.end(), [](const Part& a, const Part& b) { return a.mass > b.mass; });
  if (parts.size() > most_lights) parts.resize(most_lights);

  std::vector<GuidedLight<T, L>> lights;
  std::vector<double> masses;
  for (const Part& part : parts)
    if (const auto aim = detail::aim_at<T, L>(part.arrivals, most)) {
      lights.push_back({part.arrivals.front()->light, T(0), detail::table_of<T, L>(part.arrivals, most), *aim});
      masses.push_back(part.mass);
    }
  const double guided = std::accumulate(masses.begin(), masses.end(), 0.0);
  for (std::size_t i = 0; i < lights.size(); ++i) lights[i].probability = static_cast<T>(masses[i] / guided);
  // Lights that are not guided keep what they are worth.
  const double rest = total > 0 ? 1.0 - guided / total : 0.0;
  return EmissionGuide<Sc>(std::move(lights), static_cast<T>(std::max(own_share, rest)));
}

/// The second moment ∫ f²/p of the light that arrives, by emission with the density p of the guide,
/// over that without it. It is taken for an f that is proportional to the density of the arrivals,
/// each counted by its `next_event_share`: below 1 the guide makes emission better, on the whole.
template <Scene Sc>
[[nodiscard]] double relative_moment(const Sc& scene, const EmissionGuide<Sc>& guide,
                                     std::span<const ArrivalIn<Sc>* const> arrivals) {
  double sum = 0, total = 0;
  for (const auto* const a : arrivals) {
    const double mass = static_cast<double>(a->mass) * static_cast<double>(a->next_event_share);
    total += mass;
    sum += mass / static_cast<double>(guide.ratio(*a->light, scene.selection_probability(*a->light), a->first,
                                                  a->origin, a->direction, a->receiver));
  }
  return total > 0 ? sum / total : 1.0;
}

/// Gain of choosing lights for the receiver: the second moment of next events with lights
/// chosen by power over that with lights chosen for the receiver, E[m² p_receiver / p_power] /
/// E[m²]. 1 where no arrival tells, and where the arrivals were chosen by power. Surfaces with a
/// narrow lobe have next events of little value and do not count; the largest hundredth of the
/// contributions is left out, for a few may have most of the sum.
template <std::floating_point T, class L>
[[nodiscard]] double receiver_gain(std::span<const Arrival<T, L>* const> arrivals) {
  std::vector<std::pair<double, double>> squares;  // m², as lights were chosen and as by power
  for (const auto* arrival : arrivals)
    if (!arrival->has_narrow_lobe && arrival->by_power > T(0)) {
      const double moment = square(static_cast<double>(arrival->mass));
      squares.emplace_back(moment,
                           moment * static_cast<double>(arrival->chosen) / static_cast<double>(arrival->by_power));
    }
  std::sort(squares.begin(), squares.end());
  double moment = 0, by_power = 0;
  for (std::size_t i = 0; i < squares.size() - squares.size() / 100; ++i) {
    moment += squares[i].first;
    by_power += squares[i].second;
  }
  return moment > 0 ? by_power / moment : 1.0;
}

/// Knowledge of the lights that a run gathers before its first iteration.
template <Scene Sc>
struct LearnedLights final : AnyLearnedLights {
  EmissionGuide<Sc> guide;              ///< of light subpaths; empty where it would gain little
  double receiver_gain = 1.0;           ///< see the function of this name; 1 where the scene leaves no choice
  std::optional<double> emission_gain;  ///< `LightUse::emission_gain`

  /// True when next events choose lights for the receiver in a scene where this is optional.
  [[nodiscard]] bool choose_for_receiver() const noexcept { return receiver_gain > 1.25; }
};

/// Largest `relative_moment` for which a guide is kept. Above it, the work of the guide's densities
/// was measured not to pay.
inline constexpr double most_relative_moment = 0.4;

/// Learns about the lights from camera subpaths of their own, one for four pixels, from 1024 to
/// 8192 in all, before the first iteration: they add nothing to the picture, and what is learned
/// depends on no sample that it serves. Camera subpaths find where light is needed even when no
/// light subpath would: a far sun misses the scene with all of its subpaths. The guide is empty
/// when it would gain little, `relative_moment` above `most_moment`: when most of the emitted light
/// is of use. With `most_moment` 0 no guide is learned. Same bits for any number of threads.
template <Scene Sc, Executor E>
[[nodiscard]] std::shared_ptr<LearnedLights<Sc>> learn_lights(const Sc& scene, std::uint64_t seed, int max_depth,
                                                              E& executor, double most_moment = most_relative_moment) {
  using Found = std::vector<ArrivalIn<Sc>>;
  constexpr std::size_t part_size = 256;
  constexpr std::uint32_t stream = 6;  // the others: `Engine::Stream`
  const glm::ivec2 size = scene.camera().resolution();
  const auto pixels = static_cast<std::uint64_t>(size.x) * static_cast<std::uint64_t>(size.y);
  const auto part_count = static_cast<std::size_t>(std::clamp<std::uint64_t>(pixels / 1024, 4, 32));
  const std::size_t paths = part_count * part_size;
  std::vector<Found> parts(part_count);
  executor.parallel_for(parts.size(), [&](std::size_t part) {
    Found found;
    for (std::size_t i = part * part_size; i < (part + 1) * part_size; ++i) {
      const std::uint64_t pixel = i * pixels / paths;
      const auto width = static_cast<std::uint64_t>(size.x);
      detail::find_arrivals(scene, {static_cast<int>(pixel % width), static_cast<int>(pixel / width)}, max_depth,
                            Philox(seed, 0, static_cast<std::uint32_t>(i), stream),
                            [&](const auto& arrival) { found.push_back(arrival); });
    }
    parts[part] = found;  // a copy without spare room: memory that was not used before is slow at first
  });
  std::vector<const ArrivalIn<Sc>*> all;
  all.reserve(std::accumulate(parts.begin(), parts.end(), std::size_t{0},
                              [](std::size_t sum, const Found& part) { return sum + part.size(); }));
  for (const Found& part : parts)
    for (const auto& arrival : part) all.push_back(&arrival);
  auto learned = std::make_shared<LearnedLights<Sc>>();
  if (receiver_choice_of(scene) == ReceiverChoice::where_it_pays)
    learned->receiver_gain = receiver_gain(std::span(std::as_const(all)));
  if (!(most_moment > 0.0)) return learned;
  learned->guide = guide_from<Sc>(all);
  const double moment = learned->guide.is_empty() ? 1.0 : relative_moment<Sc>(scene, learned->guide, all);
  learned->emission_gain = 1.0 / moment;
  if (moment > most_moment) learned->guide = {};
  return learned;
}

}  // namespace gmis
