#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <glm/common.hpp>
#include <limits>
#include <memory>
#include <utility>
#include <vector>

#include "gmis/core/argument_error.hpp"
#include "gmis/core/math.hpp"
#include "gmis/core/spectrum.hpp"

/// \file
/// Colours and numbers that vary over a surface, as functions of its coordinates (u, v).

namespace gmis::scene {

/// The pixels of a texture: 8 bits a channel and a table of the value that each of the 256 bytes
/// stands for, or floats. One channel (grey) or three.
struct TextureImage {
  glm::ivec2 resolution{0};          ///< in texels
  int channels = 3;                  ///< of a texel
  std::vector<std::uint8_t> bytes;   ///< rows from the top; empty when `floats` holds the pixels
  std::array<float, 256> decoded{};  ///< value of each byte
  std::vector<float> floats;         ///< texels of an image of floats

  /// The linear value of the pixel in this column and row, which must be inside.
  [[nodiscard]] glm::vec3 texel(int column, int row) const noexcept {
    const std::size_t pixel =
        static_cast<std::size_t>(row) * static_cast<std::size_t>(resolution.x) + static_cast<std::size_t>(column);
    const std::size_t first = pixel * static_cast<std::size_t>(channels);
    const auto at = [&](std::size_t i) { return bytes.empty() ? floats[i] : decoded[bytes[i]]; };
    return channels == 1 ? glm::vec3(at(first)) : glm::vec3(at(first), at(first + 1), at(first + 2));
  }
};

/// The value of an image beyond its border.
enum class TextureWrap : std::uint8_t { repeat, clamp, black, mirror };
/// Between texels: interpolated, or the nearest one.
enum class TextureFilter : std::uint8_t { bilinear, nearest };

/// (s, t) = (u, v) · scale + (v, u) · cross + offset.
struct TexturePlacement {
  glm::dvec2 scale{1};   ///< factor of (u, v)
  glm::dvec2 offset{0};  ///< added to the product
  glm::dvec2 cross{0};   ///< factor of (v, u): not 0 where the image is turned
};

/// A tree of images, checkerboards, constants and their combinations. Grey values are in all three
/// channels.
template <std::floating_point T = float>
class Texture {
 public:
  using Handle = std::shared_ptr<const Texture>;

  /// One value everywhere.
  [[nodiscard]] static Handle constant(const glm::dvec3& value) {
    Texture result(Kind::constant);
    result.lower_ = result.upper_ = Vec3<T>(value);
    result.mean_ = value;
    return std::make_shared<const Texture>(std::move(result));
  }

  /// (s, t) = (0, 0) is the lower left corner of the image, (1, 1) the upper right. With
  /// `is_inverted` the value is 1 − that of the image, at least 0. Throws `std::invalid_argument`
  /// for an image without pixels or with a value that is not finite.
  [[nodiscard]] static Handle image(std::shared_ptr<const TextureImage> image, const TexturePlacement& placement = {},
                                    TextureWrap wrap = TextureWrap::repeat,
                                    TextureFilter filter = TextureFilter::bilinear, bool is_inverted = false) {
    return Texture::image(std::move(image), placement, {wrap, wrap}, filter, is_inverted);
  }
  /// `image` with a wrap of its own for s and for t.
  [[nodiscard]] static Handle image(std::shared_ptr<const TextureImage> image, const TexturePlacement& placement,
                                    const std::array<TextureWrap, 2>& wrap, TextureFilter filter,
                                    bool is_inverted = false) {
    const glm::ivec2 size = image->resolution;
    if (size.x < 1 || size.y < 1 || size.x > largest_side || size.y > largest_side)
      reject_argument("the image of a texture needs sides of 1 to 32768 pixels");
    Texture result(Kind::image);
    result.place(placement);
    result.wrap_ = wrap;
    result.filter_ = filter;
    result.is_inverted_ = is_inverted;
    result.image_ = std::move(image);
    glm::dvec3 sum(0);
    glm::vec3 lower(std::numeric_limits<float>::max()), upper(-std::numeric_limits<float>::max());
    for (int y = 0; y < size.y; ++y)
      for (int x = 0; x < size.x; ++x) {
        const glm::vec3 value = result.image_->texel(x, y);
        for (int c = 0; c < 3; ++c)
          if (!(std::abs(value[c]) <= 1e30F))
            reject_argument("the image of a texture has a value that is not finite or above 1e30");
        lower = glm::min(lower, value);
        upper = glm::max(upper, value);
        sum += glm::dvec3(value);
      }
    if (wrap[0] == TextureWrap::black || wrap[1] == TextureWrap::black)
      lower = glm::min(lower, glm::vec3(0)), upper = glm::max(upper, glm::vec3(0));
    const auto turned = [&](const Vec3<T>& v) { return is_inverted ? glm::max(Vec3<T>(1) - v, Vec3<T>(0)) : v; };
    result.lower_ = turned(Vec3<T>(is_inverted ? upper : lower));
    result.upper_ = turned(Vec3<T>(is_inverted ? lower : upper));
    const glm::dvec3 mean = sum / (double(size.x) * size.y);
    result.mean_ = is_inverted ? glm::max(1.0 - mean, glm::dvec3(0)) : mean;
    return std::make_shared<const Texture>(std::move(result));
  }

