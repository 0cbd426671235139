#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <gmis/core/effects.hpp>
#include <gmis/core/spectrum.hpp>
#include <gmis/core/warp.hpp>
#include <gmis/scene/surface_model.hpp>
#include <optional>
#include <stdexcept>

/// \file
/// A material that the library does not have: cloth. A sheen lobe made by fibres that stand off the
/// surface [Estevez, Kulla, Production friendly microfacet sheen BRDF, 2017] over a Lambertian
/// base. Nothing here is part of the library: `SceneBuilder<float, ClothBsdf>` is all that it
/// takes.

namespace own {

using gmis::pi;
using Vec2 = gmis::Vec2<float>;
using Vec3 = gmis::Vec3<float>;

/// The sheen lobe of reflectance 1. D(h) = (2 + 1/r) sin^(1/r) θ_h / (2π) [Estevez, Kulla 2017, eq.
/// 2], V = 1 / (4 (a + b − a b)) for the cosines a and b [Neubelt, Pettineo, Crafting a next-gen
/// material pipeline, 2013], f = D V.
struct Sheen {
  float roughness;  ///< r

  /// f [1/sr] without the cosine, for the positive cosines of both directions with the normal and
  /// that of the half vector.
  [[nodiscard]] float value(float cos_prev, float cos_next, float cos_half) const noexcept {
    const float sin2 = std::max(0.0F, 1.0F - cos_half * cos_half);
    const float distribution = (2.0F + 1.0F / roughness) * std::pow(sin2, 0.5F / roughness) / (2.0F * pi<float>);
    return distribution / (4.0F * (cos_prev + cos_next - cos_prev * cos_next));
  }
};

/// The share of light that the sheen lobe reflects, by the cosine of the direction it comes from: a
/// table made once for each material.
class SheenAlbedo {
 public:
  SheenAlbedo() = default;
  explicit SheenAlbedo(const Sheen& sheen) {
    constexpr int steps = 48;  // midpoint rule over cosine and half the azimuth
    for (std::size_t i = 0; i < table_.size(); ++i) {
      const float cos_prev = static_cast<float>(i) / static_cast<float>(cells);
      const float sin_prev = gmis::sqrt_or_zero(1.0F - cos_prev * cos_prev);
      double sum = 0.0;
      for (int j = 0; j < steps; ++j)
        for (int k = 0; k < steps; ++k) {
          const float cos_next = (static_cast<float>(j) + 0.5F) / steps;
          const float sin_next = gmis::sqrt_or_zero(1.0F - cos_next * cos_next);
          const float cos_turn = std::cos(pi<float> * (static_cast<float>(k) + 0.5F) / steps);
          // |prev + next|² = 2 + 2 prev·next
          const float squared = 2.0F + 2.0F * (cos_prev * cos_next + sin_prev * sin_next * cos_turn);
          const float cos_half = (cos_prev + cos_next) / std::sqrt(squared);
          sum += static_cast<double>(sheen.value(cos_prev, cos_next, cos_half) * cos_next);
        }
      table_[i] = static_cast<float>(sum * 2.0 * pi<double> / (steps * steps));
    }
  }

  [[nodiscard]] float at(float cosine) const noexcept {
    const float place = std::clamp(cosine, 0.0F, 1.0F) * static_cast<float>(cells);
    const std::size_t cell = std::min(static_cast<std::size_t>(place), cells - 1);
    const float beyond = place - static_cast<float>(cell);
    return table_[cell] * (1.0F - beyond) + table_[cell + 1] * beyond;
  }
  /// Under light from everywhere: 2 ∫ E(a) a da.
  [[nodiscard]] float mean() const noexcept {
    float sum = 0.0F;
    for (std::size_t i = 0; i < cells; ++i) {
      const float cosine = (static_cast<float>(i) + 0.5F) / static_cast<float>(cells);
      sum += 2.0F * at(cosine) * cosine / static_cast<float>(cells);
    }
    return sum;
  }

 private:
  static constexpr std::size_t cells = 64;
  std::array<float, cells + 1> table_{};
};

/// The parameters of a cloth surface; from `make_cloth`.
struct Cloth {
  Vec3 base{0};   ///< reflectance of the Lambertian base
  Vec3 sheen{0};  ///< colour of the fibres
  Sheen lobe{0.5F};
  SheenAlbedo share;
  float largest_sheen = 0;         ///< of the three channels
  float sheen_probability = 0.5F;  ///< chance of the sheen lobe in `sample`
  Vec3 albedo{0};
};

/// f = sheen · D V + base / π · (1 − s E(a)) (1 − s E(b)), E the share of light that the sheen lobe
/// reflects, s the largest channel of `sheen`. The base gets what the fibres leave it, both ways,
/// so that f is reciprocal and reflects at most 1 [Estevez, Kulla 2017, section 5]. Reflectances
/// from 0 to 1; roughness from 0.25, where E stays below 1, to 1; throws `std::invalid_argument`
/// otherwise.
inline Cloth make_cloth(const Vec3& base, const Vec3& sheen, float roughness) {
  if (!(roughness >= 0.25F && roughness <= 1.0F)) throw std::invalid_argument("roughness must be from 0.25 to 1");
  for (int c = 0; c < 3; ++c)
    if (!(base[c] >= 0.0F && base[c] <= 1.0F && sheen[c] >= 0.0F && sheen[c] <= 1.0F))
      throw std::invalid_argument("the reflectances of cloth must be from 0 to 1");
  Cloth result{base, sheen, {roughness}, SheenAlbedo(Sheen{roughness})};
  result.largest_sheen = gmis::max_channel(sheen);
  const float mean = result.share.mean(), left = 1.0F - result.largest_sheen * mean;
  result.albedo = sheen * mean + base * (left * left);
  const float of_base = gmis::max_channel(base) * left * left, of_sheen = result.largest_sheen * mean;
  if (of_base + of_sheen > 0.0F) result.sheen_probability = std::clamp(of_sheen / (of_base + of_sheen), 0.1F, 0.9F);
  return result;
}

/// Adds the effects of a cloth surface. The sheen lobe is as wide as the diffuse one: for the
/// choice of techniques it counts as diffuse.
inline void add_effects_of(const Cloth& cloth, gmis::Effects& effects) {
  if (!gmis::is_black(cloth.albedo)) effects.diffuse = true;
}

/// Cloth at one point of a surface, alike on both sides. Two lobes: 0 follows the cosine, 1 is
/// uniform over the hemisphere, which is how the authors of the sheen lobe draw from it.
class ClothBsdf {
 public:
  using Spectrum = Vec3;
  using Material = Cloth;
  using Value = gmis::BsdfValue<Spectrum>;
  using Sample = gmis::ScatterSample<Spectrum>;
  static constexpr int max_lobes = 2;

