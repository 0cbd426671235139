#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "gmis/core/attributes.hpp"
#include "gmis/core/concepts.hpp"
#include "gmis/scene/material.hpp"
#include "gmis/scene/material_effects.hpp"
#include "gmis/scene/rough_dielectric.hpp"
#include "gmis/scene/varying_material.hpp"

namespace gmis::scene {

/// A material at one point of a surface: meets `gmis::BsdfWithLobes`.
///
/// Whether light is reflected or transmitted is read off the shading normal; where the geometric
/// normal says otherwise nothing is scattered. Refracted radiance is divided by the square of the
/// relative index, refracted importance is not: radiance is the physical one in every medium.
///
/// A rough dielectric has a reflecting and a refracting lobe. `sample` chooses between them by the
/// Fresnel reflectance of the facet, so its densities are not those of the lobes mixed by
/// `lobe_weight`, which is fixed at each surface.
template <std::floating_point T = float>
class SurfaceBsdf {
 public:
  using Spectrum = Vec3<T>;
  using Material = scene::Material<T>;
  using Value = BsdfValue<Spectrum>;
  using Sample = ScatterSample<Spectrum>;
  static constexpr int max_lobes = 2;

  SurfaceBsdf() = default;
  /// `material` must outlive this. Normals of unit length, in one hemisphere.
  SurfaceBsdf(const Material& material, const Vec3<T>& geometric_normal, const Vec3<T>& shading_normal) noexcept
      : material_(&material),
        geometric_normal_(geometric_normal),
        shading_normal_(shading_normal),
        is_flat_(geometric_normal == shading_normal) {}
  /// For a material that may vary over the surface; `material` must outlive this.
  SurfaceBsdf(const Material& material, const Vec3<T>& geometric_normal, const Vec3<T>& shading_normal,
              const SurfaceCoordinates<T>& at) noexcept
      : SurfaceBsdf(material, geometric_normal, shading_normal) {
    const Material& part = part_at(material, at);
    material_ = &part;
    uv_ = at.uv;
    if (!part.is_varying) return;
    shading_normal_ = perturbed_normal(part, at, geometric_normal, shading_normal);
    is_flat_ = geometric_normal_ == shading_normal_;
  }

  /// All but the normals.
  struct Compact {
    using Whole = SurfaceBsdf;         ///< the BSDF that this stands for
    const PlainMaterial<T>* material;  ///< the material at the point
    Vec2<T> uv;                        ///< texture coordinates at the point
  };
  /// The BSDF without its normals, which a stored point holds.
  [[nodiscard]] Compact compact() const noexcept { return {material_, uv_}; }
  /// The BSDF again, with the normals of its point.
  SurfaceBsdf(const Compact& compact, const SurfacePoint<T>& point) noexcept
      : material_(compact.material),
        geometric_normal_(point.geometric_normal),
        shading_normal_(point.shading_normal),
        uv_(compact.uv),
        is_flat_(false) {}  // whether they are the same is not worth a test here

  /// Differs from the shading normal of the shape under a bump or normal map.
  [[nodiscard]] const Vec3<T>& shading_normal() const noexcept { return shading_normal_; }

  [[nodiscard]] Value evaluate(const Vec3<T>& to_prev, const Vec3<T>& to_next, TransportMode mode) const noexcept {
    if (is_varying()) [[unlikely]]
      return at_point([=](const SurfaceBsdf& here) { return here.evaluate(to_prev, to_next, mode); });
    const T prev = glm::dot(shading_normal_, to_prev);
    const T next = glm::dot(shading_normal_, to_next);
    if (is_one_of<Kind::rough_dielectric, Kind::diffuse_transmission>()) [[unlikely]]
      return material_->kind == Kind::rough_dielectric ? through_facets(to_prev, to_next, prev, next, mode)
                                                       : through_sheet(to_prev, to_next, prev, next);
    if (is_purely_delta() || !are_reflection(to_prev, to_next, prev, next)) return {};
    return reflect(to_prev, to_next, std::abs(prev), std::abs(next));
  }

