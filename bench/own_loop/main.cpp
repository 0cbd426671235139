// own_loop library|hand KIND N ROUNDS: N3 once; prints mean and variance. KIND: static (std::array)
// and dynamic (std::vector) of logistic proposals; dynamic ones whose densities need no call, one
// by one (`cauchy`), as a set of the library (`cauchy-side-by-side`) and in batches
// (`cauchy-batches`); logistic ones in these two ways (`side-by-side`, `batches`).
#include <cstdio>
#include <cstdlib>
#include <string_view>
#include <type_traits>

#include "own_loop/loops.hpp"

namespace {

template <std::size_t N>
own_loop::Result of_static(bool library, std::uint64_t rounds) {
  using P = bench::Logistic<double>;
  const auto list = own_loop::proposals<P>(N);
  std::array<P, N> set{};
  for (std::size_t k = 0; k < N; ++k) set[k] = list[k];
  return library ? own_loop::by_library(set, rounds, 1)
                 : own_loop::by_hand(set.data(), std::integral_constant<std::size_t, N>{}, rounds, 1);
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 5) return 2;
  const bool library = std::string_view(argv[1]) == "library";
  const std::string_view kind = argv[2];
  const auto n = static_cast<std::size_t>(std::atoi(argv[3]));
  const auto rounds = static_cast<std::uint64_t>(std::atoll(argv[4]));
  own_loop::Result result{};
  if (kind == "static") {
    switch (n) {
      case 1:
        result = of_static<1>(library, rounds);
        break;
      case 2:
        result = of_static<2>(library, rounds);
        break;
      case 4:
        result = of_static<4>(library, rounds);
        break;
      case 8:
        result = of_static<8>(library, rounds);
        break;
      case 16:
        result = of_static<16>(library, rounds);
        break;
      case 64:
        result = of_static<64>(library, rounds);
        break;
      default:
        return 2;
    }
  } else if (kind.starts_with("cauchy")) {
    const auto list = own_loop::proposals<own_loop::Cauchy>(n);
    if (!library)
      result = own_loop::by_hand(list.data(), n, rounds, 1);
    else if (kind == "cauchy-batches")
      result = own_loop::in_batches(list, rounds, 1);
    else if (kind == "cauchy-side-by-side")
      result = own_loop::by_library(own_loop::side_by_side<gmis::shapes::Cauchy, own_loop::Cauchy>(list), rounds, 1);
    else
      result = own_loop::by_library(list, rounds, 1);
  } else {
    const auto list = own_loop::proposals<bench::Logistic<double>>(n);
    const auto set = own_loop::side_by_side<gmis::shapes::Logistic, bench::Logistic<double>>(list);
    if (!library)
      result = own_loop::by_hand(list.data(), n, rounds, 1);
    else if (kind == "batches")
      result = own_loop::in_batches(set, rounds, 1);
    else if (kind == "side-by-side")
      result = own_loop::by_library(set, rounds, 1);
    else
      result = own_loop::by_library(list, rounds, 1);
  }
  std::printf("%.12g %.12g %llu\n", result.mean, result.variance, static_cast<unsigned long long>(result.unusable));
  return 0;
}
