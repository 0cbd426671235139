#pragma once

#include <algorithm>
#include <concepts>
#include <optional>
#include <type_traits>
#include <utility>
#include <variant>

#include "gmis/scene/surface_model.hpp"

/// \file
/// Two surface models in one scene, for example the built-in materials and one of yours:
/// `SceneBuilder<float, EitherBsdf<SurfaceBsdf<float>, MyBsdf>>`. For three, put one `EitherBsdf`
/// into another.

namespace gmis::scene {

/// A material of one of two types; either converts to it, so that `add_material` takes both.
template <class First, class Second>
class EitherMaterial {
 public:
  /// Holds a material of one of the two types.
  template <class M>
  requires(!std::same_as<std::remove_cvref_t<M>, EitherMaterial> &&
           std::convertible_to<M, std::variant<First, Second>>)  //
      EitherMaterial(M&& material)
      : value_(std::forward<M>(material)) {}

  /// The material where it is of that type, else null.
  [[nodiscard]] const First* first() const noexcept { return std::get_if<0>(&value_); }
  /// The material, or null if it is of the first type.
  [[nodiscard]] const Second* second() const noexcept { return std::get_if<1>(&value_); }

 private:
  std::variant<First, Second> value_;
};

/// Adds the effects of the material that it holds.
template <class First, class Second>
void add_effects_of(const EitherMaterial<First, Second>& material, Effects& effects) {
  if (material.first())
    add_effects_of(*material.first(), effects);
  else
    add_effects_of(*material.second(), effects);
}

namespace detail {

/// The most lobes that a point of either has; 0 unless both offer their lobes.
template <class A, class B>
[[nodiscard]] constexpr int most_lobes() noexcept {
  if constexpr (BsdfWithLobes<A> && BsdfWithLobes<B>)
    return std::max(static_cast<int>(A::max_lobes), static_cast<int>(B::max_lobes));
  else
    return 0;
}

}  // namespace detail

/// A surface that scatters by one of two BSDFs: every function is that of the one whose material it
/// was made of, chosen by a branch. Meets `gmis::BsdfWithLobes` where both do, else `gmis::Bsdf`.
/// `A::Material` and `B::Material` must differ.
template <Bsdf A, Bsdf B>
requires(std::same_as<typename A::Spectrum, typename B::Spectrum> &&
         !std::same_as<typename A::Material, typename B::Material>)  //
    class EitherBsdf {
 public:
  using Spectrum = typename A::Spectrum;
  using T = ScalarOf<Spectrum>;
  using Material = EitherMaterial<typename A::Material, typename B::Material>;
  using Value = BsdfValue<Spectrum>;
  using Sample = ScatterSample<Spectrum>;
  static constexpr int max_lobes = detail::most_lobes<A, B>();

  /// `material` must outlive this.
  EitherBsdf(const Material& material, const Vec3<T>& geometric_normal, const Vec3<T>& shading_normal)
      : model_(material.first() ? Model(std::in_place_index<0>, *material.first(), geometric_normal, shading_normal)
                                : Model(std::in_place_index<1>, *material.second(), geometric_normal, shading_normal)) {
  }

  [[nodiscard]] Value evaluate(const Vec3<T>& to_prev, const Vec3<T>& to_next, TransportMode mode) const noexcept {
    return visit([&](const auto& bsdf) { return bsdf.evaluate(to_prev, to_next, mode); });
  }
  /// A direction drawn from the BSDF that is held; `gmis::Bsdf` states the contract.
  [[nodiscard]] std::optional<Sample> sample(const Vec3<T>& to_prev, T u, const Vec2<T>& uv,
                                             TransportMode mode) const noexcept {
    return visit([&](const auto& bsdf) { return bsdf.sample(to_prev, u, uv, mode); });
  }
  [[nodiscard]] bool is_purely_delta() const noexcept {
    return visit([](const auto& bsdf) { return bsdf.is_purely_delta(); });
  }
  [[nodiscard]] Spectrum albedo() const noexcept {
    return visit([](const auto& bsdf) { return Spectrum(bsdf.albedo()); });
  }
  /// Scatters, and without any diffuse part. A BSDF that does not tell counts as diffuse, as it
  /// does on its own.
  [[nodiscard]] bool is_glossy() const noexcept {
    return visit([](const auto& bsdf) {
      if constexpr (requires { bsdf.is_glossy(); })
        return bool(bsdf.is_glossy());
      else
        return false;
    });
  }

  [[nodiscard]] bool has_narrow_lobe() const noexcept {
    return visit([](const auto& bsdf) { return gmis::has_narrow_lobe(bsdf); });
  }

  [[nodiscard]] bool reflects_only() const noexcept {
    return visit([](const auto& bsdf) { return gmis::reflects_only(bsdf); });
  }

  [[nodiscard]] int lobe_count() const noexcept requires(max_lobes > 0) {
    return visit([](const auto& bsdf) { return static_cast<int>(bsdf.lobe_count()); });
  }
  [[nodiscard]] T lobe_weight(int k) const noexcept requires(max_lobes > 0) {
    return visit([&](const auto& bsdf) { return static_cast<T>(bsdf.lobe_weight(k)); });
  }
  [[nodiscard]] std::optional<Vec3<T>> sample_lobe(int k, const Vec3<T>& to_prev, const Vec2<T>& uv,
                                                   TransportMode mode) const noexcept requires(max_lobes > 0) {
    return visit([&](const auto& bsdf) { return bsdf.sample_lobe(k, to_prev, uv, mode); });
  }
  void lobe_pdfs(const Vec3<T>& to_prev, const Vec3<T>& to_next, T* pdfs) const noexcept requires(max_lobes > 0) {
    visit([&](const auto& bsdf) { bsdf.lobe_pdfs(to_prev, to_next, pdfs); });
  }
  [[nodiscard]] bool has_delta_lobes() const noexcept requires(max_lobes > 0) {
    return visit([](const auto& bsdf) { return bsdf.has_delta_lobes(); });
  }
  [[nodiscard]] bool lobes_have_full_support() const noexcept requires(max_lobes > 0) {
    return visit([](const auto& bsdf) { return bsdf.lobes_have_full_support(); });
  }

 private:
  using Model = std::variant<A, B>;

  template <class View>
  [[nodiscard]] decltype(auto) visit(View&& view) const noexcept {
    if (const A* first = std::get_if<0>(&model_)) return view(*first);
    return view(*std::get_if<1>(&model_));
  }

  Model model_;
};

}  // namespace gmis::scene