  /// A direction drawn from the lobes; `gmis::Bsdf` states the contract.
  [[nodiscard]] std::optional<Sample> sample(const Vec3<T>& to_prev, T u, const Vec2<T>& uv,
                                             TransportMode mode) const noexcept {
    if (is_varying()) [[unlikely]]
      return at_point([=](const SurfaceBsdf& here) { return here.sample(to_prev, u, uv, mode); });
    const T cos_prev = glm::dot(shading_normal_, to_prev);
    if (!is_usable_side(to_prev, cos_prev)) return std::nullopt;
    const PlainMaterial<T>& m = *material_;
    switch (m.kind) {
      case Kind::black:
      case Kind::mix:
        return std::nullopt;
      case Kind::mirror:
        return mirrored(to_prev, cos_prev, m.specular, T(1));
      case Kind::smooth_conductor:
        return mirrored(to_prev, cos_prev, fresnel_conductor(std::abs(cos_prev), m.metal_eta, m.metal_k), T(1));
      case Kind::dielectric:
        return through_dielectric(to_prev, cos_prev, u, mode);
      case Kind::rough_dielectric:
        return sample_facet(to_prev, cos_prev, u, uv, mode);
      case Kind::diffuse_transmission:
        return sample_sheet(to_prev, cos_prev, u, uv);
      case Kind::coated_mirror:
        return mirrored(to_prev, cos_prev, coated_metal_reflectance(std::abs(cos_prev)), T(1));
      case Kind::smooth_coated:
      case Kind::smooth_coated_conductor:
        if (u >= m.diffuse_probability) {
          const T chance = T(1) - m.diffuse_probability;
          const T reflectance = fresnel_dielectric(std::abs(cos_prev), m.eta).reflectance;
          return mirrored(to_prev, cos_prev, m.specular * (reflectance / chance), chance);
        }
        break;
      default:
        break;
    }
    const bool diffuse = u < diffuse_probability();
    const Vec3<T> to_next = draw(diffuse, to_prev, cos_prev, uv);
    const T cos_next = glm::dot(shading_normal_, to_next);
    if (!are_reflection(to_prev, to_next, cos_prev, cos_next)) return std::nullopt;
    const Value value = reflect(to_prev, to_next, std::abs(cos_prev), std::abs(cos_next));
    if (!(value.pdf.forward.value > T(0))) return std::nullopt;
    return Sample{to_next, value.value * (std::abs(cos_next) / value.pdf.forward.value), value.pdf, false, T(1)};
  }

  [[nodiscard]] bool is_purely_delta() const noexcept {
    if (is_one_of<Kind::black, Kind::smooth_conductor, Kind::mirror, Kind::dielectric, Kind::coated_mirror,
                  Kind::mix>())
      return true;
    return material_->kind == Kind::smooth_coated && !(material_->diffuse_probability > T(0));
  }
  [[nodiscard]] Spectrum albedo() const noexcept {
    if (is_varying()) [[unlikely]]
      return at_point([](const SurfaceBsdf& here) { return here.albedo(); });
    return material_->albedo;
  }
  /// Scatters, and without any diffuse part.
  [[nodiscard]] bool is_glossy() const noexcept { return is_purely_glossy(*material_); }
  [[nodiscard]] bool reflects_only() const noexcept {
    return !is_one_of<Kind::rough_dielectric, Kind::diffuse_transmission>();
  }
  [[nodiscard]] bool has_narrow_lobe() const noexcept { return scene::has_narrow_lobe(*material_); }

