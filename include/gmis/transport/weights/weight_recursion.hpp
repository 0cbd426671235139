#pragma once

#include <concepts>
#include <type_traits>
#include <utility>

#include "gmis/core/attributes.hpp"
#include "gmis/transport/weights/weight_formulas.hpp"

namespace gmis {

/// The sum over all techniques as one number. A weight is the share of one technique in it.
template <std::floating_point T>
struct WholeSum {
  using Sum = Extended<T>;
  using PlainSum = double;
  using Weight = T;

  /// A sum with one term: the density of `technique`.
  template <Technique technique>
  [[nodiscard]] static constexpr Sum of(Extended<T> density) noexcept {
    return density;
  }
  template <Technique technique>
  [[nodiscard]] static constexpr PlainSum of(double density) noexcept {
    return density;
  }
  /// own / (own + others), in [0, 1]; 0 when `own` is 0.
  [[nodiscard]] static constexpr Weight weight(const OwnAndOthers<Sum>& of) noexcept {
    return of.own.is_zero() ? T(0) : (of.own / (of.own + of.others)).value();
  }
  [[nodiscard]] static constexpr Weight weight(const OwnAndOthers<PlainSum>& of) noexcept {
    return of.own == 0.0 ? T(0) : static_cast<T>(of.own / (of.own + of.others));
  }
  /// True when the sum has the exponent 0.
  [[nodiscard]] static constexpr bool is_plain(const Sum& sum) noexcept { return sum.has_no_exponent(); }
  /// Its value, exactly; needs `is_plain`.
  [[nodiscard]] static constexpr PlainSum plain(const Sum& sum) noexcept { return static_cast<double>(sum.mantissa()); }
  /// The sum, rounded to the precision of `T`.
  [[nodiscard]] static constexpr Sum stored(PlainSum sum) noexcept { return Sum::rounded(sum); }
};

/// Forms partial sums and weights from densities and counts by `WeightFormulas`. `Sums` is
/// `WholeSum`, or `SeparateSums`, which keeps one sum per technique (weights_by_technique.hpp).
///
/// Partial sums are stored as `Extended` numbers. With `float`, the formulas are evaluated in plain
/// `double` where the partial sums that enter them have the exponent 0, as nearly always: they are
/// then 0 or between 2^-32 and 2^32, and no formula multiplies more than three factors with them or
/// with a count, each a density, a geometric factor or their inverses (10^±45), or, under the power
/// heuristic, its square. Nothing leaves 10^±300, so no number is normalised but those that are
/// stored. Otherwise the formulas are evaluated in `Extended` numbers.
template <std::floating_point T, class Heuristic = BalanceRatio, class Sums = WholeSum<T>>
class WeightRecursion {
  static constexpr bool has_plain_path = std::same_as<T, float>;
  using Exact = WeightFormulas<T, Heuristic, Extended<T>, typename Sums::Sum>;
  using PlainSum = typename Sums::PlainSum;
  using Plain = WeightFormulas<T, Heuristic, double, PlainSum>;
  struct Nothing {
    constexpr Nothing(const TechniqueCounts<T>&, Sums) noexcept {}
  };

 public:
  using Weight = typename Sums::Weight;
  using LightPartial = typename Exact::LightPartial;
  using CameraPartial = typename Exact::CameraPartial;

  /// The counts are nominal: functions of the path alone, constant while weights are formed.
  constexpr explicit WeightRecursion(const TechniqueCounts<T>& counts) noexcept
      : exact_(counts, Sums()), plain_(counts, Sums()) {}

  /// See `WeightFormulas::first_light_vertex`.
  [[nodiscard]] constexpr LightPartial first_light_vertex(LightStart<T> start, T to_origin) const noexcept {
    if constexpr (has_plain_path)
      return stored(plain_.first_light_vertex(start, to_origin));
    else
      return exact_.first_light_vertex(start, to_origin);
  }
  /// See `WeightFormulas::extend_light`.
  [[nodiscard]] constexpr LightPartial extend_light(const LightPartial& at, LightStep<T> step) const noexcept {
    if constexpr (has_plain_path)
      if (is_plain(at)) [[likely]]
        return stored(plain_.extend_light(plain(at), step));
    return exactly<&Exact::extend_light>(at, step);
  }
  /// See `WeightFormulas::first_camera_vertex`.
  [[nodiscard]] constexpr CameraPartial first_camera_vertex(T density) const noexcept {
    if constexpr (has_plain_path)
      return stored(plain_.first_camera_vertex(density));
    else
      return exact_.first_camera_vertex(density);
  }
  /// See `WeightFormulas::extend_camera`.
  [[nodiscard]] constexpr CameraPartial extend_camera(const CameraPartial& at, CameraStep<T> step) const noexcept {
    if constexpr (has_plain_path)
      if (is_plain(at)) [[likely]]
        return stored(plain_.extend_camera(plain(at), step));
    return exactly<&Exact::extend_camera>(at, step);
  }