  /// `even` where the whole parts of s and t add up to an even number, else `odd`.
  [[nodiscard]] static Handle checkerboard(Handle even, Handle odd, const TexturePlacement& placement = {}) {
    Texture result(Kind::checkerboard);
    result.place(placement);
    result.lower_ = glm::min(even->lower_, odd->lower_);
    result.upper_ = glm::max(even->upper_, odd->upper_);
    result.mean_ = (even->mean_ + odd->mean_) / 2.0;
    result.parts_ = {std::move(even), std::move(odd), nullptr};
    return result.shared();
  }

  /// The product of two textures, channel by channel.
  [[nodiscard]] static Handle product(Handle a, Handle b) {
    if (a->is_constant() && b->is_constant()) return constant(a->mean_ * b->mean_);
    Texture result(Kind::product);
    const Vec3<T> ends[] = {a->lower_ * b->lower_, a->lower_ * b->upper_, a->upper_ * b->lower_, a->upper_ * b->upper_};
    result.lower_ = glm::min(glm::min(ends[0], ends[1]), glm::min(ends[2], ends[3]));
    result.upper_ = glm::max(glm::max(ends[0], ends[1]), glm::max(ends[2], ends[3]));
    result.mean_ = a->mean_ * b->mean_;
    result.parts_ = {std::move(a), std::move(b), nullptr};
    return result.shared();
  }

  /// first · (1 − a) + second · a, a the first channel of `amount`, cut to [0, 1].
  [[nodiscard]] static Handle mix(Handle first, Handle second, Handle amount) {
    const double share = std::clamp(mean_channel(amount->mean_), 0.0, 1.0);
    const glm::dvec3 mean = first->mean_ * (1 - share) + second->mean_ * share;
    if (first->is_constant() && second->is_constant() && amount->is_constant()) return constant(mean);
    Texture result(Kind::mix);
    result.lower_ = glm::min(first->lower_, second->lower_);
    result.upper_ = glm::max(first->upper_, second->upper_);
    result.mean_ = mean;
    result.parts_ = {std::move(first), std::move(second), std::move(amount)};
    return result.shared();
  }

  /// `inner` at the coordinates that are the first two channels of `coordinates`.
  [[nodiscard]] static Handle through(Handle coordinates, Handle inner) {
    if (inner->is_constant()) return inner;
    Texture result(Kind::through);
    result.lower_ = inner->lower_;
    result.upper_ = inner->upper_;
    result.mean_ = inner->mean_;
    result.parts_ = {std::move(coordinates), std::move(inner), nullptr};
    return result.shared();
  }

  /// 1 where the first channel is `cutoff` or more, else 0.
  [[nodiscard]] static Handle threshold(Handle part, double cutoff) {
    Texture result(Kind::threshold);
    result.lower_ = Vec3<T>(static_cast<double>(part->lower_.x) >= cutoff ? T(1) : T(0));
    result.upper_ = Vec3<T>(static_cast<double>(part->upper_.x) >= cutoff ? T(1) : T(0));
    if (result.lower_ == result.upper_) return constant(glm::dvec3(result.lower_));
    result.mean_ = glm::dvec3(part->mean_.x >= cutoff ? 1.0 : 0.0);
    result.cutoff_ = static_cast<T>(cutoff);
    result.parts_ = {std::move(part), nullptr, nullptr};
    return result.shared();
  }