  [[nodiscard]] int lobe_count() const noexcept {
    switch (material_->kind) {
      case Kind::diffuse:
      case Kind::conductor:
      case Kind::smooth_coated_conductor:
        return 1;
      case Kind::smooth_coated:
        return material_->diffuse_probability > T(0) ? 1 : 0;
      case Kind::phong:
      case Kind::coated:
      case Kind::diffuse_transmission:
        return material_->diffuse_probability > T(0) ? 2 : 1;
      case Kind::rough_dielectric:
      case Kind::coated_conductor:
        return 2;
      default:
        return 0;
    }
  }
  [[nodiscard]] T lobe_weight(int k) const noexcept {
    if (lobe_count() < 2) return T(1);
    if (is_varying()) [[unlikely]]
      return at_point([=](const SurfaceBsdf& here) { return here.lobe_weight(k); });
    const T first =
        material_->kind == Kind::rough_dielectric ? material_->reflection_probability : material_->diffuse_probability;
    return k == 0 ? first : T(1) - first;
  }
  [[nodiscard]] std::optional<Vec3<T>> sample_lobe(int k, const Vec3<T>& to_prev, const Vec2<T>& uv,
                                                   TransportMode mode) const noexcept {
    if (is_varying()) [[unlikely]]
      return at_point([=](const SurfaceBsdf& here) { return here.sample_lobe(k, to_prev, uv, mode); });
    const T cos_prev = glm::dot(shading_normal_, to_prev);
    if (!is_usable_side(to_prev, cos_prev)) return std::nullopt;
    if (material_->kind == Kind::rough_dielectric) {
      const RoughDielectric<T> facets = facets_seen_at(cos_prev);
      return follow_facet(facets, to_prev, cos_prev, facets.sample_facet(to_prev, uv), k == 0);
    }
    if (material_->kind == Kind::diffuse_transmission) {
      const bool reflects = is_diffuse_lobe(k);
      const Vec3<T> to_next = draw_diffuse(reflects ? cos_prev : -cos_prev, uv);
      const T cos_next = glm::dot(shading_normal_, to_next);
      const bool is_there = reflects ? are_reflection(to_prev, to_next, cos_prev, cos_next)
                                     : are_transmission(to_prev, to_next, cos_prev, cos_next);
      return is_there ? std::optional(to_next) : std::nullopt;
    }
    const Vec3<T> to_next = draw(is_diffuse_lobe(k), to_prev, cos_prev, uv);
    if (!are_reflection(to_prev, to_next, cos_prev, glm::dot(shading_normal_, to_next))) return std::nullopt;
    return to_next;
  }
  void lobe_pdfs(const Vec3<T>& to_prev, const Vec3<T>& to_next, T* pdfs) const noexcept {
    if (is_varying()) [[unlikely]]
      return at_point([=](const SurfaceBsdf& here) { here.lobe_pdfs(to_prev, to_next, pdfs); });
    const T prev = glm::dot(shading_normal_, to_prev);
    const T next = glm::dot(shading_normal_, to_next);
    const bool reflects = are_reflection(to_prev, to_next, prev, next);
    if (material_->kind == Kind::rough_dielectric) {
      const RoughDielectric<T> facets = facets_seen_at(prev);
      pdfs[0] = reflects ? facets.reflection(to_prev, to_next, std::abs(prev), std::abs(next)).forward : T(0);
      pdfs[1] = are_transmission(to_prev, to_next, prev, next)
                    ? facets.transmission(to_prev, to_next, std::abs(prev), std::abs(next)).forward
                    : T(0);
      return;
    }
    if (material_->kind == Kind::diffuse_transmission) {
      const T other = are_transmission(to_prev, to_next, prev, next) ? std::abs(next) / pi<T> : T(0);
      for (int k = 0; k < lobe_count(); ++k)
        pdfs[k] = !is_diffuse_lobe(k) ? other : reflects ? std::abs(next) / pi<T> : T(0);
      return;
    }
    for (int k = 0; k < lobe_count(); ++k) {
      if (!reflects)
        pdfs[k] = T(0);
      else if (k == 0 && is_coated_metal())
        pdfs[k] = ggx_pdf(material_->base_alpha, to_prev, to_next, std::abs(prev));
      else if (is_diffuse_lobe(k))
        pdfs[k] = std::abs(next) / pi<T>;
      else
        pdfs[k] = glossy_pdf(to_prev, to_next, std::abs(prev));
    }
  }
  [[nodiscard]] bool has_delta_lobes() const noexcept {
    return lobe_count() == 0 || material_->kind == Kind::smooth_coated ||
           material_->kind == Kind::smooth_coated_conductor;
  }
  /// Phong's glossy lobe alone misses the part of the hemisphere that the diffuse one covers, and
  /// each lobe of a rough dielectric or a thin sheet the other side.
  [[nodiscard]] bool lobes_have_full_support() const noexcept {
    return material_->kind != Kind::phong && material_->kind != Kind::rough_dielectric &&
           material_->kind != Kind::diffuse_transmission;
  }

