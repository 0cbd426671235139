#pragma once

/// \file
/// Methods beyond the six schemes, each in a header of its own; docs/mis-methods.md says when which one pays.
/// gmis/mis.hpp does not include them.

#include "gmis/mis/adaptive_mis.hpp"
#include "gmis/mis/best_groups.hpp"
#include "gmis/mis/best_plan.hpp"
#include "gmis/mis/compensation.hpp"
#include "gmis/mis/control_variate.hpp"
#include "gmis/mis/correlation_aware.hpp"
#include "gmis/mis/counted_round.hpp"
#include "gmis/mis/counted_variance.hpp"
#include "gmis/mis/heretical_mixture.hpp"
#include "gmis/mis/marginal_density.hpp"
#include "gmis/mis/optimal_allocation.hpp"
#include "gmis/mis/optimal_weights.hpp"
#include "gmis/mis/pairwise.hpp"
#include "gmis/mis/population.hpp"
#include "gmis/mis/randomised_qmc.hpp"
#include "gmis/mis/resampling.hpp"
#include "gmis/mis/reservoir.hpp"
#include "gmis/mis/scrambled_sobol.hpp"
#include "gmis/mis/self_normalised.hpp"
#include "gmis/mis/stochastic_mis.hpp"
#include "gmis/mis/variance_aware.hpp"
#include "gmis/mis/weight_heuristic.hpp"