  /// The value at these coordinates.
  [[nodiscard]] Vec3<T> at(const Vec2<T>& uv) const noexcept {
    switch (kind_) {
      case Kind::constant:
        return lower_;
      case Kind::image:
        return image_at(placed(uv));
      case Kind::checkerboard: {
        const Vec2<T> st = placed(uv);
        const bool is_odd = wrapped(std::floor(st.x) + std::floor(st.y), T(2)) >= T(1);
        return parts_[is_odd ? 1 : 0]->at(uv);
      }
      case Kind::product:
        return parts_[0]->at(uv) * parts_[1]->at(uv);
      case Kind::mix: {
        const T amount = std::clamp(parts_[2]->at(uv).x, T(0), T(1));
        return parts_[0]->at(uv) * (T(1) - amount) + parts_[1]->at(uv) * amount;
      }
      case Kind::threshold:
        return Vec3<T>(parts_[0]->at(uv).x >= cutoff_ ? T(1) : T(0));
      case Kind::through:
        return parts_[1]->at(Vec2<T>(parts_[0]->at(uv)));
    }
    return lower_;
  }

  /// A bound on all values, channel by channel, where u and v are between those of two corners.
  /// Only an image is looked at texel by texel, up to 65536 of them; other textures have `upper()`,
  /// products and mixtures what follows from their parts.
  [[nodiscard]] Vec3<T> upper_between(const Vec2<T>& low, const Vec2<T>& high) const noexcept {
    switch (kind_) {
      case Kind::image:
        return image_upper_between(low, high);
      case Kind::product:
        if (!(min_channel(parts_[0]->lower_) >= T(0) && min_channel(parts_[1]->lower_) >= T(0))) return upper_;
        return parts_[0]->upper_between(low, high) * parts_[1]->upper_between(low, high);
      case Kind::mix:
        return glm::max(parts_[0]->upper_between(low, high), parts_[1]->upper_between(low, high));
      default:
        return upper_;
    }
  }

  /// Number of textures in the tree; one that occurs several times counts each time, since each is
  /// a look-up.
  [[nodiscard]] double size() const noexcept { return size_; }
  /// One value everywhere.
  [[nodiscard]] bool is_constant() const noexcept { return kind_ == Kind::constant; }
  /// Bounds of every channel over all (u, v); they may be wider than need be.
  [[nodiscard]] const Vec3<T>& lower() const noexcept { return lower_; }
  /// A bound on all values, channel by channel.
  [[nodiscard]] const Vec3<T>& upper() const noexcept { return upper_; }
  /// About the mean, exact for one image or a constant.
  [[nodiscard]] const glm::dvec3& mean() const noexcept { return mean_; }

 private:
  enum class Kind : std::uint8_t { constant, image, checkerboard, product, mix, through, threshold };
  static constexpr int largest_side = 32768;

  explicit Texture(Kind kind) : kind_(kind) {}
  [[nodiscard]] Handle shared() {
    for (const Handle& part : parts_) size_ += part ? part->size_ : 0;
    return std::make_shared<const Texture>(std::move(*this));
  }

  void place(const TexturePlacement& placement) {
    scale_ = Vec2<T>(placement.scale);
    offset_ = Vec2<T>(placement.offset);
    cross_ = Vec2<T>(placement.cross);
  }
  [[nodiscard]] Vec2<T> placed(const Vec2<T>& uv) const noexcept {
    return uv * scale_ + Vec2<T>(uv.y, uv.x) * cross_ + offset_;
  }
  /// `x` modulo `period`, in [0, period).
  [[nodiscard]] static T wrapped(T x, T period) noexcept {
    const T rest = x - period * std::floor(x / period);
    return rest < period ? rest : T(0);
  }