  /// The material of the surface, without its textures.
  [[nodiscard]] const PlainMaterial<T>& material() const noexcept { return *material_; }

 private:
  // The lobes of rough glass, metals, coats and sheets are never inlined: they are long, and an
  // engine evaluates a BSDF at half a dozen places. They take copies of directions, which then need
  // not be in memory where no such lobe is met.

  using Kind = typename Material::Kind;

  [[nodiscard]] bool is_varying() const noexcept { return material_->is_varying; }
  /// Whether the material is of one of these kinds, by one test for all of them.
  template <Kind... kinds>
  [[nodiscard]] bool is_one_of() const noexcept {
    constexpr std::uint32_t set = ((std::uint32_t{1} << static_cast<unsigned>(kinds)) | ...);
    return ((set >> static_cast<unsigned>(material_->kind)) & 1U) != 0;
  }
  /// Calls `use` with the BSDF of the plain material that a material with textures is at this
  /// point. Out of line: what is rare must not cost registers where it does not happen.
  template <class Use>
  [[nodiscard]] GMIS_RARE auto at_point(Use use) const noexcept {
    const PlainMaterial<T> plain = resolved(static_cast<const Material&>(*material_), uv_);
    SurfaceBsdf here(*this);
    here.material_ = &plain;
    return use(here);
  }

  [[nodiscard]] bool is_usable_side(const Vec3<T>& direction, T cos_shading) const noexcept {
    if (is_flat_) return cos_shading != T(0);
    return cos_shading * glm::dot(geometric_normal_, direction) > T(0);
  }
  [[nodiscard]] bool are_reflection(const Vec3<T>& to_prev, const Vec3<T>& to_next, T prev, T next) const noexcept {
    if (!(prev * next > T(0))) return false;
    return is_flat_ || (is_usable_side(to_prev, prev) && is_usable_side(to_next, next));
  }

  [[nodiscard]] bool are_transmission(const Vec3<T>& to_prev, const Vec3<T>& to_next, T prev, T next) const noexcept {
    if (!(prev * next < T(0))) return false;
    return is_flat_ || (is_usable_side(to_prev, prev) && is_usable_side(to_next, next));
  }

  /// Chance that `sample` draws from the diffuse lobe, delta lobes counted.
  [[nodiscard]] T diffuse_probability() const noexcept {
    return material_->kind == Kind::conductor ? T(0) : material_->diffuse_probability;
  }
  [[nodiscard]] bool is_diffuse_lobe(int k) const noexcept { return k == 0 && diffuse_probability() > T(0); }

  [[nodiscard]] bool is_coated_metal() const noexcept {
    return is_one_of<Kind::coated_conductor, Kind::smooth_coated_conductor>();
  }

  /// f and both densities of `sample`; both directions are on one side, cosines positive.
  [[nodiscard]] Value reflect(const Vec3<T>& to_prev, const Vec3<T>& to_next, T prev, T next) const noexcept {
    const PlainMaterial<T>& m = *material_;
    const T forward = next * (T(1) / pi<T>);
    const T reverse = prev * (T(1) / pi<T>);
    if (m.kind == Kind::diffuse) return {m.diffuse, {{forward}, {reverse}}};
    const T p = m.diffuse_probability;
    if (m.kind == Kind::phong) {
      const T power = phong_power(to_prev, to_next);
      const T glossy = (T(1) - p) * (m.exponent + T(1)) / (T(2) * pi<T>)*power;
      return {m.diffuse + m.specular * ((m.exponent + T(2)) / (T(2) * pi<T>)*power),
              {{p * forward + glossy}, {p * reverse + glossy}}};
    }
    if (m.kind == Kind::smooth_coated) return {m.diffuse * transmitted(prev, next), {{p * forward}, {p * reverse}}};

    if (is_coated_metal()) return reflect_coated_metal(to_prev, to_next, prev, next);
    return reflect_from_facets(to_prev, to_next, prev, next);
  }

