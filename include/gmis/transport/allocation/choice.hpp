#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "gmis/transport/allocation/forecast.hpp"

namespace gmis {

/// A pilot's choice of counts, with the forecasts that it rests on.
struct Choice {
  std::vector<Forecast> forecasts;        ///< one per candidate
  std::optional<std::size_t> chosen;      ///< index in `forecasts`; empty when the pilot analysed no pixel
  std::uint32_t expected_iterations = 0;  ///< length of the run for which the objective was minimised
  std::uint32_t pilot_iterations = 0;     ///< iterations of the pilot; they are not part of the picture
  double pilot_cost = 0.0;                ///< cost of all pilot iterations; unit: `OperationCosts`

  template <class Archive>
  void exchange_state(Archive& archive) {
    archive(forecasts, chosen, expected_iterations, pilot_iterations, pilot_cost);
  }
};

}  // namespace gmis
