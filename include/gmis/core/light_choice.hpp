#pragma once

#include <cstdint>

#include "gmis/core/concepts.hpp"

/// \file
/// The choice of a light, and its probability. Light subpaths choose with `Scene::sample_light(u)`.
/// Next events choose with the optional member `sample_light(from, u)` of the scene, or as light
/// subpaths do when the scene does not have it.

namespace gmis {

/// A scene that chooses the lights of next events for their receiver, by a light tree for example.
/// It has two optional members, always both:
///
/// - `sample_light(from, u)`: a light for a next event at the surface point `from`; a null light to
///   take none.
/// - `selection_probability(light, from)`: the probability with which `sample_light(from, u)`
///   chooses `light`.
///
/// The probability must be positive wherever the light reaches `from`: otherwise path tracing loses
/// the light. It may depend on the position and the normals of `from`, which are the same from both
/// sides of a surface. It must not depend on anything else, because a light subpath that arrives at
/// `from` asks for it, too. `from.position_error` is not part of the receiver.
template <class S>
concept SceneWithReceiverChoice = Scene<S> &&
    requires(const S& scene, const SurfacePoint<ScalarOf<typename S::Spectrum>>& from, ScalarOf<typename S::Spectrum> u,
             const typename S::Light& light) {
  { scene.sample_light(from, u) } -> std::same_as<LightChoice<ScalarOf<typename S::Spectrum>, typename S::Light>>;
  { scene.selection_probability(light, from) } -> std::same_as<ScalarOf<typename S::Spectrum>>;
};

/// The runs that choose the lights of next events for their receiver.
enum class ReceiverChoice : std::uint8_t {
  never,   ///< none: they choose as light subpaths do
  always,  ///< all
  /// Runs whose first samples say that it gains (transport/emission/learn_lights.hpp); none where
  /// the lights are no `GuidableLight`.
  where_it_pays,
};

/// A scene with the optional member `receiver_choice()`: the runs that use its choice for the
/// receiver. Without this member all runs do.
template <class S>
concept SceneWithOptionalReceiverChoice = SceneWithReceiverChoice<S> && requires(const S& scene) {
  { scene.receiver_choice() } -> std::same_as<ReceiverChoice>;
};

/// The runs that choose the lights of this scene for the receiver.
template <Scene Sc>
[[nodiscard]] constexpr ReceiverChoice receiver_choice_of(const Sc& scene) noexcept {
  if constexpr (SceneWithOptionalReceiverChoice<Sc>) return scene.receiver_choice();
  return SceneWithReceiverChoice<Sc> ? ReceiverChoice::always : ReceiverChoice::never;
}

namespace detail {
/// True for a scene that has one of the two members of `SceneWithReceiverChoice`, or one with
/// another result: a mistake.
template <Scene Sc, class Point, class Light, class T>
inline constexpr bool has_part_of_receiver_choice =
    !SceneWithReceiverChoice<Sc> &&
    (
        requires(const Sc& scene, const Point& from, T u) { scene.sample_light(from, u); } ||
        requires(const Sc& scene, const Point& from, const Light& light) { scene.selection_probability(light, from); });
}  // namespace detail

/// True when next events of this scene choose their light for the receiver.
template <Scene Sc>
[[nodiscard]] constexpr bool chooses_for_receiver() noexcept {
  using T = ScalarOf<typename Sc::Spectrum>;
  static_assert(
      !detail::has_part_of_receiver_choice<Sc, SurfacePoint<T>, typename Sc::Light, T>,
      "sample_light(from, u) and selection_probability(light, from) must both be there, with the results that "
      "SceneWithReceiverChoice requires");
  return SceneWithReceiverChoice<Sc>;
}

/// The light for a next event at `from`, with the probability of this choice. `for_receiver`:
/// whether this run uses the choice for the receiver; read only with
/// `SceneWithOptionalReceiverChoice`.
template <Scene Sc, std::floating_point T>
[[nodiscard]] inline LightChoice<T, typename Sc::Light> sample_light_for(const Sc& scene, const SurfacePoint<T>& from,
                                                                         T u, [[maybe_unused]] bool for_receiver) {
  if constexpr (chooses_for_receiver<Sc>()) {
    if constexpr (SceneWithOptionalReceiverChoice<Sc>)
      if (!for_receiver) [[likely]]
        return scene.sample_light(u);
    return scene.sample_light(from, u);
  } else {
    return scene.sample_light(u);
  }
}

/// The probability with which a light subpath starts on the light of a next event. `choice` is the
/// result of `sample_light_for`.
template <Scene Sc, std::floating_point T>
[[nodiscard]] inline T emission_probability(const Sc& scene, const LightChoice<T, typename Sc::Light>& choice) {
  if constexpr (chooses_for_receiver<Sc>())
    return scene.selection_probability(*choice.light);
  else
    return choice.selection_probability;
}

/// The probability with which a next event at `from` chooses the light of a light subpath. `choice`
/// holds the light and its probability in `sample_light(u)`. `for_receiver`: as in
/// `sample_light_for`.
template <Scene Sc, std::floating_point T>
[[nodiscard]] inline T next_event_probability(const Sc& scene, const LightChoice<T, typename Sc::Light>& choice,
                                              const SurfacePoint<T>& from, [[maybe_unused]] bool for_receiver) {
  if constexpr (chooses_for_receiver<Sc>()) {
    if constexpr (SceneWithOptionalReceiverChoice<Sc>)
      if (!for_receiver) [[likely]]
        return choice.selection_probability;
    return scene.selection_probability(*choice.light, from);
  } else {
    return choice.selection_probability;
  }
}

}  // namespace gmis