  /// `reflect` of a rough conductor, and of a rough coat over a diffuse surface.
  [[nodiscard]] GMIS_NEVER_INLINE Value reflect_from_facets(Vec3<T> to_prev, Vec3<T> to_next, T prev,
                                                            T next) const noexcept {
    const PlainMaterial<T>& m = *material_;
    const Ggx<T> ggx{m.alpha, m.masking};
    const Vec3<T> sum = to_prev + to_next;
    const T length = glm::length(sum);
    // Both directions have the same cosine at the facet. A product of either with the half vector
    // would keep no digits where both are near the horizon.
    const T cos_facet = length / T(2);
    const T distribution = ggx.distribution(sum * (T(1) / length), shading_normal_);
    const T lambda_prev = ggx.lambda(prev);
    const T lambda_next = ggx.lambda(next);
    const T glossy = distribution * ggx.visibility(lambda_prev, lambda_next) / (T(4) * prev * next);
    const T glossy_forward = distribution * ggx.visibility(lambda_prev) / (T(4) * prev);
    const T glossy_reverse = distribution * ggx.visibility(lambda_next) / (T(4) * next);
    if (m.kind == Kind::conductor)
      return {fresnel_conductor(cos_facet, m.metal_eta, m.metal_k) * glossy, {{glossy_forward}, {glossy_reverse}}};
    const T reflectance = fresnel_dielectric(cos_facet, m.eta).reflectance;
    const T p = m.diffuse_probability, forward = next * (T(1) / pi<T>), reverse = prev * (T(1) / pi<T>);
    return {m.diffuse * transmitted(prev, next) + m.specular * (reflectance * glossy),
            {{p * forward + (T(1) - p) * glossy_forward}, {p * reverse + (T(1) - p) * glossy_reverse}}};
  }

  /// Per steradian, of the glossy lobe alone.
  [[nodiscard]] T glossy_pdf(const Vec3<T>& to_prev, const Vec3<T>& to_next, T prev) const noexcept {
    const PlainMaterial<T>& m = *material_;
    if (m.kind == Kind::phong) return (m.exponent + T(1)) / (T(2) * pi<T>)*phong_power(to_prev, to_next);
    return ggx_pdf(m.alpha, to_prev, to_next, prev);
  }
  /// Per steradian, of a reflection at visible facets.
  [[nodiscard]] T ggx_pdf(T alpha, const Vec3<T>& to_prev, const Vec3<T>& to_next, T prev) const noexcept {
    const Ggx<T> ggx{alpha, material_->masking};
    return ggx.distribution(glm::normalize(to_prev + to_next), shading_normal_) * ggx.visibility(ggx.lambda(prev)) /
           (T(4) * prev);
  }