  /// The weights of the techniques: see the members of `WeightFormulas` with the same names.
  [[nodiscard]] constexpr Weight seen_directly() const noexcept {
    if constexpr (has_plain_path)
      return Sums::weight(plain_.seen_directly());
    else
      return Sums::weight(exact_.seen_directly());
  }
  [[nodiscard]] constexpr Weight emitter_hit(const CameraPartial& at, LightStart<T> start) const noexcept {
    if constexpr (has_plain_path)
      if (is_plain(at)) [[likely]]
        return Sums::weight(plain_.emitter_hit(plain(at), start));
    return Sums::weight(exactly<&Exact::emitter_hit>(at, start));
  }
  [[nodiscard]] constexpr Weight next_event(LightStart<T> start, T hit, const CameraPartial& camera,
                                            CameraEnd<T> end) const noexcept {
    if constexpr (has_plain_path)
      if (is_plain(camera)) [[likely]]
        return Sums::weight(plain_.next_event(start, hit, plain(camera), end));
    return Sums::weight(exactly<&Exact::next_event>(start, hit, camera, end));
  }
  [[nodiscard]] constexpr Weight connect(const LightPartial& light, LightEnd<T> light_end, const CameraPartial& camera,
                                         CameraEnd<T> camera_end) const noexcept {
    if constexpr (has_plain_path)
      if (is_plain(light) && is_plain(camera)) [[likely]]
        return Sums::weight(plain_.connect(plain(light), light_end, plain(camera), camera_end));
    return Sums::weight(exactly<&Exact::connect>(light, light_end, camera, camera_end));
  }
  [[nodiscard]] constexpr Weight splat(const LightPartial& light, LightEnd<T> end) const noexcept {
    if constexpr (has_plain_path)
      if (is_plain(light)) [[likely]]
        return Sums::weight(plain_.splat(plain(light), end));
    return Sums::weight(exactly<&Exact::splat>(light, end));
  }
  [[nodiscard]] constexpr Weight merge(const LightPartial& light, T light_reverse, const CameraPartial& camera,
                                       CameraEnd<T> end) const noexcept {
    if constexpr (has_plain_path)
      if (is_plain(light) && is_plain(camera)) [[likely]]
        return Sums::weight(plain_.merge(plain(light), light_reverse, plain(camera), end));
    return Sums::weight(exactly<&Exact::merge>(light, light_reverse, camera, end));
  }

 private:
  /// A formula in `Extended` numbers, never inlined. It takes copies, so that what is passed need
  /// not be in memory where it is not called.
  template <auto formula, class... Arguments>
  [[nodiscard]] GMIS_ALWAYS_INLINE constexpr auto exactly(const Arguments&... of) const noexcept {
    if constexpr (has_plain_path)
      return rarely_called<formula>(of...);
    else
      return always_called<formula>(of...);
  }
  template <auto formula, class... Arguments>
  [[nodiscard]] GMIS_RARE constexpr auto rarely_called(Arguments... of) const noexcept {
    return (exact_.*formula)(of...);
  }
  template <auto formula, class... Arguments>
  [[nodiscard]] GMIS_NEVER_INLINE constexpr auto always_called(Arguments... of) const noexcept {
    return (exact_.*formula)(of...);
  }

  // `shared` of a camera vertex is one number, in every kind of sum.
  using OneNumber = WholeSum<T>;
  template <class Part>
  using KindOf = std::conditional_t<std::same_as<Part, Extended<T>> || std::same_as<Part, double>, OneNumber, Sums>;

  template <class Shared, class Sum>
  [[nodiscard]] static constexpr bool is_plain(const PartialSums<Shared, Sum>& at) noexcept {
    return KindOf<Shared>::is_plain(at.shared) && Sums::is_plain(at.chain);
  }
  template <class Shared, class Sum>
  [[nodiscard]] static constexpr auto plain(const PartialSums<Shared, Sum>& at) noexcept {
    const auto shared = KindOf<Shared>::plain(at.shared);
    return PartialSums<std::remove_const_t<decltype(shared)>, PlainSum>{shared, Sums::plain(at.chain)};
  }
  template <class Shared, class Sum>
  [[nodiscard]] static constexpr auto stored(const PartialSums<Shared, Sum>& of) noexcept {
    const auto shared = KindOf<Shared>::stored(of.shared);
    return PartialSums<std::remove_const_t<decltype(shared)>, typename Sums::Sum>{shared, Sums::stored(of.chain)};
  }

  Exact exact_;
  [[no_unique_address]] std::conditional_t<has_plain_path, Plain, Nothing> plain_;
};

}  // namespace gmis