  [[nodiscard]] Vec3<T> image_at(const Vec2<T>& st) const noexcept {
    const glm::ivec2 size = image_->resolution;
    // In texels from the upper left; whole numbers are the middles of texels.
    const T x = texels_from_edge(st.x, size.x, wrap_[0]);
    const T y = texels_from_edge(T(1) - st.y, size.y, wrap_[1]);
    Vec3<T> value;
    if (filter_ == TextureFilter::nearest) {
      value = texel(static_cast<int>(std::floor(x + T(0.5))), static_cast<int>(std::floor(y + T(0.5))));
    } else {
      const T left = std::floor(x), top = std::floor(y);
      const T right_share = x - left, bottom_share = y - top;
      const int column = static_cast<int>(left), row = static_cast<int>(top);
      const auto in_row = [&](int r) {
        return texel(column, r) * (T(1) - right_share) + texel(column + 1, r) * right_share;
      };
      value = in_row(row) * (T(1) - bottom_share) + in_row(row + 1) * bottom_share;
    }
    return is_inverted_ ? glm::max(Vec3<T>(1) - value, Vec3<T>(0)) : value;
  }
  /// Near enough to the image for an int; a coordinate that is no number is 0.
  [[nodiscard]] static T texels_from_edge(T s, int size, TextureWrap wrap) noexcept {
    T inside = std::clamp(s, T(-2), T(3));
    if (wrap == TextureWrap::repeat) inside = wrapped(s, T(1));
    if (wrap == TextureWrap::mirror) inside = T(1) - std::abs(T(1) - wrapped(s, T(2)));
    return (inside == inside ? inside : T(0)) * static_cast<T>(size) - T(0.5);
  }
  /// The number of the texel that stands for one beyond the image; −1 for none.
  [[nodiscard]] static int texel_number(int i, int size, TextureWrap wrap) noexcept {
    if (i >= 0 && i < size) return i;
    switch (wrap) {
      case TextureWrap::repeat:
        return i < 0 ? i + size : i - size;
      case TextureWrap::black:
        return -1;
      default:
        return std::clamp(i, 0, size - 1);
    }
  }
  [[nodiscard]] Vec3<T> texel(int column, int row) const noexcept {
    const int x = texel_number(column, image_->resolution.x, wrap_[0]);
    const int y = texel_number(row, image_->resolution.y, wrap_[1]);
    return x < 0 || y < 0 ? Vec3<T>(0) : Vec3<T>(image_->texel(x, y));
  }
  [[nodiscard]] Vec3<T> image_upper_between(const Vec2<T>& low, const Vec2<T>& high) const noexcept {
    constexpr int most = 1 << 16;
    const glm::ivec2 size = image_->resolution;
    Vec2<T> first(std::numeric_limits<T>::max()), last(-std::numeric_limits<T>::max());
    for (const Vec2<T>& corner : {low, Vec2<T>(low.x, high.y), Vec2<T>(high.x, low.y), high}) {
      const Vec2<T> st = placed(corner);
      const Vec2<T> texels(st.x * static_cast<T>(size.x), (T(1) - st.y) * static_cast<T>(size.y));
      first = glm::min(first, texels);
      last = glm::max(last, texels);
    }
    first = glm::floor(first - T(2));
    last = glm::ceil(last + T(2));
    const Vec2<T> extent = last - first;
    if (is_inverted_ || !(extent.x <= T(most) && extent.y <= T(most) && (extent.x + 1) * (extent.y + 1) <= T(most)) ||
        !(max_channel(Vec3<T>(glm::abs(first), T(0))) < T(1 << 20)))
      return upper_;
    // Whole periods are taken off beforehand: what is beyond the image then is at most one of them
    // away.
    const auto number = [](int i, int count, TextureWrap wrap) {
      if (wrap == TextureWrap::repeat) return ((i % count) + count) % count;
      if (wrap != TextureWrap::mirror) return texel_number(i, count, wrap);
      const int place = ((i % (2 * count)) + 2 * count) % (2 * count);
      return place < count ? place : 2 * count - 1 - place;
    };
    Vec3<T> upper(T(0));
    for (int row = static_cast<int>(first.y); row <= static_cast<int>(last.y); ++row)
      for (int column = static_cast<int>(first.x); column <= static_cast<int>(last.x); ++column) {
        const int x = number(column, size.x, wrap_[0]), y = number(row, size.y, wrap_[1]);
        if (x >= 0 && y >= 0) upper = glm::max(upper, Vec3<T>(image_->texel(x, y)));
      }
    return upper;
  }

  Kind kind_;
  double size_ = 1;
  T cutoff_ = 0;
  std::array<TextureWrap, 2> wrap_{};  ///< of s and of t
  TextureFilter filter_ = TextureFilter::bilinear;
  bool is_inverted_ = false;
  Vec2<T> scale_{1}, offset_{0}, cross_{0};
  Vec3<T> lower_{0}, upper_{0};
  glm::dvec3 mean_{0};
  std::shared_ptr<const TextureImage> image_;
  std::array<Handle, 3> parts_;
};

}  // namespace gmis::scene