  /// A metal under a coat, without a smooth coat's delta lobe; see `make_coated_conductor`.
  [[nodiscard]] GMIS_NEVER_INLINE Value reflect_coated_metal(Vec3<T> to_prev, Vec3<T> to_next, T prev,
                                                             T next) const noexcept {
    const PlainMaterial<T>& m = *material_;
    const Vec3<T> sum = to_prev + to_next;
    const T length = glm::length(sum);
    const T cos_facet = length / T(2);
    const Vec3<T> half = sum * (T(1) / length);
    const auto coat = fresnel_dielectric(cos_facet, m.eta);
    const Spectrum metal = fresnel_conductor(coat.cos_transmitted, m.metal_eta, m.metal_k);
    const auto lobe = [&](T alpha) {
      const Ggx<T> ggx{alpha, m.masking};
      const T distribution = ggx.distribution(half, shading_normal_);
      const T lambda_prev = ggx.lambda(prev), lambda_next = ggx.lambda(next);
      return std::array{distribution * ggx.visibility(lambda_prev, lambda_next) / (T(4) * prev * next),
                        distribution * ggx.visibility(lambda_prev) / (T(4) * prev),
                        distribution * ggx.visibility(lambda_next) / (T(4) * next)};
    };
    const T p = m.diffuse_probability;
    const auto base = lobe(m.base_alpha);
    Value result{metal / not_trapped(metal, coat.reflectance) * (transmitted(prev, next) * base[0]),
                 {{p * base[1]}, {p * base[2]}}};
    if (m.kind == Kind::smooth_coated_conductor) return result;
    const auto top = lobe(m.alpha);
    result.value += Spectrum(coat.reflectance * top[0]);
    result.pdf.forward.value += (T(1) - p) * top[1];
    result.pdf.reverse.value += (T(1) - p) * top[2];
    return result;
  }
  /// Reflectance of a smooth metal under a smooth coat.
  [[nodiscard]] Spectrum coated_metal_reflectance(T cosine) const noexcept {
    const auto coat = fresnel_dielectric(cosine, material_->eta);
    const Spectrum metal = fresnel_conductor(coat.cos_transmitted, material_->metal_eta, material_->metal_k);
    const T through = T(1) - coat.reflectance;
    return Spectrum(coat.reflectance) + metal * (through * through) / not_trapped(metal, coat.reflectance);
  }
  /// 1 − the share that is reflected by metal and coat in turn; above 0, where both reflect all
  /// there is.
  [[nodiscard]] static Spectrum not_trapped(const Spectrum& metal, T coat) noexcept {
    return glm::max(Spectrum(T(1)) - metal * coat, Spectrum(std::numeric_limits<T>::min()));
  }

  /// Diffuse transmission.
  [[nodiscard]] GMIS_NEVER_INLINE Value through_sheet(Vec3<T> to_prev, Vec3<T> to_next, T prev, T next) const noexcept {
    const bool reflects = are_reflection(to_prev, to_next, prev, next);
    if (!reflects && !are_transmission(to_prev, to_next, prev, next)) return {};
    const T share = (reflects ? material_->diffuse_probability : T(1) - material_->diffuse_probability) / pi<T>;
    return {reflects ? material_->diffuse : material_->specular, {{share * std::abs(next)}, {share * std::abs(prev)}}};
  }
  [[nodiscard]] GMIS_NEVER_INLINE std::optional<Sample> sample_sheet(Vec3<T> to_prev, T cos_prev, T u,
                                                                     Vec2<T> uv) const noexcept {
    const bool reflects = u < material_->diffuse_probability;
    const Vec3<T> to_next = draw_diffuse(reflects ? cos_prev : -cos_prev, uv);
    const T cos_next = glm::dot(shading_normal_, to_next);
    const Value value = through_sheet(to_prev, to_next, cos_prev, cos_next);
    if (!(value.pdf.forward.value > T(0))) return std::nullopt;
    return Sample{to_next, value.value * (std::abs(cos_next) / value.pdf.forward.value), value.pdf, false, T(1)};
  }
  /// Cosine-distributed, on the side that the sign of `side` says.
  [[nodiscard]] Vec3<T> draw_diffuse(T side, const Vec2<T>& uv) const noexcept {
    const Vec3<T> normal = side < T(0) ? -shading_normal_ : shading_normal_;
    return Frame<T>::around(normal).to_world(square_to_cosine_hemisphere(uv));
  }

  /// cosⁿ of the angle between `to_next` and the mirror image of `to_prev`; the same both ways
  /// round.
  [[nodiscard]] T phong_power(const Vec3<T>& to_prev, const Vec3<T>& to_next) const noexcept {
    // 1 − cos from the distance of the two: the cosine itself has not the digits for a high power.
    const Vec3<T> apart = reflect_about(to_prev, shading_normal_) - to_next;
    const T drop = glm::dot(apart, apart) / T(2);
    if (!(drop < T(1))) return T(0);
    if constexpr (std::same_as<T, float>)  // 1 − drop has digits enough in double, and its logarithm is the shorter one
      return std::exp(material_->exponent * static_cast<float>(std::log(1.0 - static_cast<double>(drop))));
    else
      return std::exp(material_->exponent * std::log1p(-drop));
  }
  /// Both passages of light through the coat.
  [[nodiscard]] T transmitted(T prev, T next) const noexcept {
    return (T(1) - fresnel_dielectric(prev, material_->eta).reflectance) *
           (T(1) - fresnel_dielectric(next, material_->eta).reflectance);
  }