  ClothBsdf(const Cloth& cloth, const Vec3& geometric_normal, const Vec3& shading_normal) noexcept
      : cloth_(&cloth), geometric_normal_(geometric_normal), shading_normal_(shading_normal) {}

  [[nodiscard]] Value evaluate(const Vec3& to_prev, const Vec3& to_next, gmis::TransportMode) const noexcept {
    if (is_purely_delta() || !are_on_one_side(to_prev, to_next)) return {};
    const float prev = std::abs(glm::dot(shading_normal_, to_prev));
    const float next = std::abs(glm::dot(shading_normal_, to_next));
    const float cos_half = std::min(1.0F, (prev + next) / glm::length(to_prev + to_next));
    const float base = (1.0F - cloth_->largest_sheen * cloth_->share.at(prev)) *
                       (1.0F - cloth_->largest_sheen * cloth_->share.at(next)) / pi<float>;
    return {cloth_->base * base + cloth_->sheen * cloth_->lobe.value(prev, next, cos_half), {{pdf(next)}, {pdf(prev)}}};
  }

  [[nodiscard]] std::optional<Sample> sample(const Vec3& to_prev, float u, const Vec2& uv,
                                             gmis::TransportMode mode) const noexcept {
    if (is_purely_delta()) return std::nullopt;
    const auto to_next = sample_lobe(u < cloth_->sheen_probability ? 1 : 0, to_prev, uv, mode);
    if (!to_next) return std::nullopt;
    const Value value = evaluate(to_prev, *to_next, mode);
    if (!(value.pdf.forward.value > 0.0F)) return std::nullopt;
    const float cosine = std::abs(glm::dot(shading_normal_, *to_next));
    return Sample{*to_next, value.value * (cosine / value.pdf.forward.value), value.pdf};
  }

  /// Black cloth scatters nothing: no lobe to connect or to merge.
  [[nodiscard]] bool is_purely_delta() const noexcept { return gmis::is_black(cloth_->albedo); }
  [[nodiscard]] Spectrum albedo() const noexcept { return cloth_->albedo; }

  // From here on `gmis::BsdfWithLobes` only.
  [[nodiscard]] int lobe_count() const noexcept { return is_purely_delta() ? 0 : 2; }
  [[nodiscard]] float lobe_weight(int k) const noexcept {
    return k == 1 ? cloth_->sheen_probability : 1.0F - cloth_->sheen_probability;
  }
  [[nodiscard]] std::optional<Vec3> sample_lobe(int k, const Vec3& to_prev, const Vec2& uv,
                                                gmis::TransportMode) const noexcept {
    const Vec3 local = k == 1 ? gmis::square_to_cone(uv, 1.0F) : gmis::square_to_cosine_hemisphere(uv);
    const Vec3 axis = glm::dot(shading_normal_, to_prev) > 0.0F ? shading_normal_ : -shading_normal_;
    const Vec3 to_next = gmis::Frame<float>::around(axis).to_world(local);
    if (!are_on_one_side(to_prev, to_next)) return std::nullopt;
    return to_next;
  }
  void lobe_pdfs(const Vec3& to_prev, const Vec3& to_next, float* pdfs) const noexcept {
    const bool reflects = are_on_one_side(to_prev, to_next);
    pdfs[0] = reflects ? std::abs(glm::dot(shading_normal_, to_next)) / pi<float> : 0.0F;
    pdfs[1] = reflects ? 1.0F / (2.0F * pi<float>) : 0.0F;
  }
  [[nodiscard]] bool has_delta_lobes() const noexcept { return is_purely_delta(); }
  [[nodiscard]] bool lobes_have_full_support() const noexcept { return true; }

 private:
  /// Per steradian, of `sample`, towards a direction with this cosine.
  [[nodiscard]] float pdf(float cosine) const noexcept {
    return (lobe_weight(0) * cosine + lobe_weight(1) * 0.5F) / pi<float>;
  }
  /// Both directions on the same side, by the shading normal and by the geometric one.
  [[nodiscard]] bool are_on_one_side(const Vec3& to_prev, const Vec3& to_next) const noexcept {
    const float prev = glm::dot(shading_normal_, to_prev), next = glm::dot(shading_normal_, to_next);
    return prev * next > 0.0F && prev * glm::dot(geometric_normal_, to_prev) > 0.0F &&
           next * glm::dot(geometric_normal_, to_next) > 0.0F;
  }

  const Cloth* cloth_;
  Vec3 geometric_normal_;
  Vec3 shading_normal_;
};

static_assert(gmis::IsBsdfWithLobes<ClothBsdf>());
static_assert(gmis::scene::IsSurfaceModel<ClothBsdf, float>());

}  // namespace own