  [[nodiscard]] Vec3<T> draw(bool diffuse, const Vec3<T>& to_prev, T cos_prev, const Vec2<T>& uv) const noexcept {
    const PlainMaterial<T>& m = *material_;
    const Vec3<T> normal = cos_prev < T(0) ? -shading_normal_ : shading_normal_;
    if (diffuse && !is_coated_metal()) return Frame<T>::around(normal).to_world(square_to_cosine_hemisphere(uv));
    if (m.kind == Kind::phong) {
      // The cosine is u^(1/(n + 1)); 1 − cos keeps its digits in narrow lobes.
      const T drop = -std::expm1(std::log(uv.x) / (m.exponent + T(1)));
      const T sine = sqrt_or_zero(drop * (T(2) - drop));
      const auto turn = cos_sin_of_turns(uv.y);
      return Frame<T>::around(reflect_about(to_prev, normal)).to_world({sine * turn.cos, sine * turn.sin, T(1) - drop});
    }
    return draw_by_facet(diffuse ? m.base_alpha : m.alpha, to_prev, normal, uv);
  }
  /// The mirror direction at a facet that is visible from `to_prev`.
  [[nodiscard]] GMIS_NEVER_INLINE Vec3<T> draw_by_facet(T alpha, Vec3<T> to_prev, Vec3<T> normal,
                                                        Vec2<T> uv) const noexcept {
    const auto frame = Frame<T>::around(normal);
    const Vec3<T> half = Ggx<T>{alpha, material_->masking}.sample_visible(frame.to_local(to_prev), uv);
    return glm::normalize(reflect_about(to_prev, frame.to_world(half)));
  }

  [[nodiscard]] std::optional<Sample> mirrored(const Vec3<T>& to_prev, T cos_prev, const Spectrum& weight,
                                               T selection_probability) const noexcept {
    const Vec3<T> to_next = shading_normal_ * (T(2) * cos_prev) - to_prev;
    if (!is_usable_side(to_next, cos_prev)) return std::nullopt;
    return Sample{to_next, weight, {{selection_probability}, {selection_probability}}, true, T(1)};
  }

  [[nodiscard]] std::optional<Sample> through_dielectric(const Vec3<T>& to_prev, T cos_prev, T u,
                                                         TransportMode mode) const noexcept {
    if (material_->is_thin) [[unlikely]]
      return through_pane(to_prev, cos_prev, u);
    const T eta = cos_prev > T(0) ? material_->eta : T(1) / material_->eta;
    const auto fresnel = fresnel_dielectric(std::abs(cos_prev), eta);
    if (u < fresnel.reflectance) return mirrored(to_prev, cos_prev, Spectrum(T(1)), fresnel.reflectance);
    // Snell: the tangential part shrinks by eta, the normal part points to the other side.
    const T normal_part = std::abs(cos_prev) / eta - fresnel.cos_transmitted;
    const Vec3<T> to_next =
        glm::normalize(shading_normal_ * (cos_prev > T(0) ? normal_part : -normal_part) - to_prev * (T(1) / eta));
    if (!is_usable_side(to_next, -cos_prev)) return std::nullopt;
    // Radiance is squeezed into a smaller solid angle where the index is higher.
    const Spectrum weight = material_->specular * (mode == TransportMode::radiance ? T(1) / (eta * eta) : T(1));
    const T chance = T(1) - fresnel.reflectance;
    return Sample{to_next, weight, {{chance}, {chance}}, true, eta};
  }

  [[nodiscard]] std::optional<Sample> through_pane(const Vec3<T>& to_prev, T cos_prev, T u) const noexcept {
    const T of_face = fresnel_dielectric(std::abs(cos_prev), material_->eta).reflectance;
    const T reflectance = T(2) * of_face / (T(1) + of_face);  // R + T²R + T²R³ + …, with T = 1 − R
    if (u < reflectance) return mirrored(to_prev, cos_prev, Spectrum(T(1)), reflectance);
    if (!is_usable_side(-to_prev, -cos_prev)) return std::nullopt;
    const T chance = T(1) - reflectance;
    return Sample{-to_prev, material_->specular, {{chance}, {chance}}, true, T(1)};
  }

  [[nodiscard]] RoughDielectric<T> facets_seen_at(T cos_prev) const noexcept {
    const bool is_outside = cos_prev > T(0);
    return {{material_->alpha, material_->masking},
            is_outside ? material_->eta : T(1) / material_->eta,
            is_outside ? shading_normal_ : -shading_normal_};
  }

  /// f and the densities of `sample` on a rough dielectric, for the signed cosines `prev` and
  /// `next`.
  [[nodiscard]] GMIS_NEVER_INLINE Value through_facets(Vec3<T> to_prev, Vec3<T> to_next, T prev, T next,
                                                       TransportMode mode) const noexcept {
    const RoughDielectric<T> facets = facets_seen_at(prev);
    if (are_reflection(to_prev, to_next, prev, next)) {
      const auto lobe = facets.reflection(to_prev, to_next, std::abs(prev), std::abs(next));
      return {Spectrum(lobe.reflectance * lobe.value),
              {{lobe.reflectance * lobe.forward}, {lobe.reflectance * lobe.reverse}}};
    }
    if (!are_transmission(to_prev, to_next, prev, next)) return {};
    const auto lobe = facets.transmission(to_prev, to_next, std::abs(prev), std::abs(next));
    const T share = T(1) - lobe.reflectance;
    const T value = mode == TransportMode::radiance ? lobe.value / (facets.eta * facets.eta) : lobe.value;
    return {material_->specular * (share * value), {{share * lobe.forward}, {share * lobe.reverse}}};
  }

  /// Where a facet sends what comes along `to_prev`; nothing when that is the wrong side of the
  /// surface, or there is no refraction.
  [[nodiscard]] std::optional<Vec3<T>> follow_facet(const RoughDielectric<T>& facets, const Vec3<T>& to_prev,
                                                    T cos_prev, const Vec3<T>& half, bool reflects) const noexcept {
    if (reflects) {
      const Vec3<T> to_next = glm::normalize(reflect_about(to_prev, half));
      if (are_reflection(to_prev, to_next, cos_prev, glm::dot(shading_normal_, to_next))) return to_next;
      return std::nullopt;
    }
    const auto fresnel = facets.fresnel_at(to_prev, half);
    if (!(fresnel.reflectance < T(1))) return std::nullopt;
    const Vec3<T> to_next = facets.refracted(to_prev, half, fresnel.cos_transmitted);
    if (are_transmission(to_prev, to_next, cos_prev, glm::dot(shading_normal_, to_next))) return to_next;
    return std::nullopt;
  }

  [[nodiscard]] GMIS_NEVER_INLINE std::optional<Sample> sample_facet(Vec3<T> to_prev, T cos_prev, T u, Vec2<T> uv,
                                                                     TransportMode mode) const noexcept {
    const RoughDielectric<T> facets = facets_seen_at(cos_prev);
    const Vec3<T> half = facets.sample_facet(to_prev, uv);
    const bool reflects = u < facets.fresnel_at(to_prev, half).reflectance;
    const auto to_next = follow_facet(facets, to_prev, cos_prev, half, reflects);
    if (!to_next) return std::nullopt;
    const T cos_next = glm::dot(shading_normal_, *to_next);
    const Value value = through_facets(to_prev, *to_next, cos_prev, cos_next, mode);
    if (!(value.pdf.forward.value > T(0))) return std::nullopt;
    return Sample{*to_next, value.value * (std::abs(cos_next) / value.pdf.forward.value), value.pdf, false,
                  reflects ? T(1) : facets.eta};
  }

  const PlainMaterial<T>* material_ = nullptr;  ///< a `Material` where it varies
  Vec3<T> geometric_normal_{};
  Vec3<T> shading_normal_{};
  Vec2<T> uv_{};
  bool is_flat_ = true;
};

static_assert(BsdfWithLobes<SurfaceBsdf<float>>);
static_assert(BsdfWithLobes<SurfaceBsdf<double>>);

}  // namespace gmis::scene
